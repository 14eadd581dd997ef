"""What a fault did to the frames of the CAN buses; the run without it tells what should have come."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from host.record.can_course import CanCourse
from host.record.result import RunResult

FEWER = 1
"""A second may hold so many frames fewer than usual: its borders cut the rhythm anywhere."""
LONGER_GAP_S = 0.5


@dataclass(frozen=True, slots=True)
class CanEffect:
    """Of all buses and identifiers together, from the strike to the end of the run."""

    expected: int
    """Frames that came in the run without the fault."""
    came: int
    longest_gap_s: float
    """Between two frames of one identifier."""
    usual_gap_s: float
    errors: int
    """Error frames on the bus, that is attempts that failed, beyond those of the run without."""
    recovered_after_s: float | None
    """Until every identifier came in its usual rhythm again, to the second; None: never."""

    @property
    def differs(self) -> bool:
        """Whether the frames suffered."""
        return self.errors > 0 or self.recovered_after_s != 0.0 or self.came != self.expected


def can_course(result: RunResult) -> dict[str, Any]:
    """What is kept of a run."""
    assert result.data is not None
    buses = {course.bus for course in result.data.can}
    return {
        "errors": sum(use.errors for use in result.buses if use.name in buses),
        "frames": {_name(course): course.frames.tolist() for course in result.data.can},
        "gaps": {_name(course): np.round(course.gaps, 6).tolist() for course in result.data.can},
    }


def can_effect(
    at_s: float, settled_by_s: float, course: Mapping[str, Any], usual: Mapping[str, Any]
) -> CanEffect | None:
    """The effect from the courses of the run with the fault and of the run without; None: it has no CAN.

    An identifier counts as recovered when its last bad second ends before `settled_by_s`.
    """
    if not usual["frames"]:
        return None
    first = int(at_s)
    expected = came = 0
    longest = usual_longest = last_bad = 0.0
    for name, frames in usual["frames"].items():
        seconds = len(frames)
        wanted = np.array(frames[first:])
        there = np.array(course["frames"].get(name, [0] * seconds)[first:])
        gaps = np.array(course["gaps"].get(name, _never(seconds))[first:])
        usual_gaps = np.array(usual["gaps"][name][first:])
        expected += int(wanted.sum())
        came += int(there.sum())
        longest = max(longest, *gaps.tolist())
        usual_longest = max(usual_longest, *usual_gaps.tolist())
        bad = np.flatnonzero((there < wanted - FEWER) | (gaps > usual_gaps.max() + LONGER_GAP_S))
        if len(bad):
            last_bad = max(last_bad, first + float(bad[-1]) + 1)
    recovered = None if last_bad > settled_by_s else max(0.0, last_bad - at_s)
    errors = max(0, course["errors"] - usual["errors"])
    return CanEffect(expected, came, longest, usual_longest, errors, recovered)


def _name(course: CanCourse) -> str:
    return f"{course.bus} {course.identifier:#x}"


def _never(seconds: int) -> Sequence[float]:
    """Gaps of an identifier that did not come at all."""
    return [0.0] * (seconds - 1) + [float(seconds)]
