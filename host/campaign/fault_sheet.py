"""The sheet of all faults: fired, detected after, effect, recovered; as table, CSV and HTML."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from host.campaign.campaign import Finished
from host.campaign.can_effect import CanEffect
from host.campaign.fault_effect import Effect, effect
from host.campaign.fault_plan import Strike
from host.campaign.page import heading, provenance
from host.campaign.row import FINISHED
from host.record.errors import UserError
from host.report.html import document, table
from host.report.numbers import NONE, number
from host.report.summary import Section

COLUMNS = (
    *("fault", "target", "at_s", "for_s", "parameters", "fired", "detected_after_s", "said"),
    *("worst_error_m", "usual_error_m", "without_solution_s", "degraded_s", "recovered_after_s"),
    *("worst_velocity_error_mps", "usual_velocity_error_mps"),
    *("worst_attitude_error_deg", "usual_attitude_error_deg"),
    *("can_frames_expected", "can_frames", "can_errors", "longest_can_gap_s", "usual_can_gap_s"),
    *("effect", "verdict", "error"),
)

NEVER = "never"
NO_WORD = "nothing"
NO_EFFECT = "no effect"
ABSENT = "none"
"""What the board, or the fault, does not have."""
NOTHING = (None, None, None)
WORDS_SHOWN = 36


def effects(finished: Finished, strikes: Sequence[Strike]) -> list[Effect]:
    """The line of each fault; the first run of the campaign is the one without. Raises UserError."""
    usual, *runs = finished.outcomes
    if usual.row["status"] != FINISHED:
        raise UserError(f"the run without a fault did not reach its end: {usual.row['error']}")
    made = []
    for strike, run in zip(strikes, runs, strict=True):
        if run.row["status"] == FINISHED:
            made.append(effect(strike, run.series, usual.series))
        else:
            nothing = Effect(
                strike, 0, None, "", NOTHING, NOTHING, 0.0, 0.0, None, error=str(run.row["error"])
            )
            made.append(nothing)
    return made


def verdict(found: Sequence[Effect]) -> str:
    """One line."""
    told = sum(one.detected_after_s is not None for one in found)
    survived = sum(one.verdict in ("recovered", "not told") for one in found)
    text = f"{survived} of {len(found)} faults struck and were recovered from; the board told of {told}"
    for name, words in (
        ("not told", "recovered from without a word"),
        ("told only", "told of, without an end or an effect to be seen"),
        ("not observed", "without an effect to be seen"),
    ):
        count = sum(one.verdict == name for one in found)
        text += f"; {count} {words}" if count else ""
    return text


def section(found: Sequence[Effect]) -> Section:
    """The table for people."""
    rows = tuple((one.strike.kind, one.strike.target, *_cells(one)) for one in found)
    columns = (
        *("fault", "target", "the board's first word", "verdict", "fired", "detected after, s"),
        *("error, m (usual)", "error, ° (usual)", "no solution, s"),
        *("CAN frames missing", "longest CAN gap, s", "recovered after, s"),
    )
    note = (
        "errors: largest horizontal and attitude error of a navigation solution from the strike to the end of"
        " the run, in brackets without the fault; CAN: frames of all identifiers against the run without the"
        " fault, gap between two frames of one identifier; recovered: solutions without a gap, no more than"
        " 5 m, 1 m/s and 3° worse than without the fault, and CAN frames in their usual rhythm; where neither"
        " suffered, the board's word that it is over; told only: that word did not come; not observed:"
        " nothing that is seen of the board changed, so nothing is known of its recovery"
    )
    return Section("Faults", columns, rows, words=4, note=note)


def _cells(one: Effect) -> tuple[str, ...]:
    can = one.can
    return (
        _short(one.said) or (NONE if one.error else NO_WORD),
        one.verdict,
        number(one.fired),
        _time(one, one.detected_after_s, number),
        f"{number(one.worst[0])} ({number(one.usual[0])})",
        f"{number(one.worst[2])} ({number(one.usual[2])})",
        number(one.without_solution_s),
        NONE if can is None else f"{can.expected - can.came:,} of {can.expected:,}",
        NONE if can is None else number(can.longest_gap_s),
        _recovery(one, number),
    )


def _time(one: Effect, after_s: float | None, text: Callable[[float | None], str]) -> str:
    """A time that did not come is never; of a run without an end nothing is known."""
    return NEVER if after_s is None and not one.error else text(after_s)


def _recovery(one: Effect, text: Callable[[float | None], str]) -> str:
    """Where nothing suffered and no word came there is nothing to recover from."""
    return NO_EFFECT if one.verdict == "not observed" else _time(one, one.recovered_after_s, text)


def effect_words(one: Effect) -> str:
    """What solutions and CAN frames suffered."""
    if one.error:
        return ""
    words = []
    if one.solutions_differ:
        named = zip(("m", "m/s", "°"), one.worst, one.usual, strict=True)
        errors = [f"{number(bad)} {unit} ({number(usual)})" for unit, bad, usual in named if bad is not None]
        words.append("worst errors (usual): " + (", ".join(errors) or "no navigation solution"))
    if one.without_solution_s:
        words.append(f"no solution for {number(one.without_solution_s)} s")
    if one.can is not None and one.can.differs:
        missing = one.can.expected - one.can.came
        words.append(
            f"CAN: {missing} of {one.can.expected} frames missing, {one.can.errors} errors,"
            f" longest gap {number(one.can.longest_gap_s)} s"
        )
    return "; ".join(words) or "none on solutions and CAN frames"


def left_out(cannot: Sequence[tuple[Strike, str]]) -> Section:
    """Faults that this board cannot take."""
    rows = tuple((strike.kind, strike.target, reason) for strike, reason in cannot)
    return Section("Not possible on this board", ("fault", "target", "why"), rows, words=3)


def sheet_csv(found: Sequence[Effect]) -> str:
    """A line for each fault; no cell is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in found:
        strike = one.strike
        parameters = " ".join(f"{name}={value:g}" for name, value in strike.parameters)
        given = (strike.kind, strike.target, strike.at_s, strike.duration_s, parameters)
        told = (one.fired, _time(one, one.detected_after_s, _rounded), one.said or NO_WORD)
        errors = map(_rounded, (one.worst[0], one.usual[0], one.without_solution_s, one.degraded_s))
        more = map(_rounded, (one.worst[1], one.usual[1], one.worst[2], one.usual[2]))
        recovered = _recovery(one, _rounded)
        said = (effect_words(one), one.verdict, one.error)
        row = (*given, *told, *errors, recovered, *more, *_can_columns(one.can), *said)
        writer.writerow([ABSENT if value is None or value == "" else value for value in row])
    return text.getvalue()


def _can_columns(can: CanEffect | None) -> tuple[object, ...]:
    if can is None:
        return ("",) * 5
    return (can.expected, can.came, can.errors, _rounded(can.longest_gap_s), _rounded(can.usual_gap_s))


def sheet_page(
    manifest: Mapping[str, Any], found: Sequence[Effect], cannot: Sequence[tuple[Strike, str]]
) -> str:
    """The sheet as a page of its own."""
    kind = "good" if all(one.ok for one in found) else "bad"
    tables = [section(found), left_out(cannot)]
    body = [heading(manifest, verdict(found), kind)]
    body += [table(one) for one in tables if one.rows]
    return document(f"{manifest['board']} · faults", [*body, provenance(manifest)], "")


def _short(text: str) -> str:
    return text if len(text) <= WORDS_SHOWN else text[: WORDS_SHOWN - 2].rstrip(" :,") + " …"


def _rounded(value: float | None) -> str:
    return "" if value is None else f"{value:.3f}"
