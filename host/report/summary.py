"""The tables of a run's result, as text: the terminal and the report show the same ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from host.record.result import Expectation, RunResult
from host.report.numbers import NONE, count, number, percent

MET, NOT_MET = "OK", "NOT MET"


@dataclass(frozen=True, slots=True)
class Section:
    """One table. Columns after the first `words` ones, verdicts apart, hold numbers, set to the right."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: int = 1
    note: str = ""

    def is_text(self, place: int) -> bool:
        """Whether this column is set to the left."""
        return place < self.words or self.columns[place] == "verdict"


ERRORS = (
    ("horizontal position", "position_horizontal", "m"),
    ("vertical position", "position_vertical", "m"),
    ("velocity, 3-D", "velocity", "mps"),
    ("velocity, horizontal", "velocity_horizontal", "mps"),
    ("roll", "roll", "deg"),
    ("pitch", "pitch", "deg"),
    ("yaw", "yaw", "deg"),
)
UNITS = {"m": "m", "mps": "m/s", "deg": "°"}


def sections(result: RunResult) -> list[Section]:
    """All tables that have anything to say, the verdict first."""
    made = [
        _expectations(result),
        _errors(result) if _scored_beside_gnss(result) else _errors_alone(result),
        _quality(result),
        _outages(result),
        *_recording(result),
        _ages(result),
        _processors(result),
        _tasks(result),
        _buses(result),
        _faults(result),
        _events(result),
    ]
    return [section for section in made if section.rows]


def verdict(result: RunResult) -> str:
    """One line: are the expectations met?"""
    total = len(result.expectations)
    missed = sum(not expectation.ok for expectation in result.expectations)
    if total == 0:
        return "no expectations set"
    if missed == 0:
        return f"all {total} expectations met" if total > 1 else "the expectation is met"
    return f"{missed} of {total} expectations NOT MET"


def limit_text(expectation: Expectation) -> str:
    """The limit as it is shown: `≤ 0.1`, or `≤ 1.93 (gnss.position_horizontal_rms_m)`."""
    sign = {"<=": "≤", ">=": "≥"}[expectation.relation]
    exact = expectation.limit is not None and expectation.limit_name is None
    text = f"{sign} {expectation.limit:g}" if exact else f"{sign} {number(expectation.limit)}"
    return text if expectation.limit_name is None else f"{text} ({expectation.limit_name})"


def _expectations(result: RunResult) -> Section:
    rows = tuple(
        (one.name, limit_text(one), number(one.value), MET if one.ok else NOT_MET)
        for one in result.expectations
    )
    return Section("Expectations", ("figure", "limit", "value", "verdict"), rows, words=2)


def _errors(result: RunResult) -> Section:
    rows = []
    for label, name, unit in ERRORS:
        figures = [f"{name}_{figure}_{unit}" for figure in ("rms", "p95", "max")]
        fused = [result.metrics.get(figure) for figure in figures]
        alone = [result.gnss.get(figure) for figure in figures]
        if any(value is not None for value in fused + alone):
            rows.append((f"{label}, {UNITS[unit]}", *map(number, fused), *map(number, alone)))
    columns = ("error", "fused RMS", "95 %", "max", "GNSS alone RMS", "95 %", "max")
    note = (
        f"{count(result.metrics.get('epochs'))} epochs: GNSS valid, 10 s after re-acquisition, "
        "a while after alignment; the same for both"
    )
    return Section("Errors against the truth", columns, tuple(rows), note=note)


def _scored_beside_gnss(result: RunResult) -> bool:
    """Whether there were epochs of a receiver to score on."""
    return any(result.gnss.get(f"{name}_rms_{unit}") is not None for _, name, unit in ERRORS)


def _errors_alone(result: RunResult) -> Section:
    """For a board without receiver all its solutions; without a fix those from a while after alignment."""
    without_receiver = any(result.metrics.get(f"{name}_rms_{unit}") is not None for _, name, unit in ERRORS)
    head = "" if without_receiver else "continuous_"
    rows = []
    for label, name, unit in ERRORS:
        figures = [result.metrics.get(f"{head}{name}_{figure}_{unit}") for figure in ("rms", "p95", "max")]
        if any(value is not None for value in figures):
            rows.append((f"{label}, {UNITS[unit]}", *map(number, figures)))
    begin = "the end of the alignment" if without_receiver else "a while after alignment"
    note = f"every solution from {begin} on; there are no epochs of a receiver to score on"
    return Section("Errors against the truth", ("error", "RMS", "95 %", "max"), tuple(rows), note=note)


def _quality(result: RunResult) -> Section:
    figures = result.metrics
    rows = [
        ("NEES mean (honest: 9)", number(figures.get("nees_mean"))),
        ("NEES 95 % (honest: 16.9)", number(figures.get("nees_p95"))),
        ("aligned after, s", number(figures.get("aligned_at_s"))),
        ("solution available", percent(figures.get("availability"))),
        ("GNSS fix", percent(result.gnss.get("fix_share"))),
        ("epochs without solution", count(figures.get("epochs_without_solution"))),
    ]
    if _scored_beside_gnss(result) and figures.get("continuous_position_horizontal_max_m") is not None:
        label = "horizontal error, outages included: RMS / max, m"
        rms = number(figures.get("continuous_position_horizontal_rms_m"))
        rows.append((label, f"{rms} / {number(figures.get('continuous_position_horizontal_max_m'))}"))
    shown = tuple(row for row in rows if row[1] != NONE)
    return Section("Consistency and coverage", ("figure", "value"), shown)


def _outages(result: RunResult) -> Section:
    rows = tuple(
        (
            number(one.start_s),
            number(one.duration_s),
            number(one.horizontal_error_at_start_m),
            number(one.horizontal_drift_m),
            number(one.vertical_drift_m),
        )
        for one in result.outages
    )
    columns = ("start, s", "duration, s", "error at start, m", "at end, m", "vertical, m")
    median = result.metrics.get("outage_horizontal_drift_median_m")
    note = "horizontal position error when GNSS goes and when it comes back"
    if median is not None:
        note += f"; median at the end {number(median, 'm')}"
    return Section("GNSS outages", columns, rows, words=0, note=note)


def _recording(result: RunResult) -> list[Section]:
    fits = result.recording or {}
    if "fused" not in fits:
        return []
    rows = tuple(_fit_row(label, fits[key]) for label, key in (("fused", "fused"), ("GNSS alone", "gnss")))
    columns = (
        *("solution", "time shift, s", "offset forward, m", "right, m", "down, m"),
        *("horizontal RMS before, m", "after, m", "vertical before, m", "after, m"),
    )
    note = "one constant time shift and one constant body-frame offset fitted to each"
    attitude = fits["attitude"]
    mounting = attitude["mounting_deg"]
    turned = tuple(
        (axis, number(mounting[axis]), number(attitude[f"after_{axis}_rms_deg"]))
        for axis in ("roll", "pitch", "yaw")
    )
    return [
        Section("Recording: constants of the reference", columns, rows, note=note),
        Section("Recording: mounting", ("axis", "constant, °", "RMS without it, °"), turned),
    ]


def _fit_row(label: str, fit: Mapping[str, Any]) -> tuple[str, ...]:
    kinds = ("horizontal", "vertical")
    figures = [fit[f"{when}_position_{kind}_rms_m"] for kind in kinds for when in ("before", "after")]
    return (label, number(fit["time_shift_s"]), *map(number, fit["offset_frd_m"]), *map(number, figures))


AGES = (
    ("sample to first bit of the solution", "age_of_data"),
    ("sample to the solution's epoch", "sample_to_epoch"),
    ("epoch to first bit", "epoch_to_line"),
)


def _ages(result: RunResult) -> Section:
    """Of boards whose sensors tell when a sample was taken."""
    rows = []
    for label, name in AGES:
        figures = [result.metrics.get(f"{name}_{figure}_us") for figure in ("mean", "p95", "max")]
        if figures[0] is not None:
            rows.append((label, *map(number, figures)))
    note = "sample: the oldest of the newest of all chips, by their own instants; first bit: on the host line"
    return Section("Age of data", ("µs", "mean", "95 %", "max"), tuple(rows), note=note)


def _processors(result: RunResult) -> Section:
    rows = tuple(
        (
            cpu.name,
            percent(cpu.load),
            count(cpu.deadline_misses),
            count(cpu.overruns),
            count(cpu.stack_worst_bytes),
            count(cpu.resets),
        )
        for cpu in result.cpu
    )
    columns = ("processor", "load", "misses", "overruns", "stack, bytes", "resets")
    return Section("Processors", columns, rows, note="deadline misses; worst stack of nested interrupts")


def _tasks(result: RunResult) -> Section:
    rows = tuple(
        (
            task.name if len(result.cpu) == 1 else f"{cpu.name}.{task.name}",
            count(task.activations),
            percent(task.load),
            number(task.worst_busy_us),
            number(task.worst_response_us),
            number(task.deadline_us),
            count(task.deadline_misses),
            count(task.overruns),
        )
        for cpu in result.cpu
        for task in cpu.tasks
        if task.activations
    )
    columns = (
        *("task", "activations", "load", "worst run, µs", "worst response, µs"),
        *("deadline, µs", "misses", "overruns"),
    )
    return Section("Tasks", columns, rows)


def _buses(result: RunResult) -> Section:
    rows = tuple(
        (bus.name, percent(bus.load), count(bus.transactions), count(bus.bytes), count(bus.errors))
        for bus in result.buses
    )
    return Section("Buses", ("bus", "busy", "transactions", "bytes", "errors"), rows)


def _faults(result: RunResult) -> Section:
    rows = tuple(
        (
            *(one.name, one.kind, one.target, number(one.at_s)),
            number(one.duration_s),
            count(one.fired) if one.fired else "never",
        )
        for one in result.faults
    )
    columns = ("fault", "kind", "target", "at, s", "for, s", "fired")
    return Section("Faults", columns, rows, words=3)


def _events(result: RunResult) -> Section:
    rows = tuple((f"{event.at_s:.3f}", event.source, event.text) for event in result.events)
    return Section("Events", ("at, s", "source", "what happened"), rows, words=3)
