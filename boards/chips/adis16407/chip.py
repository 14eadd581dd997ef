"""The ADIS16407 as a part on a board: 16-bit words on SPI, a one-word pipeline, the burst.

    DIN    read A | read B | 0x4200 |   0    |   0   | …
    DOUT     ?    |   A    |   B    | SUPPLY | XGYRO | … | AUX_ADC

Chip select may go high after every word or stay low over several; within one low period everything is read
and written as of its beginning. The usual access, a burst of a sample that nobody has read, is one slice.
"""

from __future__ import annotations

from bisect import bisect_right

from boards.chips.adis16407.core import ALL_UNREAD, DEFECTS, SPI_ERROR, Core
from boards.chips.adis16407.elements import elements
from boards.chips.adis16407.flash import Flash
from boards.chips.adis16407.pins import Pins, PinSide
from boards.chips.adis16407.register_map import DIAG_STAT, GLOB_CMD, GPIO_CTRL, OUTPUTS, PROD_ID, REGISTERS
from boards.chips.adis16407.sampler import NEAR, STRIDE
from boards.chips.adis16407.settings import is_slow
from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.world import TenDofWorld
from hal.emulated.virtual_time import SECOND, VirtualTime

BURST = bytes((GLOB_CMD,)) + bytes(29)
FASTEST_HZ, FASTEST_BURST_HZ, FASTEST_SLOW_HZ = 2_000_000, 1_000_000, 300_000
STALL_NS, SLOW_STALL_NS = 9_000, 75_000
NOTHING = b"\x00\x00"
OVERRIDABLE = frozenset(register.address for register in REGISTERS if not register.address & 1)
DAC_V_PER_COUNT = 0.806e-3


class Adis16407:
    """One ADIS16407. `transaction` is its bus face; `pins` takes the nets of DIO1 … DIO4 and RST.

    `clock_error_ppm`: how much its sample clock is fast. `supply_v`, `aux_adc_v`: supply and voltage at the
    ADC input, which may be set later too. `serial_number`, `lot_id` (32 bits), `flash_count`: of this unit.
    `defects`: what is broken ("gyro_x" … "accel_z", "barometer"), as the self-test finds it.
    `g_effect_dps_per_g`, `accelerometer_places_mm`: what MSC_CTRL bits 7 and 6 take out (see `elements`).
    `start_ns`: when its supply comes up. `strict`: reports are raised as UndocumentedAccessError.
    """

    feels = "ten_dof"
    """The world that it asks."""
    measures = ("gyro", "accel", "mag", "pressure", "temperature")
    """Of what the world tells."""
    spi_modes = (3,)
    identity_register = PROD_ID

    def __init__(
        self,
        time: VirtualTime,
        world: TenDofWorld,
        *,
        clock_error_ppm: float = 0.0,
        supply_v: float = 5.0,
        aux_adc_v: float = 0.0,
        serial_number: int = 1,
        lot_id: int = 1,
        flash_count: int = 0,
        defects: tuple[str, ...] | list[str] = (),
        g_effect_dps_per_g: float = 0.0,
        accelerometer_places_mm: list[list[float]] | None = None,
        start_ns: int = 0,
        strict: bool = False,
        name: str = "ADIS16407",
    ) -> None:
        for what, value, bits in (("serial_number", serial_number, 16), ("lot_id", lot_id, 32),
                                  ("flash_count", flash_count, 16)):  # fmt: skip
            if not 0 <= value < 1 << bits:
                raise ValueError(f"{name}: {what} = {value}; it has {bits} bits, e.g. 1234")
        self.name = name
        self.log = AccessLog(name, strict=strict)
        self._time = time
        identity = (lot_id & 0xFFFF, lot_id >> 16, serial_number)
        error_ppb = round(clock_error_ppm * 1000.0)
        self._core = core = Core(world, self.log, error_ppb, Flash(flash_count), identity)
        self._sampler = core.sampler
        core.sampler.elements = elements(name, g_effect_dps_per_g, accelerometer_places_mm)
        self.break_parts(*defects)
        core.set_analog(0, _volts(name, "supply_v", supply_v), _volts(name, "aux_adc_v", aux_adc_v))
        self._side = PinSide(time, core, self.log, self._reset_pin)
        self.pins: Pins = self._side.pins
        self._powered = True
        self._held_in_reset = False
        self._frequency_hz = 0
        self._vetted: set[tuple[int, int, bool, bool]] = set()
        self._usual_burst_ns = -1
        """So long a burst lasts that breaks no rule with the present settings."""
        self._ended_ns = -SECOND
        self._answer = NOTHING
        core.start_up(start_ns)

    @property
    def reports(self) -> list[AccessReport]:
        """Accesses outside the documents or the model, the first of each kind with its time."""
        return self.log.reports

    # -- surroundings ------------------------------------------------------------------------------

    def power(self, on: bool) -> None:
        """Switch the supply, now. The flash keeps its content, unless it is being written."""
        if on == self._powered:
            return
        self._core.advance(self._time.now)
        self._powered = on
        self._restart()

    def brownout(self) -> None:
        """A dip of the supply, now."""
        self.power(False)
        self.power(True)

    def _reset_pin(self, held: bool) -> None:
        """An undriven net stands low at first; the part's own pull-up then counts."""
        if held == self._held_in_reset:
            return
        self._core.advance(self._time.now)
        self._held_in_reset = held
        self._restart()

    def _restart(self) -> None:
        self._answer = NOTHING
        if self._powered and not self._held_in_reset:
            self._core.shut_down()
            self._core.start_up(self._time.now)
        else:
            self._core.shut_down()
        self._side.schedule()

    @property
    def supply_v(self) -> float:
        """Supply voltage; the part measures it."""
        return self._core.sampler.supply_v

    @supply_v.setter
    def supply_v(self, volts: float) -> None:
        self._core.set_analog(self._time.now, supply_v=_volts(self.name, "supply_v", volts))

    @property
    def aux_adc_v(self) -> float:
        """Voltage at the ADC input."""
        return self._core.sampler.adc_v

    @aux_adc_v.setter
    def aux_adc_v(self, volts: float) -> None:
        self._core.set_analog(self._time.now, adc_v=_volts(self.name, "aux_adc_v", volts))

    @property
    def aux_dac_v(self) -> float:
        """Voltage at the DAC output."""
        return self._core.dac_code * DAC_V_PER_COUNT if self._powered else 0.0

    def break_parts(self, *parts: str) -> None:
        """Have the self-test find these parts broken, and no others."""
        for part in parts:
            if part not in DEFECTS:
                raise ValueError(f"{self.name}: defect {part!r}; possible: {', '.join(DEFECTS)}")
        self._core.defects = frozenset(parts)

    # -- defects -----------------------------------------------------------------------------------

    def pretend_id(self, product: int | None) -> None:
        """Answer with another PROD_ID; None: with its own again."""
        for byte in range(2):
            part = None if product is None else product >> 8 * byte & 0xFF
            self._core.registers.pretend(PROD_ID + byte, part)

    def set_clock_error(self, ppm: float) -> None:
        """Its sample clock runs fast by so much behind the next sample."""
        self._core.look_anew(self._time.now, round(ppm * 1000.0))
        self._side.schedule()

    def look_anew(self) -> None:
        """Ask the world again for the samples to come: it has changed."""
        self._core.look_anew(self._time.now, None)
        self._side.schedule()

    def halt(self, on: bool) -> None:
        """Its sample clock stands still: outputs stay, without ND once they are read; or it goes on."""
        self._core.halt(on, self._time.now)
        self._side.schedule()

    def raise_flags(self, flags: int) -> None:
        """DIAG_STAT shows these flags with every sample from now on; 0: no more."""
        self._core.trouble(flags, self._time.now)
        self._side.schedule()

    def override_register(self, address: int, value: int | None) -> None:
        """Have every read of a register, alone or in a burst, give a value; None: its own again."""
        if address not in OVERRIDABLE or not 0 <= (value or 0) <= 0xFFFF:
            raise ValueError(
                f"{self.name}: register 0x{address:X} as 0x{value or 0:X}; an even address of a register"
                " and 16 bits, e.g. 0x56 as 0x4018"
            )
        self._core.override(address, value)

    @property
    def overridden_reads(self) -> int:
        """How often a read gave what it was made to give."""
        return self._core.overridden_reads

    # -- SPI ---------------------------------------------------------------------------------------

    def clocked_at(self, frequency_hz: int) -> None:
        """The bus tells its clock; without that it is judged by the length of transactions."""
        self._frequency_hz = frequency_hz
        self._vetted.clear()
        self._usual_burst_ns = -1

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period; see `hal.emulated.spi.SpiSlave`."""
        core, sampler = self._core, self._sampler
        if (
            mosi == BURST
            and sampler.next_ns <= start_ns < sampler.smooth_until_ns
            and end_ns - start_ns == self._usual_burst_ns
            and start_ns - self._ended_ns >= STALL_NS
            and start_ns < core.done_ns
            and not (core.diagnosis or core.lasting_flags or core.overrides)
        ):
            first = sampler.row + 1
            row = bisect_right(sampler.times, start_ns, first, first + NEAR)
            next_ns = sampler.times[row]
            if next_ns > start_ns:
                self._ended_ns = end_ns
                sampler.row = row - 1
                sampler.next_ns = next_ns
                core.unread = 0
                words = sampler.image[(row - 1) * STRIDE : row * STRIDE]
                answer = self._answer
                self._answer = words[-2:]
                return answer + words
        return self._transaction(mosi, start_ns, end_ns)

    def _transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        if not self._powered or self._held_in_reset:
            return b"\xff" * len(mosi)
        if not mosi:
            return b""
        core = self._core
        if start_ns < core.answers_ns:
            self._ended_ns = end_ns
            if core.wakes_on_select:
                core.selected(start_ns)
                self._side.schedule()
            else:
                self._late("access while starting up or asleep: lost", start_ns)
            return bytes(len(mosi))
        core.advance(start_ns)
        words, rest = divmod(len(mosi), 2)
        allowed = self._check_times(words, mosi[0] & 0xFE == GLOB_CMD and words > 1, start_ns, end_ns)
        miso = self._words(mosi, start_ns)
        if mosi == BURST:
            self._usual_burst_ns = end_ns - start_ns if allowed and not is_slow(core.registers.values) else -1
        if rest:
            core.diagnosis |= SPI_ERROR
            detail = "clocks are no multiple of 16: the last word is lost"
            self.log.report(ReportKind.PROTOCOL, "SPI", detail, start_ns)
            miso += b"\x00"
        return miso

    def _words(self, mosi: bytes | bytearray, time_ns: int) -> bytes:
        """Whole words, each answered by what the one before asked for."""
        if len(mosi) == 2 and mosi[0] < 0x80 and mosi[0] & 0x7E != DIAG_STAT:
            answer = self._answer
            self._answer = self._read(mosi[0], time_ns).to_bytes(2, "big")
            return answer
        miso = bytearray()
        count = len(mosi) // 2
        k = 0
        changed = False
        while k < count:
            miso += self._answer
            high, low = mosi[2 * k], mosi[2 * k + 1]
            k += 1
            if high & 0x80:
                changed = True
                self._core.write(high & 0x7F, low, time_ns)
                if time_ns < self._core.answers_ns:  # a reset, or sleep
                    self._answer = NOTHING
                    break
            elif high & 0x7E == GLOB_CMD and k < count:
                miso += self._burst(mosi[2 * k : 2 * (k + len(OUTPUTS))], time_ns)
                k += len(OUTPUTS)
            else:
                self._answer = self._read(high, time_ns).to_bytes(2, "big")
                changed = changed or high & 0x7E == DIAG_STAT
        if changed:
            self._usual_burst_ns = -1
            self._side.schedule()
        return bytes(miso) + bytes(2 * count - len(miso))

    def _read(self, address: int, time_ns: int) -> int:
        value = self._core.read(address, time_ns)
        return value & 0xFF | self._side.levels() if address & 0x7E == GPIO_CTRL else value

    def _burst(self, mosi: bytes | bytearray, time_ns: int) -> bytes:
        """The outputs in a row, as long as it is clocked."""
        words = len(mosi) // 2
        if any(mosi):
            detail = "data in during a burst: ignored"
            self.log.report(ReportKind.PROTOCOL, "SPI", detail, time_ns)
        if words < len(OUTPUTS):
            self.log.report(ReportKind.PROTOCOL, "SPI", f"burst ended after {words} outputs", time_ns)
        core = self._core
        if core.unread == ALL_UNREAD and words == len(OUTPUTS) and not (core.diagnosis or core.overrides):
            core.unread = 0
            answers = core.sampler.words
        else:
            answers = b"".join(core.output(k).to_bytes(2, "big") for k in range(words))
        self._answer = answers[-2:]
        return answers

    # -- timing ------------------------------------------------------------------------------------

    def _check_times(self, words: int, burst: bool, start_ns: int, end_ns: int) -> bool:
        """Report what breaks a rule; returns whether a transaction may last so long."""
        slow = is_slow(self._core.registers.values)
        if start_ns - self._ended_ns < (SLOW_STALL_NS if slow else STALL_NS):
            self._late("pause between words too short: undefined, served", start_ns)
        self._ended_ns = end_ns
        key = (words, end_ns - start_ns, burst, slow)
        if key in self._vetted:
            return True
        allowed = self._within_limits(*key, start_ns)
        if allowed:
            self._vetted.add(key)
        return allowed

    def _within_limits(self, words: int, duration_ns: int, burst: bool, slow: bool, start_ns: int) -> bool:
        limit = FASTEST_BURST_HZ if burst else FASTEST_HZ
        if slow:
            limit = FASTEST_SLOW_HZ
        fast = self._frequency_hz > limit
        clock = self._frequency_hz or limit
        stall_ns = SECOND // clock if burst else SLOW_STALL_NS if slow else STALL_NS
        clocked_ns = 16 * words * SECOND // clock
        short = duration_ns + 1 < clocked_ns + (words - 1) * stall_ns
        if not self._frequency_hz and duration_ns + 1 < clocked_ns:
            fast, short = True, False
        if fast:
            self._late(f"clock faster than {limit // 1000} kHz: undefined, served", start_ns)
        elif short:
            self._late("pause between words too short: undefined, served", start_ns)
        return not fast and not short

    def _late(self, detail: str, time_ns: int) -> None:
        self.log.report(ReportKind.TIMING, "SPI", detail, time_ns)


def _volts(name: str, what: str, volts: float) -> float:
    if not 0.0 <= volts <= 7.0:
        raise ValueError(f"{name}: {what} = {volts}; it must lie in 0 … 7 V, e.g. 5.0")
    return float(volts)
