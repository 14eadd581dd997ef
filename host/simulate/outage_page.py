"""The outage test for people: a table with the document's figures beside ours, and a page with the drift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from host.report.charts import FUSED, GNSS, TRUTH, Chart, line
from host.report.html import chart_block, chart_scripts, document, table
from host.report.numbers import NONE, number
from host.report.summary import MET, NOT_MET, Section
from host.simulate.drift import Drift
from host.simulate.outage_test import GNSS_M, GNSS_MPS, RATE_HZ

COLOURS = (FUSED, GNSS, TRUTH, "#2e8b57", "#8e44ad")
FAINT = "rgba(120,130,140,0.45)"
BAND = 1.5
"""A drift agrees from the smaller simulated figure by this to the larger one times this."""


@dataclass(frozen=True, slots=True)
class Published:
    """Horizontal RMS after 60 s without a receiver, m: source 002, tables 4-11 to 4-13."""

    simulated: tuple[float, float] | None
    """From the parameters of a trajectory, and from a trajectory's points."""
    real: float
    """Of the real sensor."""

    @property
    def band(self) -> tuple[float, float] | None:
        """Within which ours agrees; None: there is nothing that it must agree with."""
        if self.simulated is None:
            return None
        return min(self.simulated) / BAND, max(self.simulated) * BAND


PUBLISHED = {
    "pos830": Published((0.5448, 0.4903), 0.6856),
    "stim300": Published((7.239, 4.779), 7.382),
    "adis16488": Published((11.358, 10.085), 26.246),
    "adis16488-warm": Published(None, 26.246),
}
PUBLISHED_LENGTH_S = 60


def published(drift: Drift) -> Published | None:
    """What there is to compare with."""
    return PUBLISHED.get(drift.preset) if drift.plan.length_s == PUBLISHED_LENGTH_S else None


def agrees(drift: Drift) -> bool | None:
    """Whether the drift lies in the band; None: there is none."""
    known = published(drift)
    if known is None or known.band is None:
        return None
    low, high = known.band
    return low <= drift.horizontal_rms_m() <= high


def section(drifts: Sequence[Drift], drive: str) -> Section:
    """One row a sensor; `drive`: the scenario's name."""
    plan, seeds = drifts[0].plan, drifts[0].seeds
    drives = "one drive" if len(seeds) == 1 else f"{len(seeds)} drives (seeds {seeds[0]} … {seeds[-1]})"
    columns = (
        *("sensor", "horizontal, m", "its 95 %, m", "expected by the filter, m", "vertical, m"),
        *("roll, °", "pitch, °", "yaw, °", "document: simulated, m", "real, m", "agrees, m", "verdict"),
    )
    note = (
        f"On {drive}; the document prints no drive of its own, and the drive decides."
        f" RMS of the error at the end of {plan.outages} outages of {plan.length_s} s, {plan.gap_s} s apart,"
        f" on {drives}; the interval is that of the figure over endless drives, by how these scatter."
        f" Receiver: {GNSS_M:g} m, {GNSS_MPS:g} m/s, 1 Hz. Sensors at {RATE_HZ} Hz."
    )
    title = f"Drift without a receiver for {plan.length_s} s"
    return Section(title, columns, tuple(map(_row, drifts)), note=note)


def _row(drift: Drift) -> tuple[str, ...]:
    known, met = published(drift), agrees(drift)
    figures = (drift.claimed_rms_m(), *(drift.rms(k) for k in (2, 3, 4, 5)))
    interval = drift.interval_m()
    sure = NONE if interval is None else " … ".join(map(number, interval))
    ours = (drift.preset, number(drift.horizontal_rms_m()), sure, *map(number, figures))
    if known is None:
        return *ours, NONE, NONE, NONE, NONE
    real = f"{known.real:.2f}"
    if known.simulated is None or known.band is None:
        return *ours, NONE, real, NONE, NONE
    simulated = " / ".join(f"{value:.2f}" for value in known.simulated)
    band = " … ".join(f"{value:.2f}" for value in known.band)
    return *ours, simulated, real, band, MET if met else NOT_MET


def to_dict(drift: Drift) -> dict[str, Any]:
    """For JSON."""
    known = published(drift)
    interval = drift.interval_m()
    names = ("vertical_rms_m", "roll_rms_deg", "pitch_rms_deg", "yaw_rms_deg")
    return {
        "preset": drift.preset,
        "horizontal_rms_m": drift.horizontal_rms_m(),
        "interval_95_m": None if interval is None else list(interval),
        "each_drive_rms_m": drift.each_rms_m(),
        "expected_horizontal_rms_m": drift.claimed_rms_m(),
        **{name: drift.rms(column) for column, name in enumerate(names, start=2)},
        "document_simulated_m": None if known is None or known.simulated is None else list(known.simulated),
        "document_real_m": None if known is None else known.real,
        "band_m": None if known is None or known.band is None else list(known.band),
        "agrees": agrees(drift),
        "horizontal_m": drift.horizontal_m()[:, -1].tolist(),
    }


def page(title: str, drifts: Sequence[Drift], summary: Section) -> str:
    """One file that opens offline."""
    drawn = [_together(drifts), *map(_alone, drifts)]
    body = [f"<header><h1>{escape(title)}</h1></header>", table(summary), *map(chart_block, drawn)]
    return document(title, body, chart_scripts({}, drawn))


def _axes(**more: Any) -> dict[str, Any]:
    return {
        "xaxis": {"title": {"text": "since the receiver's last epoch, s"}},
        "yaxis": {"title": {"text": "horizontal error, m"}} | more,
        "height": 420,
    }


def _rms(drift: Drift, colour: str, **more: Any) -> dict[str, Any]:
    curve = np.sqrt(np.mean(drift.horizontal_m() ** 2, axis=0))
    return line(list(range(len(curve))), curve.tolist(), f"{drift.preset}, RMS", colour, **more)


def _together(drifts: Sequence[Drift]) -> Chart:
    traces = [_rms(drift, COLOURS[k % len(COLOURS)], width=2) for k, drift in enumerate(drifts)]
    text = "RMS over all outages, second by second."
    return Chart("all", "All sensors", text, traces, _axes(type="log"))


def _alone(drift: Drift) -> Chart:
    outages = drift.horizontal_m()
    seconds = list(range(outages.shape[1]))
    traces = [
        line(seconds, one.tolist(), f"outage {k}", FAINT, showlegend=False, width=1)
        for k, one in enumerate(outages, start=1)
    ]
    traces.append(_rms(drift, FUSED, width=2.5))
    return Chart(drift.preset, drift.preset, "Every outage, and their RMS.", traces, _axes())
