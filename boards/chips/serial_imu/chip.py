"""An inertial measurement unit that sends a frame for each sample, without being asked.

Rate and specific force are sampled four times in each period and summed up; what rounding leaves goes into
the next increment, so that nothing is lost over many. A frame begins 100 µs after the end of its period.

The frame (`frames`), its times and limits are choices: the board's document says "generic framed serial IMU".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from boards.chips.oscillator import Oscillator
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.serial_imu import frames
from boards.chips.transmit_line import TransmitLine
from boards.chips.world import ImuWorld
from hal.emulated.pins import Net
from hal.emulated.virtual_time import SECOND, Event, VirtualTime

RATES_HZ = (50, 100, 200, 400)
SUBSAMPLES = 4
BLOCK_S = 2.0
START_UP_NS = SECOND // 2
"""From the supply to the end of the first period; a choice."""
WARM_NS = SECOND
"""From the supply until the status says no more that it starts; a choice."""
LATENCY_NS = 100_000
"""From the end of a period to the first bit of its frame; a choice."""
BUFFER_BYTES = 2 * frames.LENGTH
STANDARD_GRAVITY = 9.80665
BITS_A_BYTE = 10


class SerialImu:
    """One unit. It only talks: `tx` is its line, `receive` takes bytes that it ignores and reports.

    `rate_hz`: 50, 100, 200 or 400. `baud`: must carry a frame a sample. `gyro_range_dps`, `accel_range_g`:
    beyond them it clips and says so. `clock_error_ppm`: how much its clock is fast. `start_ns`: when its
    supply comes up. `strict`: reports are raised as UndocumentedAccessError.
    """

    feels = "imu"
    """The world that it asks."""
    measures = ("gyro", "accel")
    """Of what the world tells."""

    def __init__(
        self,
        time: VirtualTime,
        world: ImuWorld,
        tx: TransmitLine,
        *,
        rate_hz: int = 200,
        baud: int = 230_400,
        gyro_range_dps: float = 500.0,
        accel_range_g: float = 30.0,
        clock_error_ppm: float = 0.0,
        start_ns: int = 0,
        strict: bool = False,
        name: str = "RS-422 IMU",
    ) -> None:
        if rate_hz not in RATES_HZ:
            raise ValueError(f"{name}: rate_hz = {rate_hz}; possible: {', '.join(map(str, RATES_HZ))}")
        needed = frames.LENGTH * BITS_A_BYTE * rate_hz
        if baud < needed:
            raise ValueError(
                f"{name}: baud = {baud} is too slow for {rate_hz} frames of {frames.LENGTH} bytes a second:"
                f" {needed} bits; e.g. 115200 for 200 Hz, 230400 for 400 Hz"
            )
        for what, value, most in (
            ("gyro_range_dps", gyro_range_dps, 2000.0),
            ("accel_range_g", accel_range_g, 100.0),
        ):
            if not 0.0 < value <= most:
                raise ValueError(f"{name}: {what} = {value}; it must lie above 0, and not above {most:g}")
        self.name = name
        self.pins: dict[str, Net | None] = {}
        self.baud = baud
        self.frames_dropped = 0
        """Frames that found no room behind what the line still had to send."""
        self.log = AccessLog(name, strict=strict)
        self._time = time
        self._world = world
        self._tx = tx
        self._rate_hz = rate_hz
        self._error_ppb = round(clock_error_ppm * 1000.0)
        radians = np.radians(gyro_range_dps)
        self._limits = np.array([accel_range_g * STANDARD_GRAVITY] * 3 + [radians] * 3)
        self._flags = 0
        self._halted = False
        self._powered = True
        self._event: Event | None = None
        self._sample = 1
        """The next to be sent, as a tick of the clock."""
        self._block: list[bytes] = []
        self._dues: list[int] = []
        """When the samples of the block behind its first are."""
        self._left = np.zeros(6)
        self._lefts: NDArray[np.float64] = np.empty((0, 6))
        """What rounding left behind each sample of the block."""
        self._start(start_ns)

    @property
    def reports(self) -> list[AccessReport]:
        """Bytes that were sent to it."""
        return self.log.reports

    # -- surroundings ------------------------------------------------------------------------------

    def power(self, on: bool) -> None:
        """Switch the supply, now; the frame on its way is cut off."""
        if on == self._powered:
            return
        self._powered = on
        if on:
            self._start(self._time.now)
        else:
            self._stop()
            abort = getattr(self._tx, "abort", None)
            if abort is not None:
                abort()

    def receive(self, data: bytes, time_ns: int) -> None:
        """It has no commands."""
        if self._powered and data:
            self.log.report(ReportKind.PROTOCOL, "RX", "bytes received: it has no commands", time_ns)

    # -- defects -----------------------------------------------------------------------------------

    def set_clock_error(self, ppm: float) -> None:
        """Its clock runs fast by so much from now on."""
        self._error_ppb = round(ppm * 1000.0)
        self._clock.pull(self._time.now, self._rate_hz, self._error_ppb)
        self.look_anew()

    def look_anew(self) -> None:
        """Ask the world again for the samples to come: it has changed."""
        self._block = []
        if self._powered and not self._halted:
            self._schedule(max(self._time.now, self._due_ns - 1) + 1)

    def halt(self, on: bool) -> None:
        """Its sample clock stands still, and nothing comes; or it goes on."""
        self._halted = on
        self._stop()
        if not on and self._powered:
            self._sample = max(self._sample, self._clock.tick(self._time.now) + 1)
            self._schedule(self._clock.instant(self._sample) + LATENCY_NS)

    def raise_flags(self, flags: int) -> None:
        """The status of every frame has these bits too from now on; 0: no more."""
        self._flags = flags & 0xFFFF
        self.look_anew()

    # -- samples -----------------------------------------------------------------------------------

    def _start(self, supply_ns: int) -> None:
        """Counter, clock and rounding begin anew."""
        self._tx.set_baud(self.baud)
        self._supply_ns = supply_ns
        period = Oscillator(self._rate_hz, 0, self._error_ppb).instant(1)
        self._clock = Oscillator(self._rate_hz, supply_ns + START_UP_NS - period, self._error_ppb)
        self._sample = 1
        self._block = []
        self._left = np.zeros(6)
        if not self._halted:
            self._schedule(self._clock.instant(1) + LATENCY_NS)

    def _stop(self) -> None:
        self._block = []
        if self._event is not None:
            self._event.cancel()
            self._event = None

    def _schedule(self, due_ns: int) -> None:
        if self._event is not None:
            self._event.cancel()
        self._due_ns = due_ns
        self._event = self._time.at(due_ns, self._send)

    def _send(self) -> int:
        """Event: a frame goes out; returns when the next one does."""
        if not self._block:
            self._fill()
        frame = self._block.pop(0)
        if getattr(self._tx, "queued", 0) < BUFFER_BYTES:
            self._tx.send(frame)
        else:
            self.frames_dropped += 1
        self._left = self._lefts[-len(self._block) - 1]
        self._sample += 1
        due = self._dues.pop(0) if self._dues else self._clock.instant(self._sample) + LATENCY_NS
        self._due_ns = due = max(self._time.now + 1, due)
        return due

    def _fill(self) -> None:
        """The frames of the next half second."""
        count = round(BLOCK_S * self._rate_hz)
        ends = self._clock.grid(self._sample - 1, 1, count + 1)
        lengths = np.diff(ends)
        inside = (2 * np.arange(SUBSAMPLES) + 1) * lengths[:, None] // (2 * SUBSAMPLES)
        times = (ends[:-1, None] + inside).ravel()
        bandwidth_hz = SUBSAMPLES * self._rate_hz / 2.0
        felt = np.asarray(self._world.sample(times, bandwidth_hz), np.float64)[:, :6]
        excess = (np.abs(felt) > self._limits).reshape(count, SUBSAMPLES, 6)
        beyond: NDArray[np.bool_] = np.any(excess, axis=1)
        means = np.clip(felt, -self._limits, self._limits).reshape(count, SUBSAMPLES, 6).mean(axis=1)
        increments = means * lengths[:, None] * 1e-9
        units = np.concatenate(
            (increments[:, 3:] / frames.ANGLE_LSB, increments[:, :3] / frames.VELOCITY_LSB), 1
        )
        sums = self._left + np.cumsum(units, axis=0)
        rounded = np.rint(sums)
        counts = np.diff(rounded, axis=0, prepend=np.zeros((1, 6))).astype(np.int64)
        self._lefts = sums - rounded
        status = np.full(count, self._flags, np.int64)
        status[beyond[:, 3:].any(axis=1)] |= frames.GYRO_RANGE
        status[beyond[:, :3].any(axis=1)] |= frames.ACCEL_RANGE
        status[ends[1:] < self._supply_ns + WARM_NS] |= frames.STARTING
        self._block = frames.frames(self._sample - 1, counts, status)
        self._dues = (ends[2:] + LATENCY_NS).tolist()
