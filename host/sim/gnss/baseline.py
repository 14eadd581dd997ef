"""What a receiver with two antennas tells of the vector between them.

Errors of heading and pitch: white noise of an epoch plus a first-order Gauss–Markov process, both inversely
as the length of the baseline, since they are errors of millimetres across it; those of the pitch, like all
vertical ones, are larger. Heading suffers with 1 / cos(pitch). When signals come back, ambiguities are
estimated as real numbers for `fixing_s`, with `float_factor` times the errors, before they are fixed.

Claimed accuracies are honest 1 σ figures.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from boards.chips.world import BaselineSolution
from host.sim.errors.processes import Process, ProcessBank
from host.sim.gnss.ahead import AntennaAhead
from host.sim.gnss.schedule import NS, Window, held
from host.sim.gnss.settings import BaselineSettings
from host.sim.seeding import NormalRows

DEG = math.pi / 180.0
STEEPEST_COS = 1e-3

BaselineTruth = Callable[[NDArray[np.int64]], NDArray[np.float64]]
"""Virtual times in ns → (n, 3) from the main antenna to the second one: north, east, down in m."""


@dataclass(frozen=True, slots=True)
class _Sigmas:
    """Of whole errors with ambiguities fixed: white and slow part, rad of level heading; length in m."""

    white: float
    slow: float
    length: float


class Baseline:
    """The second antenna of one receiver."""

    def __init__(
        self,
        name: str,
        settings: BaselineSettings,
        truth: BaselineTruth,
        length_m: float,
        seed: int,
        outages: Sequence[Window],
    ) -> None:
        """`length_m`: the true one; `outages`: when the receiver has no fix."""
        self._settings = settings
        scale = settings.for_length_m / length_m
        white, slow = settings.heading_white_deg * DEG * scale, settings.heading_markov_deg * DEG * scale
        self._sigmas = _Sigmas(white, slow, settings.length_white_m)
        processes = [
            Process(f"{name}.baseline_{angle}.markov", slow * factor, settings.markov_time_s)
            for angle, factor in (("heading", 1.0), ("pitch", settings.pitch_factor))
        ]
        self._ahead = AntennaAhead(truth, ProcessBank(processes, seed))
        channels = ("heading", "pitch", "length")
        self._normals = NormalRows(seed, [f"{name}.baseline_{channel}.white" for channel in channels])
        self._outages = list(outages)
        fixing_ns = round(settings.fixing_s * NS)
        self._floating = [Window(w.end_ns, w.end_ns + fixing_ns) for w in outages]

    def at(self, time_ns: int) -> BaselineSolution:
        """The solution valid at an instant."""
        north, east, down, slow_heading, slow_pitch = self._ahead.at(time_ns)
        normals = self._normals.next()
        if held(self._outages, time_ns):
            return NO_BASELINE
        floating = held(self._floating, time_ns)
        growth = self._settings.float_factor if floating else 1.0
        level = math.hypot(north, east)
        length = math.hypot(level, down)
        steep = length / max(level, STEEPEST_COS * length)
        white, pitch_factor = self._sigmas.white, self._settings.pitch_factor
        heading_error = growth * steep * (slow_heading + white * normals[0])
        pitch_error = growth * (slow_pitch + white * pitch_factor * normals[1])
        whole = math.hypot(white, self._sigmas.slow)
        true = BaselineSolution(
            fix="FLOAT" if floating else "FIXED",
            heading=math.atan2(east, north),
            pitch=math.atan2(-down, level),
            length=length + growth * self._sigmas.length * normals[2],
            heading_acc=growth * steep * whole,
            pitch_acc=growth * pitch_factor * whole,
            length_acc=growth * self._sigmas.length,
        )
        return turned(true, heading_error, pitch_error)

    def forget_ahead(self) -> None:
        """Where the antennas will be has changed."""
        self._ahead.forget()


NO_BASELINE = BaselineSolution("NONE", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def turned(solution: BaselineSolution, heading: float, pitch: float) -> BaselineSolution:
    """The same with other angles, rad."""
    quarter = math.pi / 2
    return replace(
        solution,
        heading=(solution.heading + heading) % (2.0 * math.pi),
        pitch=min(max(solution.pitch + pitch, -quarter), quarter),
    )
