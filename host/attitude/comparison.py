"""One run over recordings: every filter on every recording, scored alike, in one table."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, Final

from firmware.nav.drift.settings import DriftSettings
from host.attitude.estimates import Estimate, UnsupportedRateError, by_drift_filter
from host.attitude.peers import by_peer
from host.attitude.recording import AttitudeRecording
from host.attitude.regaining import LIMIT_DEG, Regaining, regaining
from host.attitude.register_feed import CHIPS, by_register_feed
from host.attitude.scoring import AttitudeScore, attitude_errors
from host.report.summary import Section

OURS: Final = "navtwin"
DIRECT: Final = "direct"
FEEDS: Final = (DIRECT, *CHIPS)
RESULT_FORMAT: Final = "navtwin-attitude-1"
NO_FIGURE = "–"


@dataclass(frozen=True, slots=True)
class Contender:
    """A filter and how it is fed."""

    filter: str
    feed: str
    arithmetic: str
    estimate: Callable[[AttitudeRecording], Estimate]


@dataclass(frozen=True, slots=True)
class Result:
    """One contender on one recording."""

    recording: str
    contender: Contender
    score: AttitudeScore
    regaining: Regaining | None
    """None when nobody looked for saturation."""
    left_out: str | None = None
    """Why there are no figures."""


def contenders(
    feeds: Sequence[str], peers: Sequence[str], settings: DriftSettings, arithmetics: Sequence[str]
) -> list[Contender]:
    """Ours over every feed (direct feed in every arithmetic, chips in float32), then the peers."""
    made = []
    for feed in feeds:
        if feed == DIRECT:
            made += [
                Contender(OURS, feed, name, partial(by_drift_filter, settings=settings, arithmetic=name))
                for name in arithmetics
            ]
        else:
            made.append(Contender(OURS, feed, "float32", partial(by_register_feed, feed, settings=settings)))
    return made + [Contender(peer, DIRECT, "its own", partial(by_peer, peer)) for peer in peers]


def compared(recording: AttitudeRecording, contender: Contender) -> Result:
    """Run and score one contender."""
    try:
        estimate = contender.estimate(recording)
    except UnsupportedRateError as error:
        return Result(recording.name, contender, AttitudeScore(*[float("nan")] * 3), None, str(error))
    errors = attitude_errors(estimate.quaternions, recording.reference)
    regained = None
    if estimate.saturated is not None:
        regained = regaining(estimate.saturated, errors.total, recording.interval)
    return Result(recording.name, contender, errors.rms(recording.movement), regained)


def table(results: Sequence[Result]) -> Section:
    """All results, the mean over all recordings of each contender at the end."""
    rows = [(r.recording, *_who(r.contender), *_errors(r.score), *_saturation(r.regaining)) for r in results]
    if len({r.recording for r in results}) > 1:
        means = [
            (f"mean of {n}", *_who(contender), *_errors(score), "", "", "", "")
            for contender, score, n in averages(results)
        ]
        rows += means
    columns = ("recording", "filter", "feed", "total", "heading", "inclination")
    return Section(
        "Attitude errors, RMS over the movement, °",
        (*columns, "saturated", "times", f"below {LIMIT_DEG:g}° again", "at the end"),
        tuple(rows),
        words=3,
        note="against the optical reference, as the BROAD data set defines them; nothing is fitted",
    )


def averages(results: Sequence[Result]) -> list[tuple[Contender, AttitudeScore, int]]:
    """Mean errors of every contender, over so many recordings."""
    by_contender: dict[int, list[Result]] = {}
    for result in results:
        if result.left_out is None:
            by_contender.setdefault(id(result.contender), []).append(result)
    found = []
    for group in by_contender.values():
        n = len(group)
        mean = [
            sum(getattr(r.score, name) for r in group) / n for name in ("total", "heading", "inclination")
        ]
        found.append((group[0].contender, AttitudeScore(*mean), n))
    return found


def to_dict(results: Sequence[Result]) -> dict[str, Any]:
    """All figures, for programs."""
    return {
        "format": RESULT_FORMAT,
        "results": [
            {
                "recording": r.recording,
                **_named(r.contender),
                **_rounded(r.score),
                "saturation": asdict(r.regaining) if r.regaining is not None else None,
                "left_out": r.left_out,
            }
            for r in results
        ],
        "means": [
            {**_named(contender), "recordings": n, **_rounded(score)}
            for contender, score, n in averages(results)
        ],
    }


def _who(contender: Contender) -> tuple[str, str]:
    arithmetic = f", {contender.arithmetic}" if contender.filter == OURS else ""
    return contender.filter + arithmetic, contender.feed


def _named(contender: Contender) -> dict[str, str]:
    return {"filter": contender.filter, "feed": contender.feed, "arithmetic": contender.arithmetic}


def _rounded(score: AttitudeScore) -> dict[str, float | None]:
    return {
        f"{name}_rms_deg": None if math.isnan(value) else round(value, 6)
        for name, value in asdict(score).items()
    }


def _errors(score: AttitudeScore) -> tuple[str, ...]:
    values = (score.total, score.heading, score.inclination)
    return tuple(NO_FIGURE if math.isnan(value) else f"{value:.2f}" for value in values)


def _saturation(regained: Regaining | None) -> tuple[str, str, str, str]:
    """Saturated samples, how many times, after how many of them regained, and how long after the last one."""
    if regained is None:
        return (NO_FIGURE,) * 4
    if not regained.samples:
        return "0", "", "", ""
    last = regained.after_last_s
    after = "never" if last is None else f"{last:.2f} s"
    return str(regained.samples), str(regained.episodes), str(regained.regained), after
