"""The two-antenna receiver as one object: supply, start, an epoch at its rate, a few commands.

It stands for "dual-antenna GPS, RS-232, NMEA" of the board's document. Its commands are those of Hemisphere
receivers as far as a board needs them (docs/fidelity/dual_antenna.md):

    $JASC,GPGGA,1    rate of a sentence in Hz, 0 for none      answered "$>"
    $JBAUD,38400     bit rate of the port
    $JOFF            no sentences

The pin PPS rises at the top of each second of UTC while there is a fix, for 100 ms.
"""

from __future__ import annotations

from boards.chips.dual_antenna.sentences import SENTENCES, Report, attitude_of
from boards.chips.neo_m8n.timepulse import Pulse, TimePulse, TimePulseSettings
from boards.chips.receivers.fields import xor_checksum
from boards.chips.receivers.receiver import Receiver, check_start_state
from boards.chips.receivers.sentence_input import DOLLAR
from boards.chips.receivers.transmitter import Transmitter
from boards.chips.receivers.utc import utc_from_gps
from boards.chips.registers import ReportKind
from boards.chips.transmit_line import TransmitLine
from boards.chips.world import GnssEpoch, GnssWorld
from hal.emulated.virtual_time import SECOND, VirtualTime

BAUD_RATES = (4800, 9600, 19_200, 38_400, 57_600, 115_200, 230_400)
RATES_HZ = (1, 2, 5, 10, 20)
DEFAULT_SENTENCES = ("GGA", "RMC", "VTG", "HDT", "PASHR")
BOOT_NS = SECOND // 2
FIX_AFTER_NS = {"cold": 40 * SECOND, "warm": 20 * SECOND, "hot": 1 * SECOND}
HEADING_AFTER_NS = 10 * SECOND
"""From the first fix of a start until ambiguities are fixed; a choice."""
BUFFER_BYTES = 4096
LONGEST_LINE = 128
ACCEPTED = b"$>\r\n"
PULSE = TimePulseSettings(
    active=True,
    unlocked=Pulse(SECOND, 0),
    locked=Pulse(SECOND, SECOND // 10),
    delay_ns=0,
    active_high=True,
    utc_grid=True,
)


class DualAntennaReceiver(Receiver[Report]):
    """The receiver. `receive` is its RXD, `tx` the wire at TXD.

    `rate_hz`: epochs a second, 1, 2, 5, 10 or 20; `sentences`: which come with each, of `SENTENCES`; `baud`.
    `antennas`: "along" when the second antenna is before the main one (heading and pitch), "across" when it
    is to its right (heading and roll). `start_state`: "cold", "warm" or "hot". `strict`: reports are raised
    as UndocumentedAccessError. Without a baseline in its world it reports no attitude.
    """

    boot_ns = BOOT_NS

    def __init__(
        self,
        time: VirtualTime,
        world: GnssWorld,
        tx: TransmitLine,
        *,
        rate_hz: int = 1,
        baud: int = 19_200,
        sentences: tuple[str, ...] | list[str] = DEFAULT_SENTENCES,
        antennas: str = "along",
        start_state: str = "hot",
        powered: bool = True,
        strict: bool = False,
        name: str = "dual-antenna receiver",
    ) -> None:
        check_start_state(name, start_state)
        for what, value, possible in (
            ("rate_hz", rate_hz, RATES_HZ),
            ("baud", baud, BAUD_RATES),
            ("antennas", antennas, ("along", "across")),
            *(("sentences", one, tuple(SENTENCES)) for one in sentences),
        ):
            if value not in possible:
                raise ValueError(f"{name}: {what} = {value!r}; possible: {', '.join(map(str, possible))}")
        super().__init__(time, world, Transmitter(time, tx, BUFFER_BYTES), name, strict=strict)
        self.pins = {"PPS": None}
        self._pulse = TimePulse(time)
        self._own_baud = baud
        self._own_sentences = dict.fromkeys(sentences, rate_hz)
        self._rate_hz = rate_hz
        self._across = antennas == "across"
        self._state = start_state
        if powered:
            self.power(True)

    # -- start -------------------------------------------------------------------------------------

    def _begin(self) -> None:
        """Settings made by commands are lost with the supply."""
        self._rates = dict(self._own_sentences)
        self._line = bytearray()
        self._fixed_ns: int | None = None

    def _start_port(self, epoch: GnssEpoch) -> None:
        self._transmitter.start(self._own_baud)
        self._pulse.net = self.pins["PPS"]
        self._pulse.configure(PULSE)

    def _halt(self) -> None:
        super()._halt()
        self._pulse.stop()

    # -- navigation --------------------------------------------------------------------------------

    def _epoch_after(self, epoch: GnssEpoch) -> int:
        period = SECOND // self._rate_hz
        return self._on_grid(epoch.gps_time_ns, period, period // 2)

    def _solve(self, epoch: GnssEpoch, now_ns: int) -> Report:
        fix = epoch.fix and now_ns - self._started_ns >= FIX_AFTER_NS[self._state]
        self._pulse.follow(epoch.gps_time_ns, epoch.leap_seconds, fix)
        if fix and self._fixed_ns is None:
            self._fixed_ns = now_ns
        ready = self._fixed_ns is not None and now_ns - self._fixed_ns >= HEADING_AFTER_NS
        attitude = attitude_of(epoch.baseline, self._across) if fix and ready else None
        utc = utc_from_gps(epoch.gps_time_ns, epoch.leap_seconds)
        time_known = epoch.time_known and (fix or self._fixed_ns is not None)
        place = (epoch.gps_time_ns + SECOND // (2 * self._rate_hz)) % SECOND // (SECOND // self._rate_hz)
        return Report(utc, time_known, fix, epoch, attitude, epoch.satellites, place)

    def _show(self, solution: Report) -> None:
        due = [
            SENTENCES[name](solution)
            for name in SENTENCES
            if (rate := self._rates.get(name, 0)) and solution.place_in_second % (self._rate_hz // rate) == 0
        ]
        if due:
            self._transmitter.send(due)

    # -- commands ----------------------------------------------------------------------------------

    def receive(self, data: bytes, time_ns: int) -> None:
        """Bytes from the host, complete at `time_ns`."""
        if not self._running:
            return
        for byte in data:
            if byte == DOLLAR:
                self._line = bytearray(b"$")
            elif byte in b"\r\n":
                line, self._line = bytes(self._line), bytearray()
                if line:
                    self._obey(line)
            elif self._line and len(self._line) < LONGEST_LINE:
                self._line.append(byte)

    def _obey(self, line: bytes) -> None:
        body, star, digits = line[1:].partition(b"*")
        fields = body.decode("ascii", "replace").split(",")
        if star and digits.upper() != b"%02X" % xor_checksum(body):
            self._report(ReportKind.PROTOCOL, fields[0], "wrong checksum: ignored")
            return
        if fields[0] == "JOFF":
            self._rates.clear()
        elif fields[0] == "JBAUD" and len(fields) >= 2:
            if not self._change_baud(fields[1]):
                return
        elif fields[0] == "JASC" and len(fields) >= 3:
            if not self._change_rate(fields[1:]):
                return
        else:
            self.log.report(ReportKind.NOT_MODELLED, fields[0], "ignored", self._time.now)
            return
        self._transmitter.send([ACCEPTED])

    def _change_baud(self, text: str) -> bool:
        if not (text.isdecimal() and int(text) in BAUD_RATES):
            self.log.report(ReportKind.PROTOCOL, "JBAUD", f"{text} baud: ignored", self._time.now)
            return False
        self._transmitter.send([ACCEPTED])
        self._transmitter.change_baud(int(text))
        return False

    def _change_rate(self, fields: list[str]) -> bool:
        """Sentence and rate; the name may hold a comma (PSAT,HPR)."""
        name, rate = fields[0], fields[-1] if fields[-1] != "OTHER" else fields[-2]
        if len(fields) >= 3 and fields[1] in ("HPR", "AVR"):
            name = f"{fields[0]},{fields[1]}"
        name = name[2:] if name[:2] == "GP" else name
        if name not in SENTENCES or not (rate.isdecimal() and int(rate) in (0, *RATES_HZ)):
            what = f"{','.join(fields)}: ignored"
            self.log.report(ReportKind.PROTOCOL, "JASC", what, self._time.now)
            return False
        if int(rate) and self._rate_hz % int(rate):
            detail = f"{name} at {rate} Hz: the receiver navigates at {self._rate_hz} Hz: ignored"
            self.log.report(ReportKind.PROTOCOL, "JASC", detail, self._time.now)
            return False
        self._rates[name] = int(rate)
        return True
