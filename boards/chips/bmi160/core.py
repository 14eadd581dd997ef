"""The registers behind the bus: what a read shows and what a write sets going.

Live registers are brought up to date once at the start of a burst, so that a burst shows one instant.
"""

from __future__ import annotations

from boards.chips.bmi160.acquisition import Acquisition
from boards.chips.bmi160.commands import Commands
from boards.chips.bmi160.errors import DROPPED_COMMAND, error_code
from boards.chips.bmi160.fifo_feed import (
    ACC_CONF_CHANGED,
    ACC_RANGE_CHANGED,
    GYR_CONF_CHANGED,
    GYR_RANGE_CHANGED,
)
from boards.chips.bmi160.power import Sensor
from boards.chips.bmi160.register_map import (
    ACC_CONF,
    ACC_DATA,
    ACC_RANGE,
    CMD,
    ERR_REG,
    FIFO_CONFIG_0,
    FIFO_CONFIG_1,
    FIFO_DATA,
    FIFO_DOWNS,
    FIFO_LENGTH,
    GYR_CONF,
    GYR_DATA,
    GYR_RANGE,
    INT_EN_0,
    INT_STATUS_0,
    OFFSET_0,
    OFFSET_6,
    PMU_STATUS,
    REGISTERS,
    SELF_TEST,
    SENSORTIME,
    STATUS,
    TEMPERATURE,
)
from boards.chips.bmi160.sensor_clock import COUNTER_MASK
from boards.chips.bmi160.settings import accel_stream, gyro_stream
from boards.chips.registers import AccessLog, RegisterFile, ReportKind
from boards.chips.world import ImuWorld

WRITE_GAP_NORMAL_NS, WRITE_GAP_SUSPEND_NS = 2_000, 450_000
"""Least time from a write to the next one (fact sheet section 1)."""


class Core:
    """Everything but bus faces and pins."""

    def __init__(self, world: ImuWorld, log: AccessLog, error_ppb: int) -> None:
        self.log = log
        self.registers = RegisterFile(REGISTERS, log)
        self.data = Acquisition(world, self.registers.values)
        self.commands = Commands(self.registers.values, self.data, log, self._mode_changed)
        self._error_ppb = error_ppb
        self._now = self._end = 0
        self._touched: set[Sensor] = set()
        """Sensors whose data registers the read at work touches."""
        self._install_hooks()
        self.restart(0)

    def restart(self, start_ns: int) -> None:
        """Registers, clock and everything else as after power-up; the sensor clock starts at `start_ns`."""
        self.registers.reset()
        self.commands.restart(start_ns)
        self.data.restart(start_ns, self._error_ppb)
        self._write_end: int | None = None
        self._error_code = 0
        self._gyro = gyro_stream(self.registers.values[GYR_CONF])
        self._accel = accel_stream(self.registers.values[ACC_CONF])

    def look_anew(self, time_ns: int, error_ppb: int | None) -> None:
        """Sample anew from now on, with another error of the oscillator if one is given."""
        self.advance(time_ns)
        if error_ppb is not None:
            self._error_ppb = error_ppb
        self.data.look_anew(time_ns, error_ppb)

    def _install_hooks(self) -> None:
        written, read = self.registers.after_write, self.registers.after_read
        written[ACC_CONF] = lambda _old, new: self._rate_changed(ACC_CONF_CHANGED, accel_conf=new)
        written[GYR_CONF] = lambda _old, new: self._rate_changed(GYR_CONF_CHANGED, gyro_conf=new)
        written[ACC_RANGE] = lambda old, new: self._converted(ACC_RANGE_CHANGED if old != new else 0)
        written[GYR_RANGE] = lambda old, new: self._converted(GYR_RANGE_CHANGED if old != new else 0)
        for address in range(OFFSET_0, OFFSET_6 + 1):
            written[address] = lambda _old, _new: self._converted(0)
        written[SELF_TEST] = self._self_test
        written[FIFO_DOWNS] = self._fifo_downs_changed
        written[FIFO_CONFIG_0] = lambda _old, _new: self.data.fifo_changed(self._now)
        written[FIFO_CONFIG_1] = self._fifo_config_changed
        for address in range(INT_EN_0, INT_EN_0 + 3):
            written[address] = lambda _old, _new: self.data.enables_changed(self._now)
        written[CMD] = lambda _old, new: self.commands.execute(new, self._now, self._end)
        for address in range(GYR_DATA, GYR_DATA + 6):
            read[address] = lambda: self._touched.add(Sensor.GYRO)
        for address in range(ACC_DATA, ACC_DATA + 6):
            read[address] = lambda: self._touched.add(Sensor.ACCEL)
        read[ERR_REG] = self._errors_read
        for byte in range(2):
            read[INT_STATUS_0 + byte] = lambda byte=byte: self.data.interrupts.status_read(byte)  # type: ignore[misc]

    def advance(self, time_ns: int) -> None:
        """Settle everything that became due and all samples up to `time_ns`."""
        self.commands.settle(time_ns)
        self.data.observe(time_ns)

    # -- bus access --------------------------------------------------------------------------------

    def read(self, first: int, count: int, time_ns: int) -> bytes:
        """A burst of `count` bytes from register `first` on, as of `time_ns`; FIFO_DATA stays put."""
        self.advance(time_ns)
        self._now = time_ns
        if first < FIFO_DATA:
            self._refresh(first, first + count, time_ns)
        data = bytearray()
        address = first
        while len(data) < count:
            if address == FIFO_DATA:
                data += self._read_fifo(count - len(data), time_ns)
            else:
                data.append(self.registers.read(address, time_ns, running_on=bool(data)))
                address = (address + 1) & 0x7F
        if self._touched:
            self.data.data_read(self._touched, time_ns)
            self._touched.clear()
        return bytes(data)

    def holds_still(self, first: int, count: int, time_ns: int) -> bool:
        """Whether a read touches only identity, errors, power and set-up, or only the temperature while
        nobody looks at every sample, and no command is under way: then neither samples nor interrupts need to
        be worked off for it (a health check reads just these)."""
        if self.commands.next_due is not None:
            return False
        end = first + count
        if first == TEMPERATURE and end <= TEMPERATURE + 2:
            return not self.data.looks_at_samples
        return end <= GYR_DATA or (first >= ACC_CONF and end <= 0x80)

    def read_still(self, first: int, count: int, time_ns: int) -> bytes:
        """A burst that `holds_still`."""
        if first < GYR_DATA:
            self._refresh_identity()
        elif first == TEMPERATURE:
            self._refresh_temperature(time_ns)
        registers = self.registers
        if registers.plain(first, first + count):
            return bytes(registers.values[first : first + count])
        read = registers.read
        return bytes(
            [read((first + offset) & 0x7F, time_ns, running_on=offset > 0) for offset in range(count)]
        )

    def _refresh_identity(self) -> None:
        values = self.registers.values
        values[ERR_REG] = self._error_code << 1 | (DROPPED_COMMAND if self.commands.dropped else 0)
        values[PMU_STATUS] = self.data.power.status()

    def _refresh_temperature(self, time_ns: int) -> None:
        celsius = self.data.temperature(time_ns).to_bytes(2, "little")
        self.registers.values[TEMPERATURE : TEMPERATURE + 2] = celsius

    def _read_fifo(self, count: int, time_ns: int) -> bytes:
        counter = (self.data.clock.tick(time_ns) & COUNTER_MASK).to_bytes(3, "little")
        data = self.data.fifo.read(count, counter if self.data.feed.time_enabled else None)
        self.data.fifo_changed(time_ns)
        return data

    def write(self, first: int, values: bytes, time_ns: int, end_ns: int) -> None:
        """A burst of writes from register `first` on that takes the wire from `time_ns` to `end_ns`.

        Set-ups take effect at once; what takes its time counts from the end.
        """
        self.advance(time_ns)
        self._now = time_ns
        self._end = end_ns
        self._check_gap(time_ns)
        for offset, value in enumerate(values):
            if offset and not self.data.power.any_normal:
                detail = "burst write without a sensor in normal mode; only its first byte was taken"
                self.log.report(ReportKind.PROTOCOL, f"0x{first:02X}", detail, time_ns)
                break
            self.registers.write((first + offset) & 0x7F, value, time_ns)
        self._write_end = end_ns
        self._note_error()

    def _check_gap(self, time_ns: int) -> None:
        gap = WRITE_GAP_NORMAL_NS if self.data.power.any_normal else WRITE_GAP_SUSPEND_NS
        if self._write_end is not None and time_ns - self._write_end < gap:
            detail = f"writes must be {gap} ns apart in this power mode"
            self.log.report(ReportKind.TIMING, "any", detail, time_ns)

    def _refresh(self, first: int, end: int, time_ns: int) -> None:
        """Bring the registers in [first, end) that live to their values at `time_ns`."""
        values, data = self.registers.values, self.data
        tick = data.clock.tick(time_ns)
        if first <= PMU_STATUS:
            self._refresh_identity()
        if first < SENSORTIME and end > GYR_DATA:
            values[GYR_DATA : GYR_DATA + 12] = data.sampler.registers(tick)
        if first < STATUS and end > SENSORTIME:
            values[SENSORTIME : SENSORTIME + 3] = (tick & COUNTER_MASK).to_bytes(3, "little")
        if first <= STATUS < end:
            power_up = self.registers.registers[STATUS].reset
            values[STATUS] = power_up | self.commands.status() | data.data_ready_bits(time_ns)
        if first < TEMPERATURE and end > INT_STATUS_0:
            values[INT_STATUS_0 : INT_STATUS_0 + 4] = bytes(data.interrupts.status(time_ns))
        if first < FIFO_LENGTH and end > TEMPERATURE:
            self._refresh_temperature(time_ns)
        if end > FIFO_LENGTH:
            values[FIFO_LENGTH : FIFO_LENGTH + 2] = len(data.fifo).to_bytes(2, "little")

    # -- errors ------------------------------------------------------------------------------------

    def _note_error(self) -> None:
        """Keep the first error code until ERR_REG is read."""
        if not self._error_code:
            self._error_code = error_code(self.registers.values, self.data)

    def _errors_read(self) -> None:
        self._error_code = 0
        self.commands.dropped = False

    # -- configuration -----------------------------------------------------------------------------

    def _configure(self, time_ns: int) -> None:
        assert self._gyro is not None
        assert self._accel is not None
        self.data.configure(time_ns, self._gyro, self._accel)

    def _mode_changed(self, time_ns: int) -> None:
        self._configure(time_ns)
        self._note_error()

    def _rate_changed(
        self, change: int, *, accel_conf: int | None = None, gyro_conf: int | None = None
    ) -> None:
        """A set-up without meaning leaves the sensor as it was (and sets an error code)."""
        before = (self._accel, self._gyro)
        if accel_conf is not None:
            self._accel = accel_stream(accel_conf) or self._accel
        if gyro_conf is not None:
            self._gyro = gyro_stream(gyro_conf) or self._gyro
        if (self._accel, self._gyro) != before:
            self._fifo_input_changed(change)
            self._configure(self._now)
            self.data.motion.restart()

    def _converted(self, change: int) -> None:
        if change:
            self._fifo_input_changed(change)
        self.data.convert(self._now)

    def _fifo_input_changed(self, change: int) -> None:
        """Tell the reader of the FIFO by a frame, or flush when there are no headers to tell with."""
        stored = 0x40 if change in (ACC_CONF_CHANGED, ACC_RANGE_CHANGED) else 0x80
        if not self.registers.values[FIFO_CONFIG_1] & stored:
            return
        if self.data.fifo.header_mode:
            self.data.feed.changed |= change
        else:
            self.data.flush_fifo(self._now)

    def _fifo_downs_changed(self, old: int, new: int) -> None:
        if (old ^ new) & 0xF0:
            self._fifo_input_changed(ACC_CONF_CHANGED)
        if (old ^ new) & 0x0F:
            self._fifo_input_changed(GYR_CONF_CHANGED)
        self._configure(self._now)

    def _fifo_config_changed(self, old: int, new: int) -> None:
        layout = 0x10 if old & new & 0x10 else 0xF0  # what a frame looks like: with headers, it tells itself
        self._configure(self._now)
        if (old ^ new) & layout:
            self.data.flush_fifo(self._now)

    def _self_test(self, old: int, new: int) -> None:
        self.data.convert(self._now)
        if new & 0x10 and not old & 0x10:
            self.commands.start_gyro_self_test(self._now, self._end)
