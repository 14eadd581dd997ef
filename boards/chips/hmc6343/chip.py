"""The HMC6343 as a part on a board: a command interface on I²C, modes, a data-ready pin.

A master writes one command byte with its arguments, waits the command's delay, and reads the response, which
is always that of the last command. Nothing runs while nobody looks; the data-ready pin has events only while
somebody follows it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Protocol

from boards.chips.hmc6343 import commands as code
from boards.chips.hmc6343 import compass, eeprom
from boards.chips.hmc6343.commands import ALIASES, COMMANDS, POST_NS, POWER_UP_NS, Command
from boards.chips.hmc6343.eeprom import Eeprom
from boards.chips.hmc6343.measurement import RATES_HZ, SECOND, Measurements
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.world import CompassWorld
from hal.emulated.virtual_time import Event, VirtualTime

FASTEST_HZ = 100_000
UNDRIVEN = 0xFF
LOW_NS = {1: 1_000_000, 5: 200_000, 10: 100_000}
"""How long data ready is low before a measurement is stored; must exceed 750, 150, 75 µs."""

_ORIENTATIONS = {code.LEVEL: compass.LEVEL, code.EDGE: compass.EDGE, code.FRONT: compass.FRONT}
_ORIENTATION_BITS = {
    code.LEVEL: eeprom.LEVEL,
    code.EDGE: eeprom.UPRIGHT_EDGE,
    code.FRONT: eeprom.UPRIGHT_FRONT,
}
_SLEEPING, _STANDBY, _RUNNING = "sleep", "standby", "run"
_TRANSITIONS = {
    code.RUN: (_STANDBY, _RUNNING),
    code.STANDBY: (_RUNNING, _STANDBY),
    code.SLEEP: (_RUNNING, _SLEEPING),
    code.WAKE: (_SLEEPING, _STANDBY),
}
"""From which mode to which."""


class PinNet(Protocol):
    """What the chip needs of the net on its pin."""

    on_first_listener: object

    @property
    def listened(self) -> bool:
        """Whether anybody follows the level."""
        ...

    def set(self, level: bool) -> None:
        """Drive the level."""
        ...


class Pins(dict[str, "PinNet | None"]):
    """The nets of the pins; the chip is told when one is put in."""

    def __init__(self, wired: Callable[[], None]) -> None:
        super().__init__(DRDY=None)
        self._wired = wired

    def __setitem__(self, pin: str, net: PinNet | None) -> None:
        super().__setitem__(pin, net)
        self._wired()


class Hmc6343:
    """One HMC6343. `i2c` is its bus face, `pins` takes the net of DRDY, `reports` tells what was touched
    outside the documents.

    `clock_error_ppm`: how much its clock is fast. `early`: what comes of a read or command within the delay
    of the last command: "old" (the response before, the command is lost) or "nack". `serial_number`: 16 bits.
    `start_ns`: when its supply comes up. `strict`: reports are raised as UndocumentedAccessError.
    """

    feels: ClassVar[str] = "compass"
    """The world that it asks."""
    measures: ClassVar[tuple[str, ...]] = ("mag", "accel", "temperature")
    """Of what the world tells."""

    def __init__(
        self,
        time: VirtualTime,
        world: CompassWorld,
        *,
        clock_error_ppm: float = 0.0,
        early: str = "old",
        serial_number: int = 1,
        start_ns: int = 0,
        strict: bool = False,
        name: str = "HMC6343",
    ) -> None:
        if early not in ("old", "nack"):
            raise ValueError(f'{name}: early = {early!r}; possible: "old", "nack"')
        if not 0 <= serial_number <= 0xFFFF:
            raise ValueError(f"{name}: serial_number = {serial_number}; it has 16 bits, e.g. 1234")
        self.name = name
        self.log = AccessLog(name, strict=strict)
        self.pins = Pins(self._listener_arrived)
        self.eeprom = Eeprom(serial_number, version=5, year=14, week=20)
        self.i2c = self
        self.address = self.eeprom[eeprom.SLAVE_ADDRESS] >> 1
        """At which it is put on its bus."""
        self._time = time
        self._nacks = self._nacks_early = early == "nack"
        self._slowness = 1.0
        """By which the delays of its commands are longer than the sheet's."""
        self._measurements = Measurements(world, round(clock_error_ppm * 1000.0))
        self._too_fast = False
        self._event: Event | None = None
        self._powered = True
        self._power_up(start_ns)

    @property
    def reports(self) -> list[AccessReport]:
        """Accesses outside the documents, the first of each kind with its time."""
        return self.log.reports

    # -- supply ------------------------------------------------------------------------------------

    def power(self, on: bool) -> None:
        """Switch the supply, now. The EEPROM keeps its content."""
        if on == self._powered:
            return
        self._powered = on
        if on:
            self._power_up(self._time.now)
        else:
            self._measurements.reset(1, 1)
            self._schedule(self._time.now)

    def brownout(self) -> None:
        """A dip of the supply, now."""
        self.power(False)
        self.power(True)

    def _power_up(self, time_ns: int) -> None:
        """Everything from the EEPROM; the part answers after 500 ms, with a measurement if it runs."""
        memory = self.eeprom
        self._answers_ns = self._ready_ns = time_ns + POWER_UP_NS
        self._response = self._old = b""
        self._answers: dict[bytes, bytes] = {}
        """To commands, worked out from what is measured; until there is more, or a setting changes."""
        self._live_address = memory[eeprom.SLAVE_ADDRESS] >> 1
        mode = memory[eeprom.OP_MODE_1]
        self._filter = memory[eeprom.FILTER] if mode & eeprom.FILTER_ON else 0
        self._filter_on = mode & eeprom.FILTER_ON
        self._offsets = [float(memory.word(eeprom.X_OFFSET + 2 * axis)) for axis in range(3)]
        self._orientation = next((key for key, bit in _ORIENTATION_BITS.items() if mode & bit), code.LEVEL)
        self._measurements.reset(RATES_HZ[memory[eeprom.OP_MODE_2]], self._filter + 1)
        self._mode = _STANDBY if mode & eeprom.STANDBY or not mode & eeprom.RUN else _RUNNING
        if self._mode == _RUNNING:
            self._measurements.start(self._answers_ns)
        self._schedule(max(time_ns, self._time.now))

    # -- defects -----------------------------------------------------------------------------------

    def pretend_id(self, address_byte: int | None) -> None:
        """EEPROM 0x00, by which drivers know the part, reads otherwise; None: as it is again."""
        self.eeprom.pretend_address(address_byte)

    def set_clock_error(self, ppm: float) -> None:
        """Its clock runs fast by so much from now on."""
        self._measurements.set_clock_error(self._time.now, round(ppm * 1000.0))
        self._schedule(self._time.now)

    def be_busy(self, factor: float, nacks: bool) -> None:
        """From now on each command takes `factor` times its delay; what comes within is refused, or gets the
        response before."""
        if not 1.0 <= factor <= 10_000.0:
            raise ValueError(f"delays {factor} times as long; the factor lies in 1 … 10000, e.g. 5.0")
        self._slowness, self._nacks = factor, nacks

    def be_prompt(self) -> None:
        """With its own delays again."""
        self._slowness, self._nacks = 1.0, self._nacks_early

    # -- I²C ---------------------------------------------------------------------------------------

    def clocked_at(self, frequency_hz: int) -> None:
        """The bus tells its clock."""
        self._too_fast = frequency_hz > FASTEST_HZ

    def listens(self, time_ns: int) -> bool:
        """Whether the part acknowledges its address."""
        return self._powered and time_ns >= self._answers_ns and self._live_address == self.address

    def write(self, data: bytes, time_ns: int) -> int:
        """A command with its arguments. Returns how many bytes were acknowledged."""
        if not self.listens(time_ns):
            return 0
        if self._too_fast:
            self._complain_of_clock(time_ns)
        if not data:
            return 0
        known = self._answers.get(data)
        if known is not None and self._ready_ns <= time_ns < self._measurements.until_ns:
            self._ready_ns = time_ns + round(POST_NS * self._slowness)
            self._old, self._response = self._response, known
            return 1
        if time_ns < self._ready_ns:
            self._report(ReportKind.TIMING, "command within the delay of the last one: lost", time_ns)
            return 0 if self._nacks else len(data)
        number = ALIASES.get(data[0], data[0])
        command = COMMANDS.get(number)
        self._old, self._response = self._response, b""
        if command is None:
            self._report(ReportKind.PROTOCOL, f"unknown command 0x{data[0]:02X}: ignored", time_ns)
        elif len(data) - 1 != command.arguments:
            detail = f"{command.name}: {len(data) - 1} arguments instead of {command.arguments}: ignored"
            self._report(ReportKind.PROTOCOL, detail, time_ns)
        elif self._mode == _SLEEPING and number not in (code.WAKE, code.RESET):
            self._report(ReportKind.PROTOCOL, f"{command.name} in sleep: ignored", time_ns)
        else:
            self._obey(number, command, data[1:], time_ns)
        return len(data)

    def read(self, length: int, time_ns: int) -> bytes:
        """The response of the last command; 0xFF beyond it."""
        if not self.listens(time_ns):
            return bytes((UNDRIVEN,)) * length
        if self._too_fast:
            self._complain_of_clock(time_ns)
        response = self._response
        if time_ns < self._ready_ns:
            self._report(ReportKind.TIMING, "read within the delay of the command: undefined", time_ns)
            response = b"" if self._nacks else self._old
        elif length > len(response):
            self._report(ReportKind.PROTOCOL, "read of more than the response: undefined", time_ns)
        if length == len(response):
            return response
        return response[:length] + bytes((UNDRIVEN,)) * (length - len(response))

    def _complain_of_clock(self, time_ns: int) -> None:
        detail = "clock faster than 100 kHz: undefined, served as if it were slower"
        self._report(ReportKind.TIMING, detail, time_ns)

    def _report(self, kind: ReportKind, detail: str, time_ns: int) -> None:
        self.log.report(kind, "I2C", detail, time_ns)

    # -- commands ----------------------------------------------------------------------------------

    def _obey(self, number: int, command: Command, arguments: bytes, time_ns: int) -> None:
        self._ready_ns = time_ns + round(command.delay_ns * self._slowness)
        if command.response and number != code.READ_EEPROM:
            self._response = self._answer(number, time_ns)
            return
        self._answers.clear()
        if number == code.READ_EEPROM:
            value, wrong = self.eeprom.read(arguments[0])
            self._response = bytes((value,))
            self._complain(wrong, time_ns)
        elif number == code.WRITE_EEPROM:
            self._complain(self.eeprom.write(arguments[0], arguments[1]), time_ns)
        elif number in _ORIENTATIONS:
            self._orientation = number
        elif number in (code.ENTER_CALIBRATION, code.EXIT_CALIBRATION):
            self._calibrate(number == code.ENTER_CALIBRATION, time_ns)
        elif number == code.RESET:
            self._measurements.reset(1, 1)
            self._power_up(time_ns)
        else:
            self._change_mode(number, command, time_ns)

    def _complain(self, wrong: str, time_ns: int) -> None:
        if wrong:
            self._report(ReportKind.RESERVED_VALUE, wrong, time_ns)

    def _change_mode(self, number: int, command: Command, time_ns: int) -> None:
        source, target = _TRANSITIONS[number]
        if self._mode == target or (number == code.WAKE and self._mode != source):
            return
        if self._mode != source:
            self._complain(f"{command.name} from {self._mode}; the sheet has it from {source}", time_ns)
        self._mode = target
        if target == _RUNNING:
            self._measurements.start(time_ns + SECOND // self._measurements.rate_hz)
        else:
            self._measurements.stop(time_ns)
        self._schedule(max(time_ns, self._time.now))

    def _calibrate(self, enter: bool, time_ns: int) -> None:
        measurements = self._measurements
        if enter and self._mode != _RUNNING:
            self._complain("enter calibration: only in run mode", time_ns)
        elif enter:
            measurements.enter_calibration(time_ns)
        elif not measurements.calibrating:
            self._complain("exit calibration: none was entered", time_ns)
        else:
            for axis, offset in enumerate(measurements.exit_calibration(time_ns)):
                if offset is not None:
                    self.eeprom.set_word(eeprom.X_OFFSET + 2 * axis, offset)
                    self._offsets[axis] = offset

    # -- responses ---------------------------------------------------------------------------------

    def _answer(self, number: int, time_ns: int) -> bytes:
        if number == code.POST_OP_MODE:
            return bytes((self._op_mode(time_ns),))
        if self._measurements.advance(time_ns):
            self._answers.clear()
        answer = self._answers[bytes((number,))] = self._worked_out(number)
        return answer

    def _worked_out(self, number: int) -> bytes:
        """The response to a command for measured values."""
        rows = self._measurements.rows
        if not rows:
            return bytes(COMMANDS[number].response)
        newest = rows[-1]
        orientation = _ORIENTATIONS[self._orientation]
        if number == code.POST_ACCELEROMETER:
            return _words(*compass.accelerometer_counts(newest[:3]))
        if number == code.POST_MAGNETOMETER:
            field = compass.limited(newest[3:6])
            counts = zip(field, self._offsets, strict=True)
            return _words(*(value / compass.TESLA_PER_COUNT + offset for value, offset in counts))
        pitch, roll = compass.tilt(newest[:3], orientation)
        tilt = (_tenths(pitch), _tenths(roll))
        if number == code.POST_TILT:
            return _words(*tilt, newest[6] * 10.0)
        return self._heading().to_bytes(2, "big") + _words(*tilt)

    def _heading(self) -> int:
        """Tenths of a degree, filtered, with deviation and variation."""
        orientation = _ORIENTATIONS[self._orientation]
        added_t = [offset * compass.TESLA_PER_COUNT for offset in self._offsets]
        headings = []
        for row in self._measurements.rows:
            field = [a + b for a, b in zip(compass.limited(row[3:6]), added_t, strict=True)]
            headings.append(compass.heading(row[:3], field, orientation))
        added = self.eeprom.word(eeprom.DEVIATION) + self.eeprom.word(eeprom.VARIATION)
        return round(compass.weighted_heading(headings) * 10.0 + added) % 3600

    def _op_mode(self, time_ns: int) -> int:
        """OP mode 1 as it is now."""
        next_ns = self._measurements.next_ns(time_ns)
        computing = next_ns is not None and next_ns - time_ns <= LOW_NS[self._measurements.rate_hz]
        return (
            (eeprom.COMPUTING if computing else 0)
            | (eeprom.CALIBRATING if self._measurements.calibrating else 0)
            | self._filter_on
            | (eeprom.RUN if self._mode == _RUNNING else 0)
            | (eeprom.STANDBY if self._mode == _STANDBY else 0)
            | _ORIENTATION_BITS[self._orientation]
        )

    # -- data ready --------------------------------------------------------------------------------

    def _schedule(self, time_ns: int) -> None:
        """Low before each measurement is stored, high from then on; low while nothing is measured."""
        if self._event is not None:
            self._event.cancel()
            self._event = None
        net = self.pins["DRDY"]
        if net is None:
            return
        net.on_first_listener = self._listener_arrived
        if not net.listened:
            return
        next_ns = self._measurements.next_ns(time_ns) if self._powered else None
        if next_ns is None:
            net.set(False)
            return
        falls_ns = next_ns - LOW_NS[self._measurements.rate_hz]
        low = time_ns >= falls_ns or time_ns < self._answers_ns or next_ns == self._measurements.next_ns(0)
        net.set(not low)
        self._event = self._time.at(next_ns if low else falls_ns, self._change_pin)

    def _change_pin(self) -> int | None:
        net = self.pins["DRDY"]
        now = self._time.now
        next_ns = self._measurements.next_ns(now)
        if net is None or next_ns is None or not net.listened:
            self._event = None
            return None
        falls_ns = next_ns - LOW_NS[self._measurements.rate_hz]
        net.set(now < falls_ns)
        return falls_ns if now < falls_ns else next_ns

    def _listener_arrived(self) -> None:
        self._schedule(self._time.now)


def _tenths(degrees: float) -> int:
    """Tenths of a degree within ±90.0."""
    return max(-900, min(900, round(degrees * 10.0)))


def _words(*values: float) -> bytes:
    """Signed 16 bits, big endian, saturated."""
    return b"".join(max(-32768, min(32767, round(v))).to_bytes(2, "big", signed=True) for v in values)
