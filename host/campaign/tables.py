"""The tables of a campaign, as text: the terminal and the report show the same ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from host.campaign.statistics import Spread, spread
from host.campaign.summary import SetupSummary, Summary
from host.report.numbers import NONE, count, counted, number
from host.report.summary import MET, NOT_MET, Section

MAIN = {
    "position_horizontal_rms_m": "horizontal position RMS, m",
    "position_vertical_rms_m": "vertical position RMS, m",
    "velocity_rms_mps": "velocity RMS, m/s",
    "roll_rms_deg": "roll RMS, °",
    "pitch_rms_deg": "pitch RMS, °",
    "yaw_rms_deg": "yaw RMS, °",
    "nees_mean": "NEES mean (honest: 9)",
    "outage_horizontal_drift_median_m": "outage drift, median of a run, m",
    "outage_horizontal_drift_max_m": "outage drift, largest of a run, m",
    "gnss.position_horizontal_rms_m": "GNSS alone: horizontal RMS, m",
    "availability": "solution available, share",
    "aligned_at_s": "aligned after, s",
    "deadline_misses": "deadline misses",
    "overruns": "overruns",
}
SIDE_BY_SIDE = {
    "position_horizontal_rms_m": "horizontal, m",
    "velocity_rms_mps": "velocity, m/s",
    "roll_rms_deg": "roll, °",
    "pitch_rms_deg": "pitch, °",
    "yaw_rms_deg": "yaw, °",
    "nees_mean": "NEES",
    "deadline_misses": "misses",
    "overruns": "overruns",
}
FAILURES_SHOWN = 10


def sections(summary: Summary) -> list[Section]:
    """All tables that have anything to say."""
    made = [_expectations(summary)]
    if len(summary.setups) > 1:
        made += [_comparison(summary), _changes(summary)]
    if len(summary.setups) <= 3:
        made += [figure_table(one) for one in summary.setups]
    made.append(_failures(summary))
    return [section for section in made if section.rows]


def verdict(summary: Summary) -> str:
    """One line."""
    failed = f", {len(summary.failures)} did not reach their end" if summary.failures else ""
    if not any(one.expectations for one in summary.setups) and not failed:
        return f"{counted(summary.runs, 'run')}, no expectations set"
    return f"{summary.met:,} of {counted(summary.runs, 'run')} met all expectations{failed}"


def figure_table(one: SetupSummary) -> Section:
    """The spread of the main figures of one set-up."""
    labels = shown((one,), MAIN)
    rows = tuple((label, *_spread_cells(one.figures[name])) for name, label in labels.items())
    columns = ("figure", "mean", "95 % interval of the mean", "median", "95 %", "least", "largest", "runs")
    return Section(f"Over {counted(one.runs, 'run')}: {one.setup.label}", columns, rows)


def shown(setups: Sequence[SetupSummary], usual: Mapping[str, str]) -> dict[str, str]:
    """The usual figures that there are, by name, with their labels; and those that expectations are set for.

    Where nothing is scored beside GNSS, the figure over all solutions (`continuous_…`) stands in.
    """
    there = {name for one in setups for name in one.figures}
    labels = {}
    for name, label in usual.items():
        if name in there:
            labels[name] = label
        elif f"continuous_{name}" in there:
            labels[f"continuous_{name}"] = label
    expected = [name for one in setups for name in one.expectations if name in there]
    return labels | {name: name for name in expected if name not in labels}


def interval(value: Spread) -> str:
    """The confidence interval of the mean."""
    return NONE if value.low is None else f"{number(value.low)} … {number(value.high)}"


def _spread_cells(value: Spread) -> tuple[str, ...]:
    rest = (value.median, value.p95, value.minimum, value.maximum)
    return (number(value.mean), interval(value), *map(number, rest), count(value.count))


def _expectations(summary: Summary) -> Section:
    rows = tuple(
        (one.setup.label, name, f"{met:,} of {one.runs:,}", MET if met == one.runs else NOT_MET)
        for one in summary.setups
        for name, met in one.expectations.items()
    )
    return Section("Expectations", ("set-up", "figure", "runs that met it", "verdict"), rows, words=2)


def _comparison(summary: Summary) -> Section:
    labels = shown(summary.setups, SIDE_BY_SIDE)
    keys = [key for key, _ in summary.setups[0].setup.swept]
    rows = tuple(
        (
            one.setup.profile,
            *(value for _, value in one.setup.swept),
            *(count(one.runs), *(_mean(one.figures.get(name)) for name in labels)),
        )
        for one in summary.setups
    )
    columns = ("profile", *keys, "runs", *labels.values())
    note = "RMS errors, deadline misses and lost requests: mean, ± half of its 95 % interval"
    return Section("Set-ups side by side", columns, rows, words=1 + len(keys), note=note)


def _changes(summary: Summary) -> Section:
    """What each set-up changes against the first one of its profile, seed by seed."""
    keys = [key for key, _ in summary.setups[0].setup.swept]
    labels = shown(summary.setups, SIDE_BY_SIDE)
    rows = []
    for one in summary.setups:
        first = next(other for other in summary.setups if other.setup.profile == one.setup.profile)
        if first is one:
            continue
        values = [value for _, value in one.setup.swept]
        cells = [_paired(first.by_seed(name), one.by_seed(name)) for name in labels]
        rows.append((one.setup.profile, *values, *cells))
    columns = ("profile", *keys, *labels.values())
    note = "paired over the seeds, against the first row of the same profile; ± half of the 95 % interval"
    return Section("Differences", columns, tuple(rows), words=1 + len(keys), note=note)


def _paired(before: Mapping[int, float], now: Mapping[int, float]) -> str:
    differences = [now[seed] - before[seed] for seed in sorted({*before} & {*now})]
    return _mean(spread(differences)) if differences else NONE


def _mean(value: Spread | None) -> str:
    if value is None:
        return NONE
    if value.high is None:
        return number(value.mean)
    return f"{number(value.mean)} ± {number(value.high - value.mean)}"


def _failures(summary: Summary) -> Section:
    rows = summary.failures[:FAILURES_SHOWN]
    left = len(summary.failures) - len(rows)
    note = f"and {left} more in the result file" if left else ""
    return Section("Runs that did not reach their end", ("run", "error"), rows, words=2, note=note)
