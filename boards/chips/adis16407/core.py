"""The registers behind the bus: samples, flags, commands and their times, sleep, start-up.

Nothing runs while nobody looks. `advance` brings the chip up to a time: commands that end on the way and
samples, in the order in which they happen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from boards.chips.adis16407 import register_map as reg
from boards.chips.adis16407.flash import ENDURANCE, Flash
from boards.chips.adis16407.sampler import FAR, SUPPLY_LIMITS_V, Sampler
from boards.chips.adis16407.settings import (
    ALARM_COLUMNS,
    GYRO_RANGES_DPS,
    START_UP_NS,
    WAKE_UP_NS,
    conversion,
    sample_ticks,
    word,
)
from boards.chips.registers import Access, AccessLog, RegisterFile, ReportKind
from boards.chips.world import TenDofWorld

MS = 1_000_000
SAVE_NS, RESTORE_NS, NULL_NS, PRECISION_NULL_NS = 75 * MS, 75 * MS, 50 * MS, 30_000 * MS
SELF_TEST_NS, MEMORY_TEST_NS = 12 * MS, 20 * MS
"""Choices: the sheet has no figures for the two tests."""
SLEEP_UNIT_NS = 500 * MS

RESET, PRECISION_NULL, SAVE, LATCH_DAC, RESTORE, NULL = 0x80, 0x10, 0x08, 0x04, 0x02, 0x01
MEMORY_TEST, SELF_TEST, POWER_DOWN = 0x08, 0x04, 0x01
"""In the high bytes of MSC_CTRL and SLP_CTRL."""

BARO_FAIL, CHECKSUM_FAIL, SELF_TEST_FAIL, SPI_ERROR, UPDATE_FAIL = 1 << 7, 1 << 6, 1 << 5, 1 << 3, 1 << 2
DEFECTS = {
    "accel_z": 1 << 15, "accel_y": 1 << 14, "accel_x": 1 << 13,
    "gyro_z": 1 << 12, "gyro_y": 1 << 11, "gyro_x": 1 << 10, "barometer": BARO_FAIL,
}  # fmt: skip
"""What can be broken, and the flag that the self-test then sets."""

ALL_UNREAD = (1 << len(reg.OUTPUTS)) - 1
NEW_DATA, ERROR_ALARM = 0x8000, 0x4000


class Core:
    """Everything but bus rules and pins."""

    def __init__(
        self, world: TenDofWorld, log: AccessLog, error_ppb: int, flash: Flash, identity: tuple[int, int, int]
    ) -> None:
        self.registers = RegisterFile(reg.REGISTERS, log)
        self.sampler = Sampler(world, error_ppb)
        self.flash = flash
        self.defects: frozenset[str] = frozenset()
        self.diagnosis = 0
        """DIAG_STAT."""
        self.unread = 0
        """One bit for each output in burst order."""
        self.answers_ns = FAR
        """From when on it is awake."""
        self.wakes_on_select = False
        self.dac_code = 0
        """At the output, latched."""
        self.lasting_flags = 0
        """DIAG_STAT flags that come back with every sample: a fault."""
        self._log = log
        self._identity = identity
        self.done_ns = FAR
        """When the command at work ends."""
        self.overrides: dict[int, int] = {}
        """Registers that are made to read as something else: a fault."""
        self.overridden_reads = 0
        self._action: Callable[[int], None] = _nothing
        self._updating = False
        """The command at work writes the flash."""

    # -- time --------------------------------------------------------------------------------------

    @property
    def next_ns(self) -> int:
        """When the next thing happens by itself."""
        return min(self.sampler.next_ns, self.done_ns)

    def advance(self, time_ns: int) -> None:
        """Bring everything up to a time."""
        while self.done_ns <= time_ns:
            done_ns, action = self.done_ns, self._action
            self.sample(done_ns)
            self.done_ns, self._action, self._updating = FAR, _nothing, False
            action(done_ns)
        self.sample(time_ns)

    def external(self, time_ns: int) -> None:
        """An edge of the external clock."""
        self.advance(time_ns)
        if self.answers_ns <= time_ns:
            flags = self.sampler.external(time_ns)
            self.diagnosis |= flags | self.lasting_flags
            self.unread = self.unread if self.sampler.halted else ALL_UNREAD

    def sample(self, time_ns: int) -> None:
        """Bring the samples up to a time at which no command has ended."""
        sampler = self.sampler
        if sampler.next_ns <= time_ns:
            if not sampler.step(time_ns):
                self.diagnosis |= sampler.advance(time_ns)
            if self.lasting_flags:
                self.diagnosis |= self.lasting_flags
            self.unread = ALL_UNREAD

    # -- supply and reset --------------------------------------------------------------------------

    def start_up(self, time_ns: int) -> None:
        """Supply, reset pin or reset command: settings from the flash, answers after 210 ms."""
        self._abandon()
        self.sampler.forget()
        self.registers.reset()
        values = self.registers.values
        self.flash.load(values)
        for address, number in zip((reg.LOT_ID1, reg.LOT_ID2, reg.SERIAL_NUM), self._identity, strict=True):
            values[address : address + 2] = number.to_bytes(2, "little")
        self.diagnosis = CHECKSUM_FAIL if self.flash.corrupt else 0
        self.unread = 0
        self.dac_code = 0
        self._begin_sampling(time_ns + START_UP_NS)

    def shut_down(self) -> None:
        """No supply, or held in reset."""
        self._abandon()
        self.sampler.forget()
        self.registers.reset()
        self.diagnosis = 0
        self.answers_ns = FAR
        self.wakes_on_select = False

    def _abandon(self) -> None:
        if self._updating:
            self.flash.break_off()
        self.done_ns, self._action, self._updating = FAR, _nothing, False
        self.sampler.sum_up(False)

    def _begin_sampling(self, first_ns: int) -> None:
        values = self.registers.values
        self.answers_ns = first_ns
        self.wakes_on_select = False
        self.sampler.convert(conversion(values))
        self.sampler.start(first_ns, sample_ticks(values))

    def selected(self, time_ns: int) -> None:
        """Chip select falls: the end of a sleep without end."""
        self._begin_sampling(time_ns + WAKE_UP_NS)

    # -- surroundings ------------------------------------------------------------------------------

    def set_analog(self, time_ns: int, supply_v: float | None = None, adc_v: float | None = None) -> None:
        """Another supply or input voltage from the next sample on."""
        self.advance(time_ns)
        sampler = self.sampler
        sampler.supply_v = sampler.supply_v if supply_v is None else supply_v
        sampler.adc_v = sampler.adc_v if adc_v is None else adc_v
        sampler.refresh()

    def look_anew(self, time_ns: int, error_ppb: int | None) -> None:
        """Ask for the samples to come again, with another error of the sample clock if one is given."""
        self.advance(time_ns)
        self.sampler.look_anew(error_ppb)

    def halt(self, on: bool, time_ns: int) -> None:
        """The sample clock stands still, or goes on."""
        self.advance(time_ns)
        self.sampler.halt(on, time_ns)

    def trouble(self, flags: int, time_ns: int) -> None:
        """DIAG_STAT flags that come back with every sample from now on."""
        self.advance(time_ns)
        self.lasting_flags = flags

    # -- reads -------------------------------------------------------------------------------------

    def read(self, address: int, time_ns: int) -> int:
        """A word; the address may be that of either byte."""
        address &= 0x7E
        register = self.registers.registers.get(address)
        if register is None:
            self._log.report(ReportKind.UNDOCUMENTED_ADDRESS, f"0x{address:02X}", "read", time_ns)
            return 0
        if reg.SUPPLY_OUT <= address <= reg.AUX_ADC:
            return self.output(address // 2 - 1)
        if address in self.overrides:
            self.overridden_reads += 1
            return self.overrides[address]
        if address == reg.DIAG_STAT:
            diagnosis, self.diagnosis = self.diagnosis, 0
            return diagnosis
        if address == reg.FLASH_CNT:
            return self.flash.count
        if register.access is Access.WRITE:
            self._log.report(ReportKind.WRITE_ONLY, register.name, "read", time_ns)
            return 0
        return word(self.registers.values, address)

    def override(self, address: int, value: int | None) -> None:
        """Have a register read as `value`; None: as itself."""
        if value is None:
            self.overrides.pop(address, None)
        else:
            self.overrides[address] = value

    def output(self, index: int) -> int:
        """An output register in burst order, with ND and EA; it counts as read."""
        if 2 * index + 2 in self.overrides:
            self.overridden_reads += 1
            return self.overrides[2 * index + 2]
        value = int.from_bytes(self.sampler.words[2 * index : 2 * index + 2], "big") & ~NEW_DATA
        bit = 1 << index
        if self.unread & bit:
            self.unread &= ~bit
            value |= NEW_DATA
        return value | ERROR_ALARM if self.diagnosis else value

    # -- writes ------------------------------------------------------------------------------------

    def write(self, address: int, value: int, time_ns: int) -> None:
        """One byte."""
        values = self.registers.values
        self.registers.write(address, value, time_ns)
        if address in reg.SIGN_BYTES:
            values[address] &= reg.SIGN_BYTES[address]
        if address == reg.GLOB_CMD:
            command, values[address] = values[address], 0
            self._command(command, time_ns)
        elif address == reg.MSC_CTRL + 1:
            self._tests(values[address] & (MEMORY_TEST | SELF_TEST), time_ns)
        elif address == reg.SMPL_PRD:
            period = sample_ticks(values)
            self.sampler.start(time_ns + self.sampler.period_ns(period), period)
        elif address in (reg.SLP_CTRL, reg.SLP_CTRL + 1):
            self._sleep(time_ns)
        elif address == reg.SENS_AVG + 1 and values[address] not in GYRO_RANGES_DPS:
            self._reserved("SENS_AVG", f"no gyro range has the code {values[address]}: ±300", time_ns)
        elif address == reg.ALM_CTRL + 1:
            for source in (values[address] & 15, values[address] >> 4):
                if source and source not in ALARM_COLUMNS:
                    self._reserved("ALM_CTRL", f"no output has the code {source}: off", time_ns)
        self.sampler.convert(conversion(values))

    def _reserved(self, register: str, detail: str, time_ns: int) -> None:
        self._log.report(ReportKind.RESERVED_VALUE, register, detail, time_ns)

    def _sleep(self, time_ns: int) -> None:
        values = self.registers.values
        units, power_down = values[reg.SLP_CTRL], values[reg.SLP_CTRL + 1] & POWER_DOWN
        values[reg.SLP_CTRL] = values[reg.SLP_CTRL + 1] = 0
        if not units and not power_down:
            return
        if self.done_ns != FAR:
            self._log.report(ReportKind.DROPPED, "SLP_CTRL", "sleep while a command is at work", time_ns)
        elif power_down:
            self.sampler.stop()
            self.answers_ns = FAR
            self.wakes_on_select = True
        else:
            self.sampler.stop()
            self._begin_sampling(time_ns + units * SLEEP_UNIT_NS + WAKE_UP_NS)

    # -- commands ----------------------------------------------------------------------------------

    def _command(self, command: int, time_ns: int) -> None:
        if command & LATCH_DAC:
            self.dac_code = word(self.registers.values, reg.AUX_DAC) & 0xFFF
        if command & RESET:
            self.start_up(time_ns)
            return
        wanted = [bit for bit in (PRECISION_NULL, SAVE, RESTORE, NULL) if command & bit]
        if len(wanted) > 1:
            self._log.report(
                ReportKind.PROTOCOL, "GLOB_CMD", f"several commands at once: only 0x{wanted[0]:02X}", time_ns
            )
        if not wanted:
            return
        bit = wanted[0]
        duration, action = {
            PRECISION_NULL: (PRECISION_NULL_NS, self._null_by_mean),
            SAVE: (SAVE_NS, self._update),
            RESTORE: (RESTORE_NS, self._restore),
            NULL: (NULL_NS, self._null),
        }[bit]
        if self._start(duration, action, f"command 0x{bit:02X}", time_ns):
            self._updating = bit != PRECISION_NULL
            if bit == PRECISION_NULL:
                self.sampler.sum_up(True)

    def _start(self, duration_ns: int, action: Callable[[int], None], what: str, time_ns: int) -> bool:
        if self.done_ns != FAR:
            self._log.report(ReportKind.DROPPED, "GLOB_CMD", f"{what} while another is at work", time_ns)
            return False
        self.done_ns, self._action = time_ns + duration_ns, action
        return True

    def _update(self, time_ns: int) -> None:
        """Write the flash, if the supply is good for it."""
        low, high = SUPPLY_LIMITS_V
        if not low <= self.sampler.supply_v <= high:
            self.diagnosis |= UPDATE_FAIL
            return
        self.flash.save(self.registers.values)
        if self.flash.count == ENDURANCE + 1:
            detail = f"more than {ENDURANCE} updates: beyond the flash's endurance"
            self._log.report(ReportKind.PROTOCOL, "FLASH_CNT", detail, time_ns)

    def _restore(self, time_ns: int) -> None:
        values = self.registers.values
        for address in reg.USER_CALIBRATION:
            values[address] = self.registers.registers[address].reset
        self.sampler.convert(conversion(values))
        self._update(time_ns)

    def _null(self, time_ns: int) -> None:
        self._null_out(self.sampler.newest_rates(), time_ns)

    def _null_by_mean(self, time_ns: int) -> None:
        sampler = self.sampler
        rates = (sampler.total / max(1, sampler.count)).tolist()
        sampler.sum_up(False)
        self._null_out(rates, time_ns)

    def _null_out(self, rates: Iterable[float], time_ns: int) -> None:
        """Offsets that bring these outputs (°/s) to zero, and into the flash with them."""
        values = self.registers.values
        offsets = self.sampler.conversion.gyro_offset_dps
        for axis, (rate, offset) in enumerate(zip(rates, offsets, strict=True)):
            counts = max(-4096, min(4095, round((offset - rate) / 0.0125)))
            address = reg.GYRO_OFF + 2 * axis
            values[address : address + 2] = (counts & 0x1FFF).to_bytes(2, "little")
        self.sampler.convert(conversion(values))
        self._update(time_ns)

    def _tests(self, wanted: int, time_ns: int) -> None:
        if not wanted:
            return
        duration = SELF_TEST_NS * bool(wanted & SELF_TEST) + MEMORY_TEST_NS * bool(wanted & MEMORY_TEST)
        if not self._start(duration, lambda _now: self._tested(wanted), "a test", time_ns):
            self.registers.values[reg.MSC_CTRL + 1] &= ~wanted

    def _tested(self, wanted: int) -> None:
        self.registers.values[reg.MSC_CTRL + 1] &= ~wanted
        if wanted & SELF_TEST and self.defects:
            self.diagnosis |= SELF_TEST_FAIL
            for part in sorted(self.defects):
                self.diagnosis |= DEFECTS[part]
        if wanted & MEMORY_TEST and self.flash.corrupt:
            self.diagnosis |= CHECKSUM_FAIL


def _nothing(_time_ns: int) -> None:
    pass
