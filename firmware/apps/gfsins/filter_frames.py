"""What each filter beside the master takes for the state, to the host, for people: FILTER frames.

Without resets the filters are those of the document's figures 5.1 and 5.2; otherwise they are as each fusion
has left them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins.navigation import Navigation
from firmware.apps.gnss_ins.navigation import StateKernels
from firmware.apps.gnss_ins.output import Output
from firmware.link import frames
from firmware.nav import layout
from firmware.nav import solution as record
from firmware.nav.flags import NAVIGATING
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.filters import State
from hal.board_io import BoardIo

PACK = frames.PAYLOADS[frames.FILTER].pack
RATE = slice(record.OMEGA_B, record.SIGMA_POSITION)


class FilterFrames:
    """Sends them once a second, from the background."""

    def __init__(self, io: BoardIo, navigation: Navigation, kernels: StateKernels, output: Output) -> None:
        self._cpu = io.cpu
        self._cost = io.cpu.cost("solution_frame")
        self._navigation = navigation
        self._solution = kernels.solution
        self._output = output
        self._floats: NDArray[np.float32] = np.zeros(record.SOLUTION_FLOATS, np.float32)
        self._integers: NDArray[np.int64] = np.zeros(record.SOLUTION_INTEGERS, np.int64)

    def send(self) -> None:
        """Nothing of a filter that does not navigate."""
        federation, output = self._navigation.federation, self._output
        output.look()
        for which, state in ((gl.COMPASS, federation.compass), (gl.GPS, federation.gps)):
            if int(state[1][layout.MODE]) == NAVIGATING:
                output.tell(frames.FILTER, self._payload(which, state))
                self._cpu.spend(self._cost)

    def _payload(self, which: int, state: State) -> bytes:
        self._solution(*state, self._floats, self._integers)
        time_ns, latitude, longitude = self._integers[: record.LON_NANODEG + 1].tolist()
        status = int(self._navigation.federation.n[gl.STATUS + which])
        numbers = self._floats.tolist()
        del numbers[RATE]
        return PACK(max(time_ns, 0) // 1000, which, status, latitude, longitude, *numbers)
