"""The GR-87 as one object: supply, start, an epoch each second, $PSRF commands.

Fact sheet section 5; what is unconfirmed or a choice stands in docs/fidelity/gr87.md.
"""

from __future__ import annotations

import math
from functools import partial

from boards.chips.gr87.binary import BinaryInput, switch_of
from boards.chips.gr87.commands import BAUD_RATES, Order, order_of
from boards.chips.gr87.sentences import SENTENCES, Picture
from boards.chips.neo_m8n.fields import degrees, sentence
from boards.chips.neo_m8n.input_parser import InputParser, NmeaInput
from boards.chips.neo_m8n.transmitter import Transmitter
from boards.chips.neo_m8n.utc import utc_from_gps
from boards.chips.neo_m8n.wiring import TransmitLine
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.world import GnssEpoch, GnssWorld
from hal.emulated.pins import Net
from hal.emulated.virtual_time import SECOND, Event, VirtualTime

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
START_STATES = ("cold", "warm", "hot")
PROTOCOL_NMEA = 1


class Gr87:
    """The receiver. `receive` is its RXD, `tx` the wire at TXD.

    `start_state`: what the first start finds, "cold", "warm" or "hot". `backup_supply`: keeps clock,
    ephemeris and settings while the supply is off. `baud`: of a part that was configured before, with its
    battery kept. `strict`: reports are raised as UndocumentedAccessError.
    """

    feels = "gnss"
    """The world that it asks."""

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
        if start_state not in START_STATES:
            raise ValueError(f"{name}: start_state {start_state!r} is unknown; use 'cold', 'warm' or 'hot'")
        if baud not in BAUD_RATES:
            raise ValueError(f"{name}: baud = {baud}; possible: {', '.join(map(str, BAUD_RATES))}")
        self.name = name
        self.pins: dict[str, Net | None] = {}
        self.log = AccessLog(name, strict=strict)
        self._time = time
        self._world = world
        self._backup_supply = backup_supply
        self._transmitter = Transmitter(time, tx, BUFFER_BYTES)
        self._state = start_state
        self._baud = baud
        self._forget_settings(baud)
        self._powered = self._running = False
        self._session = 0
        self._next: Event | None = None
        self._off_since_ns: int | None = None
        self._fixed = False
        if powered:
            self.power(True)

    @property
    def reports(self) -> list[AccessReport]:
        """What the host said wrongly, and what it asked for that this model leaves out."""
        return self.log.reports

    @property
    def baud(self) -> int:
        """Bit rate of the port now, both directions."""
        return self._transmitter.baud

    @property
    def messages_dropped(self) -> int:
        """Sentences that found no room in the transmit buffer."""
        return self._transmitter.dropped

    # -- supply and start --------------------------------------------------------------------------

    def power(self, on: bool) -> None:
        """Switch the supply."""
        if on == self._powered:
            return
        self._powered = on
        if not on:
            self._halt()
            self._off_since_ns = self._time.now
            return
        if self._off_since_ns is not None:
            self._wake(self._time.now - self._off_since_ns)
        self._boot()

    def _wake(self, off_ns: int) -> None:
        """What is left after a pause of the supply."""
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

    def _boot(self) -> None:
        self._session += 1
        self._started_ns = self._time.now
        self._course_deg = 0.0
        self._count = 0
        self._fixed = False
        self._shown: Picture | None = None
        self._input, self._binary = InputParser(), BinaryInput()
        self._time.at(self._time.now + BOOT_NS, partial(self._come_up, self._session))

    def _come_up(self, session: int) -> None:
        if session != self._session:
            return
        self._running = True
        self._transmitter.start(self._baud)
        self._next = self._time.at(self._second_after(self._world.epoch(self._time.now)), self._navigate)

    def _halt(self) -> None:
        self._session += 1
        self._running = False
        if self._next is not None:
            self._next.cancel()
            self._next = None
        self._transmitter.stop()

    def _restart(self, state: str) -> None:
        if state == "factory":
            self._forget_settings(DEFAULT_BAUD)
        self._state = "cold" if state == "factory" else state
        self._halt()
        self._boot()

    # -- navigation --------------------------------------------------------------------------------

    def _second_after(self, epoch: GnssEpoch) -> int:
        """Virtual time of the next full second of GPS."""
        step = SECOND - epoch.gps_time_ns % SECOND
        return self._time.now + (step if step >= SECOND // 2 else step + SECOND)

    def _navigate(self) -> int:
        """One epoch; returns when the next one is."""
        epoch = self._world.epoch(self._time.now)
        picture = self._picture(epoch)
        self._time.at(self._time.now + max(0, epoch.latency_ns), partial(self._show, picture, self._session))
        return self._second_after(epoch)

    def _picture(self, epoch: GnssEpoch) -> Picture:
        elapsed = self._time.now - self._started_ns
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
        return Picture(utc, epoch, fix, self._course_deg, satellites)

    def _show(self, picture: Picture, session: int) -> None:
        if session != self._session or not self._running:
            return
        self._shown = picture
        self._count += 1
        if self._nmea:
            due = [number for number, rate in self._rates.items() if rate and self._count % rate == 0]
            self._send(due, picture)

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
            if isinstance(message, NmeaInput) and self._running:
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
            if not self._nmea:
                detail = "SiRF binary: silent until message 129"
                self.log.report(ReportKind.NOT_MODELLED, "PSRF100", detail, self._time.now)
            self._change_baud(order.values[1])
        elif order.action == "rate":
            message, rate, check = order.values
            self._rates[message], self._checked[message] = rate, bool(check)
        elif order.action == "query" and self._shown is not None:
            self._send([order.values[0]], self._shown)
        elif order.action == "development":
            self._development = bool(order.values[0])

    def _obey_binary(self, payload: bytes) -> None:
        switch = switch_of(payload)
        if switch is None:
            what = f"SiRF 0x{payload[0]:02X}" if payload else "SiRF"
            self.log.report(ReportKind.NOT_MODELLED, what, "ignored", self._time.now)
            return
        rates, baud = switch
        if baud not in BAUD_RATES:
            self.log.report(ReportKind.PROTOCOL, "SiRF 0x81", f"{baud} baud: ignored", self._time.now)
            return
        self._nmea = True
        self._rates.update({message: rate for message, rate in rates.items() if message in SENTENCES})
        self._change_baud(baud)

    def _change_baud(self, baud: int) -> None:
        """Behind what has been queued."""
        self._baud = baud
        self._transmitter.change_baud(baud)
