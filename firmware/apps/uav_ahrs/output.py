"""Everything the board says on SCI-A: solutions, the sensor's health, status, words."""

from __future__ import annotations

from firmware.apps.uav_ahrs.attitude import Attitude
from firmware.apps.uav_ahrs.measured import ambient
from firmware.apps.uav_ahrs.plausibility import JUMPS, LOST_READS
from firmware.apps.uav_ahrs.sensor import Sensor
from firmware.apps.uav_ahrs.settings import Settings
from firmware.link import frames
from firmware.link.attitude_output import UNKNOWN_AGE, AttitudeOutput
from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.flags import DEGRADED, LEVELLING, NAVIGATING
from hal.board_io import BoardIo

WORD = 0xFFFF_FFFF
SHORT = 0xFFFF
DOUBTFUL = fl.RATES_LOST | fl.GYRO_SATURATED | fl.OVERRUN
"""Noticed, attitude may be wrong."""
DOUBT_NS = 2_000_000_000
"""So long after, it is called degraded."""


class Output:
    """Packs and sends; what finds no room on the port is counted and dropped, never waited for."""

    def __init__(self, io: BoardIo, settings: Settings, attitude: Attitude, sensor: Sensor) -> None:
        self.dropped = 0
        self.mode = LEVELLING
        self.spoilt = 0
        """Iterations that had to be taken back."""
        self._doubt_until_ns = 0
        self._attitude = attitude
        self._sensor = sensor
        self._uart = io.uart["host"]
        self._cpu = io.cpu
        self._clock = io.clock
        self._writer = frames.FrameWriter()
        self._solutions = AttitudeOutput(self._writer)
        self._frame_cost = io.cpu.cost("solution_frame")
        self._slow_cost = io.cpu.cost("slow_frames")
        self._task_figures = io.interrupts.figures if settings.task_frames else None
        self._task_cost = io.cpu.cost("task_frames") if settings.task_frames else 0
        self.gyro_bias = 0
        """The largest of the three as estimated, 1e-9 rad/s."""
        self._ages: list[int] = []
        """Of the samples of solutions since the last SENSOR frame, µs."""

    def send(self) -> None:
        """The solution at the output rate."""
        record = self._attitude.solve()
        _, mode, flags, *_, bias_x, bias_y, bias_z = record[at.OUT_HEIGHT : OUT_LAST].tolist()
        now_ns = self._clock.now_ns()
        if flags & DOUBTFUL:
            self._doubt_until_ns = now_ns + DOUBT_NS
        self.mode = self._mode(mode, now_ns)
        self.gyro_bias = max(abs(bias_x), abs(bias_y), abs(bias_z))
        age_us = self._sensor.sample_age_us()
        if age_us is None:
            age_us = UNKNOWN_AGE
        else:
            self._ages.append(age_us)
        time_us = max(self._sensor.valid_at_ns(), 0) // 1000
        self._send(self._solutions.pack(record, time_us, self.mode, flags & SHORT, age_us))
        self._cpu.spend(self._frame_cost)

    def note_spoilt(self) -> None:
        """An iteration went wrong."""
        self.spoilt += 1
        self.doubt()

    def doubt(self) -> None:
        """The attitude may be wrong."""
        self._doubt_until_ns = self._clock.now_ns() + DOUBT_NS

    def send_slow(self) -> None:
        """Once a second: status and the sensor's health."""
        attitude, sensor = self._attitude, self._sensor
        now_us = self._clock.now_ns() // 1000
        counts = attitude.notices()
        missed = counts[NO_ANSWER] + counts[SLIPPED] + int(attitude.k[JUMPS])
        status = self._writer.pack(
            frames.STATUS,
            *(now_us, self.mode, 0, 0, sensor.reads & WORD, missed & WORD, counts[STALE] & WORD, 0, 0),
            *(self.dropped & SHORT, sensor.starts & 0xFF, 0),
        )
        self._send(status + self._health(now_us, counts), 2)
        self._cpu.spend(self._slow_cost)
        if self._task_figures is not None:
            self._send_tasks(now_us)

    def send_text(self, message: str) -> None:
        """A line for people."""
        self._send(self._writer.text(message))

    def _mode(self, mode: int, now_ns: int) -> int:
        if mode != fl.RUNNING:
            return LEVELLING
        return DEGRADED if now_ns < self._doubt_until_ns else NAVIGATING

    def _health(self, now_us: int, counts: list[int]) -> bytes:
        attitude, sensor = self._attitude, self._sensor
        supply_mv, temperature, pressure_pa, field_nt, adc_mv = ambient(attitude.words)
        ages = self._ages or [UNKNOWN_AGE]
        extra = (sensor.reads, int(attitude.k[JUMPS]), int(attitude.k[LOST_READS]))
        counters = [one & WORD for one in (*extra, *counts, *attitude.saturations())]
        frame = self._writer.pack(
            frames.SENSOR,
            *(now_us, supply_mv, sensor.diagnosis & SHORT, temperature, pressure_pa, field_nt, adc_mv),
            *(min(ages), max(ages), sensor.product_id & SHORT, sensor.starts & 0xFF),
            *counters,
        )
        self._ages.clear()
        sensor.diagnosis = 0
        return frame

    def _send_tasks(self, now_us: int) -> None:
        assert self._task_figures is not None
        rows = [
            (name, activations, busy_ns // 1000 & WORD, min(worst_ns // 1000, WORD), min(missed, SHORT))
            for name, activations, busy_ns, worst_ns, missed in self._task_figures()
        ]
        for frame in self._writer.tasks(now_us, rows):
            self._send(frame)
        self._cpu.spend(self._task_cost)

    def _send(self, data: bytes, count: int = 1) -> None:
        """`count`: how many frames this is."""
        if self._uart.tx_free() >= len(data):
            self._uart.write(data)
        else:
            self.dropped += count


OUT_LAST = at.OUT_GYRO_BIAS + 3
STALE, NO_ANSWER, SLIPPED = (fl.NOTICE_NAMES.index(name) for name in ("stale", "no_answer", "slipped"))
