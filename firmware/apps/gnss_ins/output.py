"""Everything the board says: link frames and NMEA on the host port, CAN, the log on the card."""

from __future__ import annotations

import struct
from typing import Final

from firmware.apps.gnss_ins.own_fix import own_fix
from firmware.apps.gnss_ins.parts import HostPort, Navigation, Receiver, Sensor
from firmware.drivers import gnss_epoch as gnss
from firmware.link import frames
from firmware.link.nmea_output import NmeaWriter
from firmware.link.solution_output import SolutionOutput
from firmware.nav import solution as record
from hal.board_io import BoardIo
from hal.clock import Clock
from hal.machine_code import mypyc_attr

LOG_BLOCKS_A_SYNC: Final = 8
LOG_BLOCK: Final = 4096
DAY_MS: Final = 86_400_000
WORD: Final = 0xFFFF_FFFF
EARLIEST_NS: Final = 0


@mypyc_attr(allow_interpreted_subclasses=True)
class Output:
    """Packs and sends; what finds no room on a port is counted and dropped, never waited for."""

    def __init__(
        self,
        io: BoardIo,
        navigation: Navigation,
        receiver: Receiver,
        sensor: Sensor,
        *,
        port: HostPort,
        clock: Clock,
        task_frames: bool = False,
    ) -> None:
        """`port`: the way to the host; `clock`: the board clock, which navigation's times are of."""
        self.dropped = 0
        self._room = 0
        self.card_works = True
        """False while blocks for the log find no card."""
        self.mode = self.flags = 0
        """Of navigation, as they were told last."""
        self._navigation = navigation
        self._receiver = receiver
        self._sensor = sensor
        self._port = port
        self._writer = frames.FrameWriter()
        self._cpu = io.cpu
        self._clock = clock
        self._frame_cost = io.cpu.cost("solution_frame")
        self._slow_cost = io.cpu.cost("slow_frames")
        self._can = io.can.get("can1")
        self._solution_output = SolutionOutput(self._writer)
        self._can_cost = 0 if self._can is None else io.cpu.cost("can_set")
        self._nmea = NmeaWriter()
        self._nmea_cost = io.cpu.cost("nmea_set")
        self._task_figures = io.interrupts.figures if task_frames else None
        self._task_cost = io.cpu.cost("task_frames") if task_frames else 0
        self._seconds = 0
        self._log = io.logs.get("sdcard")
        self._log_cost = 0 if self._log is None else io.cpu.cost("log_block")
        self._log_buffer = bytearray()
        self._blocks_unsynced = 0

    def send(self) -> None:
        """The solution at the output rate."""
        navigation = self._navigation
        navigation.fill_solution()
        time_ns, _latitude, _longitude, self.mode, self.flags = navigation.integers.tolist()
        time_us = time_ns // 1000 if time_ns > 0 else 0
        frame, messages = self._solution_output.pack(
            navigation.floats, navigation.integers, time_us, *self._utc(time_ns)
        )
        self._send(frame)
        self._cpu.spend(self._frame_cost)
        if self._can is not None:
            self.dropped += len(messages) - self._can.send(messages)
            self._cpu.spend(self._can_cost)

    def _solution(self) -> tuple[list[float], list[int]]:
        """The present solution, as `firmware.nav.solution` lays it out."""
        navigation = self._navigation
        navigation.fill_solution()
        integers = navigation.integers.tolist()
        self.mode, self.flags = integers[record.MODE], integers[record.FLAGS]
        return navigation.floats.tolist(), integers

    def send_epoch(self) -> None:
        """After a filter update: the receiver's epoch and the innovations it made."""
        packed = self._pack(frames.GNSS, *_told_of_epoch(self._receiver.latest))
        time_ns, mask, numbers = self._navigation.innovation()
        if mask:
            head = frames.INNOVATION_HEAD.pack(max(time_ns, 0) // 1000, mask)
            packed.append(self._writer.numbers(frames.INNOVATION, head, numbers))
        self._send_together(packed)
        self._cpu.spend(self._frame_cost)

    def send_slow(self) -> None:
        """Once a second: covariance, slow states, status."""
        navigation, writer = self._navigation, self._writer
        now_us = self._clock.now_ns() // 1000
        head = frames.TIME_HEAD.pack(max(navigation.state_ns, 0) // 1000)
        covariance = writer.numbers(frames.COVARIANCE, head, navigation.covariance())
        biases = writer.numbers(frames.BIAS, head, navigation.biases())
        solution = self._solution()
        status = self._pack(frames.STATUS, now_us, self.mode, self.flags, *self._counters())
        self._send_together([covariance, biases, *status])
        self._cpu.spend(self._slow_cost)
        self._send_sentences(*solution)
        self._send_lists(now_us)

    def _counters(self) -> tuple[int, ...]:
        """What STATUS counts."""
        navigation, receiver, sensor = self._navigation, self._receiver, self._sensor
        bad_checksums, garbage = receiver.line_errors()
        return (
            receiver.epochs & 0xFFFFFFFF,
            sensor.reads & 0xFFFFFFFF,
            navigation.samples_missed & 0xFFFFFFFF,
            navigation.samples_repeated & 0xFFFFFFFF,
            bad_checksums & 0xFFFF,
            garbage & 0xFFFF,
            self.dropped & 0xFFFF,
            sensor.starts & 0xFF,
            int(receiver.pulse_dated),
        )

    def _send_sentences(self, floats: list[float], integers: list[int]) -> None:
        """NMEA of our own solution."""
        e = self._receiver.latest
        known = e[gnss.FLAGS] & gnss.HAS_HEIGHT and e[gnss.FLAGS] & gnss.HAS_HEIGHT_MSL
        fix = own_fix(
            floats,
            integers,
            self._utc(integers[record.TIME_NS]),
            e[gnss.HEIGHT_MM] - e[gnss.HEIGHT_MSL_MM] if known else None,
            e[gnss.SATELLITES],
            e[gnss.HDOP_CENTI],
        )
        nmea = self._nmea
        self._send(nmea.gga(fix) + nmea.rmc(fix) + nmea.hdt(fix) + nmea.pashr(fix))
        self._cpu.spend(self._nmea_cost)

    def _send_lists(self, now_us: int) -> None:
        """For displays: tasks where they are asked for, satellites in view every fifth second."""
        if self._task_figures is not None:
            rows = [
                (name, activations, busy_ns // 1000 & WORD, min(worst_ns // 1000, WORD), min(missed, 0xFFFF))
                for name, activations, busy_ns, worst_ns, missed in self._task_figures()
            ]
            for frame in self._writer.tasks(now_us, rows):
                self._send(frame)
            self._cpu.spend(self._task_cost)
        self._seconds += 1
        if self._seconds % 5 == 0:
            for frame in self._writer.satellites(now_us, self._receiver.satellites()):
                self._send(frame)

    def look(self) -> None:
        """See how much room the port has, for `tell`; time passes."""
        self._room = self._port.tx_free()

    def tell(self, kind: int, payload: bytes) -> None:
        """A frame of the application's own type, dropped when `look` saw no room; no time passes."""
        frame = self._writer.frame(kind, payload)
        if self._room >= len(frame):
            self._port.write(frame)
        else:
            self.dropped += 1
        if self._log is not None:
            self._log_buffer += frame

    def send_text(self, message: str) -> None:
        """A line for people."""
        self._send(self._writer.text(message))

    def write_log(self) -> None:
        """From the background: whole blocks to the card, made safe now and then."""
        log, buffer = self._log, self._log_buffer
        while log is not None and len(buffer) >= LOG_BLOCK:
            self.card_works = log.append(bytes(buffer[:LOG_BLOCK]))
            del buffer[:LOG_BLOCK]
            self._cpu.spend(self._log_cost)
            self._blocks_unsynced += 1
            if self._blocks_unsynced >= LOG_BLOCKS_A_SYNC:
                self._blocks_unsynced = 0
                log.sync()

    def _pack(self, kind: int, *values: float) -> list[bytes]:
        """The frame; none, counted as dropped, when a field cannot hold its value."""
        try:
            return [self._writer.pack(kind, *values)]
        except (struct.error, OverflowError):
            self.dropped += 1
            return []

    def _send_together(self, packed: list[bytes]) -> None:
        """Frames that belong together, in one piece: all of them or none."""
        self._send(b"".join(packed), len(packed))

    def _send(self, data: bytes, count: int = 1) -> None:
        """`count`: how many frames or sentences this is."""
        if self._port.tx_free() >= len(data):
            self._port.write(data)
        else:
            self.dropped += count
        if self._log is not None:
            self._log_buffer += data

    def _utc(self, time_ns: int) -> tuple[int, int]:
        """(UTC time of day in ms, date) of a board time, by the last dated epoch."""
        epoch = self._receiver.latest
        if not epoch[gnss.FLAGS] & gnss.HAS_TIME:
            return frames.NO_TIME_OF_DAY, frames.NO_DATE
        since_ms = (time_ns - epoch[gnss.VALID_NS]) // 1_000_000
        days, time_of_day = divmod(epoch[gnss.TIME_OF_DAY_MS] + since_ms, DAY_MS)
        return time_of_day, (epoch[gnss.DATE_DAYS] + days) & 0xFFFF


def _told_of_epoch(epoch: list[int]) -> tuple[int, ...]:
    """The values of a GNSS frame."""
    return (
        max(epoch[gnss.VALID_NS], EARLIEST_NS) // 1000,
        epoch[gnss.TIME_OF_DAY_MS],
        epoch[gnss.DATE_DAYS],
        epoch[gnss.FLAGS],
        epoch[gnss.LAT_NANODEG],
        epoch[gnss.LON_NANODEG],
        epoch[gnss.HEIGHT_MM],
        epoch[gnss.HEIGHT_MSL_MM],
        epoch[gnss.SPEED_MMPS],
        epoch[gnss.COURSE_E5DEG],
        epoch[gnss.VEL_N_MMPS],
        epoch[gnss.VEL_E_MMPS],
        epoch[gnss.VEL_D_MMPS],
        min(epoch[gnss.SATELLITES], 0xFF),
        min(epoch[gnss.HDOP_CENTI], 0xFFFF),
        epoch[gnss.H_ACC_MM],
        epoch[gnss.V_ACC_MM],
    )
