"""The GR-87 as one object: supply, start, an epoch each second, $PSRF commands.

Fact sheet section 5; what is unconfirmed or a choice stands in docs/fidelity/gr87.md.
"""

from __future__ import annotations

import math

from boards.chips.gr87.binary import (
    EIGHT_ONE_NONE,
    POLL_VERSION,
    SET_PORT,
    SET_RATE,
    SWITCH_TO_NMEA,
    WITHOUT_EFFECT,
    BinaryInput,
    switch_of,
)
from boards.chips.gr87.binary_output import MESSAGES, answer, version
from boards.chips.gr87.commands import BAUD_RATES, Order, order_of
from boards.chips.gr87.sentences import SENTENCES, Picture
from boards.chips.receivers.fields import degrees, sentence
from boards.chips.receivers.receiver import Receiver, check_start_state
from boards.chips.receivers.sentence_input import SentenceInput
from boards.chips.receivers.transmitter import Transmitter
from boards.chips.receivers.utc import utc_from_gps
from boards.chips.registers import ReportKind
from boards.chips.transmit_line import TransmitLine
from boards.chips.world import GnssEpoch, GnssWorld
from hal.emulated.virtual_time import SECOND, VirtualTime

DEFAULT_BAUD = 4800
DEFAULT_RATES = {0: 1, 1: 0, 2: 1, 3: 1, 4: 1, 5: 0, 8: 0}
"""GGA, GSA, GSV, RMC each second; the others on demand."""
BOOT_NS = SECOND // 2
FIX_AFTER_NS = {"cold": 42 * SECOND, "warm": 38 * SECOND, "hot": 1 * SECOND}
TIME_AFTER_NS = {"cold": 30 * SECOND, "warm": 0, "hot": 0}
EPHEMERIS_NS = 4 * 3600 * SECOND
BUFFER_BYTES = 2048
LOWEST_COURSE_SPEED = 0.1
UNSET_CLOCK_GPS_NS = 0
"""1980-01-06 00:00 at power-up, until the time is known."""
PROTOCOL_NMEA = 1


class Gr87(Receiver[Picture]):
    """The receiver. `receive` is its RXD, `tx` the wire at TXD.

    `start_state`: what the first start finds, "cold", "warm" or "hot". `backup_supply`: keeps clock,
    ephemeris and settings while the supply is off. `baud`: of a part that was configured before, with its
    battery kept. `strict`: reports are raised as UndocumentedAccessError.
    """

    boot_ns = BOOT_NS

    def __init__(
        self,
        time: VirtualTime,
        world: GnssWorld,
        tx: TransmitLine,
        *,
        start_state: str = "cold",
        backup_supply: bool = True,
        baud: int = DEFAULT_BAUD,
        powered: bool = True,
        strict: bool = False,
        name: str = "GR-87",
    ) -> None:
        check_start_state(name, start_state)
        if baud not in BAUD_RATES:
            raise ValueError(f"{name}: baud = {baud}; possible: {', '.join(map(str, BAUD_RATES))}")
        super().__init__(time, world, Transmitter(time, tx, BUFFER_BYTES), name, strict=strict)
        self._backup_supply = backup_supply
        self._state = start_state
        self._forget_settings(baud)
        self._fixed = False
        if powered:
            self.power(True)

    # -- start -------------------------------------------------------------------------------------

    def _wake(self, off_ns: int) -> None:
        if not self._backup_supply:
            self._forget_settings(DEFAULT_BAUD)
            self._state = "cold"
        elif self._fixed:
            self._state = "hot" if off_ns < EPHEMERIS_NS else "warm"

    def _forget_settings(self, baud: int) -> None:
        self._baud = baud
        self._nmea = True
        self._rates = dict(DEFAULT_RATES)
        self._checked = dict.fromkeys(DEFAULT_RATES, True)
        self._development = False
        self._spoken = dict.fromkeys(MESSAGES, 1)
        """Binary messages and their rates in s."""

    def _begin(self) -> None:
        self._course_deg = 0.0
        self._count = 0
        self._fixed = False
        self._shown = None
        self._input, self._binary = SentenceInput(), BinaryInput()

    def _start_port(self, epoch: GnssEpoch) -> None:
        self._transmitter.start(self._baud)

    def _restart(self, state: str) -> None:
        if state == "factory":
            self._forget_settings(DEFAULT_BAUD)
        self._state = "cold" if state == "factory" else state
        self._reset()

    # -- navigation --------------------------------------------------------------------------------

    def _epoch_after(self, epoch: GnssEpoch) -> int:
        return self._on_grid(epoch.gps_time_ns, SECOND, SECOND // 2)

    def _solve(self, epoch: GnssEpoch, now_ns: int) -> Picture:
        elapsed = now_ns - self._started_ns
        satellites = tuple(one for one in epoch.satellites if one.system == "GPS")
        used = sum(one.used for one in satellites)
        fix = 1
        if epoch.fix and elapsed >= FIX_AFTER_NS[self._state] and used >= 3:
            fix = 3 if used > 3 else 2
            self._fixed = True
            north, east, _ = epoch.velocity_ned
            if math.hypot(north, east) >= LOWEST_COURSE_SPEED:
                self._course_deg = degrees(math.atan2(east, north)) % 360.0
        told = epoch.time_known and (elapsed >= TIME_AFTER_NS[self._state] or fix > 1)
        gps_ns = epoch.gps_time_ns if told else UNSET_CLOCK_GPS_NS + elapsed
        utc = utc_from_gps(gps_ns, epoch.leap_seconds if told else 0)
        return Picture(utc, epoch, fix, self._course_deg, satellites, gps_ns)

    def _show(self, solution: Picture) -> None:
        self._count += 1
        if self._nmea:
            due = [number for number, rate in self._rates.items() if rate and self._count % rate == 0]
            self._send(due, solution)
        else:
            spoken = [number for number, rate in self._spoken.items() if rate and self._count % rate == 0]
            self._transmitter.send([MESSAGES[number](solution) for number in spoken])

    def _send(self, messages: list[int], picture: Picture) -> None:
        lines = []
        for number in sorted(messages):
            lines += [
                line if self._checked[number] else line[:-5] + b"\r\n" for line in SENTENCES[number](picture)
            ]
        self._transmitter.send(lines)

    # -- commands ----------------------------------------------------------------------------------

    def receive(self, data: bytes, time_ns: int) -> None:
        """Bytes from the host, complete at `time_ns`."""
        if not self._running:
            return
        if not self._nmea:
            for payload in self._binary.feed(data):
                self._obey_binary(payload)
            return
        for message in self._input.feed(data):
            if self._running:
                self._obey(message.fields)

    def _obey(self, fields: tuple[str, ...]) -> None:
        order = order_of(fields)
        if order.problem:
            self.log.report(ReportKind.PROTOCOL, fields[0], order.problem, self._time.now)
            if self._development:
                self._transmitter.send([sentence(b"PSRFTXT,%b" % order.problem.encode("ascii", "replace"))])
        elif order.not_modelled:
            self.log.report(ReportKind.NOT_MODELLED, fields[0], order.not_modelled, self._time.now)
        else:
            self._carry_out(order)

    def _carry_out(self, order: Order) -> None:
        if order.action == "restart":
            self._restart(order.state)
        elif order.action == "port":
            self._nmea = order.values[0] == PROTOCOL_NMEA
            self._change_baud(order.values[1])
        elif order.action == "rate":
            message, rate, check = order.values
            self._rates[message], self._checked[message] = rate, bool(check)
        elif order.action == "query" and self._shown is not None:
            self._send([order.values[0]], self._shown)
        elif order.action == "development":
            self._development = bool(order.values[0])

    def _obey_binary(self, payload: bytes) -> None:
        number = payload[0] if payload else 0
        if number == SWITCH_TO_NMEA:
            self._back_to_nmea(payload)
        elif number == POLL_VERSION and len(payload) == 2:
            self._transmitter.send([answer(True, number), version()])
        elif number == SET_PORT and len(payload) == 9:
            self._set_port(payload)
        elif number == SET_RATE and len(payload) == 8:
            self._set_binary_rate(*payload[1:4])
        else:
            known = number in WITHOUT_EFFECT
            what = "without effect" if known else f"{len(payload)} bytes: refused"
            self._report(ReportKind.NOT_MODELLED, f"SiRF 0x{number:02X}", what)
            self._transmitter.send([answer(known, number)])

    def _back_to_nmea(self, payload: bytes) -> None:
        switch = switch_of(payload)
        if switch is None or switch[1] not in BAUD_RATES:
            what = "" if switch is None else f", {switch[1]} baud"
            self._report(ReportKind.PROTOCOL, "SiRF 0x81", f"{len(payload)} bytes{what}: refused")
            self._transmitter.send([answer(False, SWITCH_TO_NMEA)])
            return
        rates, baud = switch
        self._nmea = True
        self._rates.update({message: rate for message, rate in rates.items() if message in SENTENCES})
        self._change_baud(baud)

    def _set_port(self, payload: bytes) -> None:
        baud = int.from_bytes(payload[1:5], "big")
        good = baud in BAUD_RATES and payload[5:8] == EIGHT_ONE_NONE
        if not good:
            self._report(ReportKind.PROTOCOL, "SiRF 0x86", f"{baud} baud, {payload[5:8].hex()}: refused")
        self._transmitter.send([answer(good, SET_PORT)])
        if good:
            self._change_baud(baud)

    def _set_binary_rate(self, mode: int, message: int, rate: int) -> None:
        """Messages that it does not have are accepted and stay silent."""
        wanted = list(MESSAGES) if mode == 2 else [message]
        good = mode <= 2
        self._transmitter.send([answer(good, SET_RATE)])
        if good and mode != 1:
            self._spoken.update({number: rate for number in wanted if number in MESSAGES})
        elif good and message in MESSAGES and self._shown is not None:
            self._transmitter.send([MESSAGES[message](self._shown)])

    def _change_baud(self, baud: int) -> None:
        """Behind what has been queued."""
        self._baud = baud
        self._transmitter.change_baud(baud)
