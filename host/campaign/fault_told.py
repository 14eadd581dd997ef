"""How a board tells of a fault: in words (TEXT frames), or in the counters of its STATUS frames alone."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.record.result import RunResult
from host.record.run_data import STATUS_COLUMNS

TOLD_WITHIN_S = 10.0
"""So long after its end a fault may be told of; later words are about something else."""
SAME_EVENT_S = 0.5
SAME_COUNT_S = 1.5
"""A counter may reach so much earlier what it reaches in the run without the fault."""


@dataclass(frozen=True, slots=True)
class Told:
    """What the board told of a fault. Times are s of the run."""

    first_s: float | None
    said: str
    last_s: float | None
    """Its last word about it, once the fault had ended; None: no such word."""


def told_course(result: RunResult) -> dict[str, Any]:
    """What is kept of a run."""
    assert result.data is not None
    status = result.data.status
    columns = np.stack([status.column(name) for name in STATUS_COLUMNS])
    return {
        "events": [[event.at_s, event.source, event.text] for event in result.events],
        "status": base64.b64encode(columns.astype("<f8").tobytes()).decode(),
    }


def told(at_s: float, ended_s: float, course: Mapping[str, Any], usual: Mapping[str, Any]) -> Told:
    """What it told from the strike on that it does not tell there in the run without the fault.

    Words count before counters: these are looked at only where no word came in time.
    """
    words = _unusual_words(at_s, course["events"], usual["events"])
    if not words or words[0][0] > ended_s + TOLD_WITHIN_S:
        counted = _unusual_count(at_s, ended_s + TOLD_WITHIN_S, _status(course), _status(usual))
        return Told(None, "", None) if counted is None else Told(*counted, None)
    first_s, said = words[0]
    back = [word_s for word_s, _text in words if word_s > max(ended_s, first_s)]
    return Told(first_s, said, max(back, default=None))


def _unusual_words(
    from_s: float, events: Sequence[Sequence[Any]], usual: Sequence[Sequence[Any]]
) -> list[tuple[float, str]]:
    words = []
    for at_s, source, text in events:
        if source != "board" or at_s < from_s:
            continue
        expected = any(
            other[1] == source and _words(other[2]) == _words(text) and abs(other[0] - at_s) < SAME_EVENT_S
            for other in usual
        )
        if not expected:
            words.append((at_s, text))
    return words


def _words(text: str) -> str:
    """Two events that differ in a figure only are the same event."""
    return re.sub(r"\d+", "0", text)


def _status(course: Mapping[str, Any]) -> NDArray[np.float64]:
    flat = np.frombuffer(base64.b64decode(course["status"]), dtype="<f8")
    return flat.reshape(len(STATUS_COLUMNS), -1)


def _unusual_count(
    from_s: float, to_s: float, status: NDArray[np.float64], usual: NDArray[np.float64]
) -> tuple[float, str] | None:
    """When a counter first rose more since the strike than in the run without the fault, and which."""
    t, usual_t = status[0], usual[0]
    if not len(t) or not len(usual_t):
        return None
    before = int(np.searchsorted(t, from_s))
    usual_before = int(np.searchsorted(usual_t, from_s))
    for k in range(before, int(np.searchsorted(t, to_s, "right"))):
        reach = max(int(np.searchsorted(usual_t, t[k] + SAME_COUNT_S, "right")), usual_before + 1)
        rise = status[1:, k] - status[1:, max(before - 1, 0)]
        allowed = usual[1:, :reach].max(axis=1) - usual[1:, max(usual_before - 1, 0)]
        more = rise - np.maximum(allowed, 0.0)
        if more.max() > 0:
            place = int(np.argmax(more))
            return float(t[k]), f"STATUS: {STATUS_COLUMNS[1 + place]} +{rise[place]:.0f}"
    return None
