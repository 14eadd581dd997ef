"""Charts of many runs: envelopes of the errors, and whether the filter's own σ are honest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from host.campaign.campaign import Finished
from host.campaign.curves import error_curves
from host.campaign.plan import Setup
from host.campaign.series import NEES, NORMALISED, instants, unpacked
from host.campaign.statistics import mean_square_bounds, nan_mean, rms
from host.campaign.summary import Summary
from host.report.charts import BAND, FUSED, GNSS, TRUTH, Chart, Trace, line, on_row, stacked
from host.report.numbers import counted
from host.score.consistency import DIMENSION

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]
"""Of one set-up: each column with a row a run and the common instants as columns."""

RUNS_DRAWN = 25
SETUPS_DRAWN = 4
FAINT = "rgba(90,100,112,0.25)"

GROUPS = (
    (
        "position",
        "Position error",
        (
            ("north, m", "error_north_m", "sigma_north_m"),
            ("east, m", "error_east_m", "sigma_east_m"),
            ("down, m", "error_down_m", "sigma_down_m"),
        ),
    ),
    (
        "velocity",
        "Velocity error",
        (
            ("north, m/s", "error_v_north_mps", "sigma_v_north_mps"),
            ("east, m/s", "error_v_east_mps", "sigma_v_east_mps"),
            ("down, m/s", "error_v_down_mps", "sigma_v_down_mps"),
        ),
    ),
    (
        "attitude",
        "Attitude error",
        (
            ("roll, °", "error_roll_deg", "sigma_psi_n_deg"),
            ("pitch, °", "error_pitch_deg", "sigma_psi_e_deg"),
            ("yaw, °", "error_yaw_deg", "sigma_psi_d_deg"),
        ),
    ),
)

INNOVATION_LABELS = ("north", "east", "down", "v north", "v east", "v down")


def charts(finished: Finished, summary: Summary) -> list[Chart]:
    """All charts that there are data for; of the first few set-ups when there are many."""
    made = error_curves(summary)
    for place, setup in enumerate(list(finished.plan.setups())[:SETUPS_DRAWN]):
        duration_s, columns = _columns(finished, setup)
        if columns:
            several = len(summary.setups) > 1
            made += _of_setup(f"{place}", setup.label if several else "", instants(duration_s), columns)
    return made


def _columns(finished: Finished, setup: Setup) -> tuple[float, Columns]:
    """The series of all runs of a set-up that have the same length, which is that of the first one."""
    series = [
        outcome.series
        for outcome, job in zip(finished.outcomes, _jobs_of(finished), strict=True)
        if job == setup and outcome.series
    ]
    if not series:
        return 0.0, {}
    duration_s = float(series[0]["duration_s"])
    runs = [unpacked(one) for one in series if one["duration_s"] == duration_s]
    return duration_s, {name: np.array([run[name] for run in runs]) for name in runs[0]}


def _jobs_of(finished: Finished) -> list[Setup]:
    setups = [setup for setup in finished.plan.setups() for _ in finished.plan.seeds]
    return [setups[outcome.number] for outcome in finished.outcomes]


def _of_setup(key: str, label: str, t: Floats, columns: Columns) -> list[Chart]:
    made = [_envelope(f"{name}{key}", title, label, rows, t, columns) for name, title, rows in GROUPS]
    if np.isfinite(columns[NEES]).any():
        made.append(_nees(f"nees{key}", label, t, columns[NEES]))
    if any(np.isfinite(columns[name]).any() for name in NORMALISED):
        made.append(_innovations(f"innovations{key}", label, t, columns))
    return made


def _titled(title: str, label: str) -> str:
    return f"{title}: {label}" if label else title


def _envelope(
    key: str, title: str, label: str, rows: Sequence[tuple[str, str, str]], t: Floats, columns: Columns
) -> Chart:
    """Single runs, the 3 σ of all runs around their mean, and the 3 σ that the filter says of itself."""
    traces: list[Trace] = []
    ranges: list[list[float] | None] = []
    count = len(columns[rows[0][1]])
    for place, (_, error, sigma) in enumerate(rows):
        values, own = columns[error], 3 * rms(columns[sigma])
        mean, spread = nan_mean(values), 3 * _deviation(values)
        traces += _filter_band(t, own, place)
        for run in values[:RUNS_DRAWN]:
            faint = line(plain(t), plain(run), "single runs", FAINT, width=0.8, hoverinfo="skip")
            traces.append(_shown_once(on_row(faint, place), traces))
        for edge in (mean - spread, mean + spread):
            traced = line(plain(t), plain(edge), "mean ± 3 σ of the runs", GNSS, width=1.4)
            traces.append(_shown_once(on_row(traced, place), traces))
        traces.append(on_row(line(plain(t), plain(mean), "mean", FUSED), place))
        ranges.append(_focus(values))
    text = (
        f"{counted(count, 'run')}. Band: the 3 σ that the filter states (RMS over the runs); orange: 3 σ of"
        " the runs themselves. An honest filter has both alike."
    )
    labels = [name for name, _, _ in rows]
    return Chart(key, _titled(title, label), text, traces, stacked(labels, _span(t), (), ranges), True)


def _nees(key: str, label: str, t: Floats, values: Floats) -> Chart:
    bounds = _bounds(values, DIMENSION)
    traces = _bounded(t, nan_mean(values), bounds, 0)
    traces.append(on_row(line([_span(t)[0], _span(t)[1]], [9, 9], "honest: 9", TRUTH, width=1), 0))
    outside = _outside(nan_mean(values), bounds)
    text = (
        f"Mean over {counted(len(values), 'run')} of the normalised estimation error squared of position,"
        f" velocity and attitude, with the 95 % bounds of an honest filter. Outside of them: {outside};"
        " expected: 5 %."
    )
    layout = stacked(["NEES"], _span(t)) | {"height": 330}
    return Chart(key, _titled("Consistency: NEES", label), text, traces, layout, True)


def _innovations(key: str, label: str, t: Floats, columns: Columns) -> Chart:
    traces: list[Trace] = []
    shares = []
    for place, name in enumerate(NORMALISED):
        squares = columns[name] ** 2
        bounds = _bounds(squares, 1)
        traces += _bounded(t, nan_mean(squares), bounds, place)
        shares.append(f"{INNOVATION_LABELS[place]} {_outside(nan_mean(squares), bounds)}")
    text = (
        "Mean over the runs of each squared normalised innovation (NIS, honest: 1), with its 95 % bounds;"
        f" innovations that the gate refused are left out. Outside: {', '.join(shares)}."
    )
    layout = stacked(list(INNOVATION_LABELS), _span(t))
    return Chart(key, _titled("Consistency: innovations", label), text, traces, layout, True)


# -- pieces ----------------------------------------------------------------------------------------


def plain(values: Floats) -> list[float | None]:
    """For JSON: five digits are more than a screen shows; None where there is none."""
    return [float(f"{value:.5g}") if np.isfinite(value) else None for value in values.tolist()]


def _span(t: Floats) -> list[float]:
    return [float(t[0]), float(t[-1])]


def _deviation(values: Floats) -> Floats:
    """Standard deviation over runs; NaN with fewer than two."""
    there = np.isfinite(values)
    count = there.sum(axis=0)
    squares = np.where(there, (values - nan_mean(values)) ** 2, 0.0).sum(axis=0)
    return np.where(count > 1, np.sqrt(squares / np.maximum(count - 1, 1)), np.nan)


def _filter_band(t: Floats, own: Floats, place: int) -> list[Trace]:
    low = line(plain(t), plain(-own), "3 σ of the filter", BAND, width=0, hoverinfo="skip")
    high = line(plain(t), plain(own), "3 σ of the filter", BAND, width=0, hoverinfo="skip")
    low["showlegend"] = False
    return [on_row(low, place), on_row(high | {"fill": "tonexty", "fillcolor": BAND}, place)]


def _shown_once(trace: Trace, before: Sequence[Trace]) -> Trace:
    """One entry in the legend for many traces of one name."""
    known = any(other["name"] == trace["name"] for other in before)
    return trace | {"showlegend": False} if known else trace


def _focus(values: Floats) -> list[float] | None:
    """A y range for the settled errors: what happens at alignment may leave the picture."""
    settled = np.abs(values[:, values.shape[1] // 10 :])
    settled = settled[np.isfinite(settled)]
    if len(settled) == 0:
        return None
    bound = 1.6 * float(np.quantile(settled, 0.995))
    return [-bound, bound] if bound > 0 else None


def _bounds(values: Floats, dimension: int) -> tuple[Floats, Floats]:
    """At each instant the bounds for the mean of as many runs as there are."""
    counts = np.isfinite(values).sum(axis=0)
    known = {int(n): mean_square_bounds(dimension, int(n)) for n in np.unique(counts) if n > 0}
    pairs = np.array([known.get(int(n), (np.nan, np.nan)) for n in counts])
    return pairs[:, 0], pairs[:, 1]


def _bounded(t: Floats, mean: Floats, bounds: tuple[Floats, Floats], place: int) -> list[Trace]:
    low = line(plain(t), plain(bounds[0]), "95 % bounds", BAND, width=0, hoverinfo="skip")
    high = line(plain(t), plain(bounds[1]), "95 % bounds", BAND, width=0, hoverinfo="skip")
    low["showlegend"] = False
    mean_line = line(plain(t), plain(mean), "mean of the runs", FUSED)
    traces = [low, high | {"fill": "tonexty", "fillcolor": BAND}, mean_line]
    return [on_row(trace, place) for trace in traces]


def _outside(mean: Floats, bounds: tuple[Floats, Floats]) -> str:
    there = np.isfinite(mean)
    if not there.any():
        return "–"
    outside = (mean[there] < bounds[0][there]) | (mean[there] > bounds[1][there])
    return f"{100 * outside.mean():.0f} %"
