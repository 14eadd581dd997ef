"""The navigation loop without a board around it: raw frames in, solution frames out.

The same classes as on the board (navigation, the port's epoch and its dating, the output) stand on a bench
where nothing takes time and nobody interrupts; `take` does with an input what the task did that told it.
So the solution is the same to the last bit, as long as no input is missing.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from firmware.apps.car_mems.acquisition import Acquisition
from firmware.apps.car_mems.bench import Bench
from firmware.apps.car_mems.gnss_port import GnssPort
from firmware.apps.car_mems.navigation import Navigation, NavigationKernels, nav_config
from firmware.apps.car_mems.settings import Settings
from firmware.apps.gnss_ins.output import Output
from firmware.drivers import gnss_epoch as gnss
from firmware.drivers.bmi160_sample import BURST_LENGTH
from firmware.link import frames
from firmware.link import raw_frames as raw
from firmware.link.crc import crc16
from firmware.nav import layout, tuning
from firmware.numerics.dialect import entry_point

HALF_RANGE = 1 << 63
"""Times of a frame may be anything; they wrap as the processor's do."""


class RawLoop:
    """Navigation on raw frames. `memory` and `configuration` are for comparing with the board's."""

    def __init__(
        self, profile: Mapping[str, Any], installation: Mapping[str, Any], captures: Collection[str]
    ) -> None:
        """`captures`: names of the pins with a capture timer. Raises ValueError for an impossible profile."""
        self._settings = Settings.of(profile)
        self._kernels = NavigationKernels(self._settings.precision)
        self._config = nav_config(self._settings, installation, "timepulse" in captures)
        self._burst = np.zeros(BURST_LENGTH, np.uint8)
        self._restart()

    def _restart(self) -> None:
        self._navigation = Navigation(self._kernels, self._config)
        self._bench = Bench()
        io = self._bench.io()
        self._gnss = GnssPort(io, self._settings, self._navigation)
        self._output = Output(
            io,
            self._navigation,
            self._gnss,
            Acquisition(io, self._settings),
            port=io.uart["host"],
            clock=io.clock,
        )
        self._step = self._navigation.sample_step(self._settings.strapdown == "mean")

    def take(self, kind: int, values: tuple[Any, ...]) -> None:
        """One input: the values of its frame behind the number."""
        navigation = self._navigation
        if kind == raw.RAW_IMU:
            self._burst[1:] = np.frombuffer(values[1], np.uint8)
            self._step(navigation.f, navigation.i, self._burst, values[0])
        elif kind == raw.RAW_EPOCH:
            self._take_epoch(values[:2], values[2:])
        elif kind == raw.RAW_TEMPERATURE:
            navigation.take_temperature(values[0])
        elif kind == raw.RAW_CLOCK:
            navigation.restart_sample_clock()
        elif kind == raw.RAW_START:
            self._restart()

    def _take_epoch(self, pulse: tuple[int, int], record: tuple[int, ...]) -> None:
        """Date the epoch as the port does, then let the filter have it."""
        epoch = gnss.new_epoch()
        epoch[: len(record)] = record
        time = self._gnss.time
        time.take_pulse(*pulse)
        valid_ns, _ = time.validity(record[gnss.TIME_OF_DAY_MS], record[gnss.BURST_START_NS])
        epoch[gnss.VALID_NS] = (valid_ns + HALF_RANGE) % (2 * HALF_RANGE) - HALF_RANGE
        self._gnss.absorb(epoch, pulse)

    def solution(self) -> bytes:
        """The payload of the SOLUTION frame that the board sends in this state; empty: it sends none."""
        self._bench.sent.clear()
        self._output.send()
        frame = bytes(self._bench.sent)
        return frame[frames.HEADER_LENGTH : -frames.CRC_LENGTH]

    def start_words(self) -> tuple[int, ...]:
        """Of a START frame, what the program and its configuration decide: format … CRC of the memory."""
        settings, f, i = self._settings, self._navigation.f, self._navigation.i
        memory = np.frombuffer(bytearray(f.tobytes() + i.tobytes()), np.uint8)
        crc = entry_point(crc16)(memory, 0, len(memory))
        two_sample = settings.strapdown != "mean"
        return (
            raw.RAW_FORMAT, int(two_sample), f.itemsize, settings.steps_per_output, len(f), len(i), int(crc),
        )  # fmt: skip

    def memory(self) -> bytes:
        """As the slices of a STATE hold it."""
        navigation = self._navigation
        return navigation.f.tobytes() + navigation.i.tobytes() + self._gnss.epoch.tobytes()

    def restore(self, memory: bytes) -> bool:
        """Go on from a board's memory. False: it is not of this program's size."""
        f, i, epoch = self._navigation.f, self._navigation.i, self._gnss.epoch
        if len(memory) != f.nbytes + i.nbytes + epoch.nbytes:
            return False
        floats, integers = f.nbytes, f.nbytes + i.nbytes
        f[:] = np.frombuffer(memory[:floats], f.dtype)
        i[:] = np.frombuffer(memory[floats:integers], np.int64)
        epoch[:] = np.frombuffer(memory[integers:], np.int64)
        self._gnss.latest = epoch.tolist()
        return True

    def place(self, offset: int) -> str:
        """What lies at a byte of `memory`, for people."""
        f, i = self._navigation.f, self._navigation.i
        if offset < f.nbytes:
            return _name(offset // f.itemsize)
        if offset < f.nbytes + i.nbytes:
            return _name((offset - f.nbytes) // 8, integer=True)
        return f"epoch.{gnss.FIELD_NAMES[(offset - f.nbytes - i.nbytes) // 8]}"

    def configuration(self) -> dict[str, float]:
        """What only the configuration decides, by place."""
        f, i = self._navigation.f, self._navigation.i
        floats = {_name(k): float(f[k]) for k in range(layout.CONFIG, layout.F_SIZE)}
        return floats | {_name(k, integer=True): int(i[k]) for k in range(layout.SWITCHES, layout.I_SIZE)}


def _name(place: int, integer: bool = False) -> str:
    """Of a place of the state, for people; of the configuration as in `firmware.nav.tuning`."""
    held = f"{'i' if integer else 'f'}[{place}]"
    if place < (layout.SWITCHES if integer else layout.CONFIG):
        return held
    names = {value: name for name, value in vars(tuning).items() if name.isupper() and type(value) is int}
    return f"{names[place]} {held}" if place in names else held
