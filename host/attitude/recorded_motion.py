"""The world of a chip that feels a recording: implements `boards.chips.world.ImuWorld` and `TenDofWorld`.

A recorded rate is taken for the mean over the interval that ends with it, as direct feed takes it, so it
stands in the middle of that interval; forces and fields stand at their own times. In between values are
interpolated linearly, before the first and after the last sample they stand still. No noise is added: the
recording has its own. Samples that are no numbers are left out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.attitude.estimates import TESLA_PER_MICROTESLA
from host.attitude.recording import AttitudeRecording, Floats

CELSIUS = 25.0
SEA_LEVEL_PA = 101_325.0


class RecordedMotion:
    """The recording begins at `start_ns`. `ten_dof`: with magnetic field and pressure."""

    def __init__(self, recording: AttitudeRecording, start_ns: int, *, ten_dof: bool) -> None:
        times: Floats = start_ns * 1e-9 + recording.times
        self._channels: list[tuple[int, Floats, Floats]] = []
        self._columns = 11 if ten_dof else 7
        self._add(0, times, recording.force)
        middles: Floats = times - 0.5 * recording.interval
        self._add(3, middles, recording.omega)
        if ten_dof:
            self._add(7, times, recording.field * TESLA_PER_MICROTESLA)

    def _add(self, first: int, times: Floats, values: Floats) -> None:
        for axis in range(3):
            known = np.isfinite(values[:, axis])
            self._channels.append((first + axis, times[known], values[known, axis]))

    def sample(self, times_ns: NDArray[np.int64], bandwidth_hz: float) -> Floats:
        """See `boards.chips.world`."""
        del bandwidth_hz  # of the noise, and there is none
        t = times_ns * 1e-9
        values = np.zeros((len(t), self._columns))
        values[:, 6] = CELSIUS
        if self._columns > 10:
            values[:, 10] = SEA_LEVEL_PA
        for column, times, known in self._channels:
            if len(times):
                values[:, column] = np.interp(t, times, known)
        return values
