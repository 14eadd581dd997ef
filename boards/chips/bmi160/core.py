"""The chip behind its bus: registers, commands, errors and what becomes due in time.

A command takes its time (fact sheet sections 2 and 5); while it runs, a further one is dropped and sets
drop_cmd_err. What the command is for shows when its time has passed. Nothing is scheduled for that: every
access first settles what became due until then, in order.
"""

from __future__ import annotations

from collections.abc import Callable

from boards.chips.bmi160.acquisition import Acquisition
from boards.chips.bmi160.calibration import FOC_NS, OffsetMeasurement
from boards.chips.bmi160.errors import DROPPED_COMMAND, error_code
from boards.chips.bmi160.fifo_feed import (
    ACC_CONF_CHANGED,
    ACC_RANGE_CHANGED,
    GYR_CONF_CHANGED,
    GYR_RANGE_CHANGED,
)
from boards.chips.bmi160.power import MODE_COMMANDS, NORMAL, Sensor
from boards.chips.bmi160.register_map import (
    ACC_CONF,
    ACC_DATA,
    ACC_RANGE,
    CMD,
    CONF,
    ERR_REG,
    FIFO_CONFIG_0,
    FIFO_CONFIG_1,
    FIFO_DATA,
    FIFO_DOWNS,
    FIFO_LENGTH,
    FOC_CONF,
    FOC_RDY,
    GYR_CONF,
    GYR_DATA,
    GYR_RANGE,
    GYR_SELF_TEST_OK,
    INT_EN_0,
    INT_STATUS_0,
    NVM_RDY,
    NVM_REGISTERS,
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

RESET_NS = 1_000_000
"""Soft reset until the chip answers again."""

NVM_PROGRAM_NS = 20_000_000
GYRO_SELF_TEST_NS = 20_000_000

WRITE_GAP_NORMAL_NS, WRITE_GAP_SUSPEND_NS = 2_000, 450_000
"""Least time from a write to the next one (fact sheet section 1)."""

_START_FOC, _PROGRAM_NVM, _FLUSH, _RESET_INTERRUPTS, _CLEAR_STEPS, SOFT_RESET = (
    0x03,
    0xA0,
    0xB0,
    0xB1,
    0xB2,
    0xB6,
)

Action = Callable[[int], None]


class Core:
    """Everything but bus faces and pins."""

    def __init__(self, world: ImuWorld, log: AccessLog, error_ppb: int) -> None:
        self.log = log
        self.error_ppb = error_ppb
        self.registers = RegisterFile(REGISTERS, log)
        self.data = Acquisition(world, self.registers.values)
        self.nvm = bytearray(len(NVM_REGISTERS))
        """What NV_CONF and OFFSET are loaded with at a reset; survives power cuts."""
        self.reset_requested = False
        self._now = self._end = 0
        self._touched: set[Sensor] = set()
        """Sensors whose data registers the read at work touches."""
        self._install_hooks()

    def restart(self, start_ns: int) -> None:
        """Registers, clock and everything else as after power-up; the sensor clock starts at `start_ns`."""
        self.registers.reset()
        self.registers.values[NVM_REGISTERS.start : NVM_REGISTERS.stop] = self.nvm
        self.data.restart(start_ns, self.error_ppb)
        self.reset_requested = False
        self._due: list[tuple[int, Action]] = []
        self._command_end = start_ns
        self._write_end: int | None = None
        self._errors = 0
        self._status = self.registers.registers[STATUS].reset
        self._programming = False
        self._gyro = gyro_stream(self.registers.values[GYR_CONF])
        self._accel = accel_stream(self.registers.values[ACC_CONF])

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
        written[CMD] = lambda _old, new: self._command(new)
        for address in range(GYR_DATA, GYR_DATA + 6):
            read[address] = lambda: self._touched.add(Sensor.GYRO)
        for address in range(ACC_DATA, ACC_DATA + 6):
            read[address] = lambda: self._touched.add(Sensor.ACCEL)
        read[ERR_REG] = self._errors_read
        for byte in range(2):
            read[INT_STATUS_0 + byte] = lambda byte=byte: self.data.interrupts.status_read(byte)  # type: ignore[misc]

    # -- time --------------------------------------------------------------------------------------

    def advance(self, time_ns: int) -> None:
        """Settle everything that became due and all samples up to `time_ns`."""
        while self._due and self._due[0][0] <= time_ns:
            due_ns, action = self._due.pop(0)
            self.data.observe(due_ns)
            action(due_ns)
        self.data.observe(time_ns)

    @property
    def next_due(self) -> int | None:
        """When the next command or test completes (ns)."""
        return self._due[0][0] if self._due else None

    def _later(self, delay_ns: int, action: Action) -> None:
        self._due.append((self._end + delay_ns, action))
        self._due.sort(key=lambda entry: entry[0])

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
        while self._touched:
            self.data.data_read(self._touched.pop(), time_ns)
        return bytes(data)

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
            values[ERR_REG] = self._errors
            values[PMU_STATUS] = data.power.status()
        if first < SENSORTIME and end > GYR_DATA:
            values[GYR_DATA : GYR_DATA + 12] = data.sampler.registers(tick)
        if first < STATUS and end > SENSORTIME:
            values[SENSORTIME : SENSORTIME + 3] = (tick & COUNTER_MASK).to_bytes(3, "little")
        if first <= STATUS < end:
            ready = NVM_RDY if values[CONF] & 0x02 and not self._programming else 0
            values[STATUS] = self._status | ready | data.data_ready_bits(time_ns)
        if first < TEMPERATURE and end > INT_STATUS_0:
            values[INT_STATUS_0 : INT_STATUS_0 + 4] = bytes(data.interrupts.status(time_ns))
        if first < FIFO_LENGTH and end > TEMPERATURE:
            values[TEMPERATURE : TEMPERATURE + 2] = data.temperature(time_ns).to_bytes(2, "little")
        if end > FIFO_LENGTH:
            values[FIFO_LENGTH : FIFO_LENGTH + 2] = len(data.fifo).to_bytes(2, "little")

    # -- errors ------------------------------------------------------------------------------------

    def _note_error(self) -> None:
        """Keep the first error code until ERR_REG is read."""
        if not self._errors & 0x1E:
            self._errors |= error_code(self.registers.values, self.data) << 1

    def _errors_read(self) -> None:
        self._errors = 0

    # -- configuration -----------------------------------------------------------------------------

    def _configure(self, time_ns: int) -> None:
        assert self._gyro is not None
        assert self._accel is not None
        self.data.configure(time_ns, self._gyro, self._accel)

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
            self._flush()

    def _flush(self) -> None:
        self.data.fifo.flush()
        self.data.fifo_changed(self._now)

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
            self._flush()

    def _self_test(self, old: int, new: int) -> None:
        self.data.convert(self._now)
        if new & 0x10 and not old & 0x10:
            self._status &= ~GYR_SELF_TEST_OK
            self._later(GYRO_SELF_TEST_NS, self._gyro_self_test_done)

    def _gyro_self_test_done(self, _time_ns: int) -> None:
        if self.data.power.gyro == NORMAL:
            self._status |= GYR_SELF_TEST_OK

    # -- commands ----------------------------------------------------------------------------------

    def _command(self, code: int) -> None:
        if code == SOFT_RESET:
            self.reset_requested = True
        elif self._now < self._command_end:
            self._errors |= DROPPED_COMMAND
            self.log.report(ReportKind.DROPPED, "CMD", f"0x{code:02X} while another runs", self._now)
        elif code in MODE_COMMANDS:
            self._change_mode(*MODE_COMMANDS[code])
        elif code == _START_FOC:
            self._start_foc()
        elif code == _PROGRAM_NVM:
            self._program_nvm()
        elif code == _FLUSH:
            self._flush()
        elif code == _RESET_INTERRUPTS:
            self.data.interrupts.reset()
        elif code != _CLEAR_STEPS:
            self.log.report(ReportKind.RESERVED_VALUE, "CMD", f"0x{code:02X} ignored", self._now)

    def _run(self, duration_ns: int, action: Action) -> None:
        """Do `action` when the command at work is complete."""
        if not duration_ns:
            action(self._now)
            return
        self._command_end = self._end + duration_ns
        self._later(duration_ns, action)

    def _change_mode(self, sensor: Sensor, mode: int) -> None:
        if sensor is Sensor.MAG and mode:
            self.log.report(
                ReportKind.NOT_MODELLED, "CMD", "secondary interface (magnetometer, OIS)", self._now
            )
        self._run(
            self.data.power.change_duration(sensor, mode), lambda time_ns: self._enter(sensor, mode, time_ns)
        )

    def _enter(self, sensor: Sensor, mode: int, time_ns: int) -> None:
        if self.data.power.modes[sensor] == mode:
            return
        self.data.power.modes[sensor] = mode
        if sensor is Sensor.ACCEL:
            self.data.motion.restart()
        if not self.data.fifo.header_mode:
            self.data.fifo.flush()
        self._configure(time_ns)
        self._note_error()

    def _start_foc(self) -> None:
        power = self.data.power
        conf = self.registers.values[FOC_CONF]
        measurement = OffsetMeasurement(conf, accel=power.accel == NORMAL, gyro=power.gyro == NORMAL)
        if not measurement.complete(conf):
            detail = "FOC of a sensor that is not in normal mode was left out"
            self.log.report(ReportKind.PROTOCOL, "FOC_CONF", detail, self._now)
        if not measurement.runs:
            self._status |= FOC_RDY
            return
        self._status &= ~FOC_RDY
        self.data.measure(measurement)
        self._run(FOC_NS, self._foc_done)

    def _foc_done(self, time_ns: int) -> None:
        measurement = self.data.measurement
        assert measurement is not None
        measurement.write(self.registers.values)
        self.data.measure(None)
        self.data.convert(time_ns)
        self._status |= FOC_RDY

    def _program_nvm(self) -> None:
        if not self.registers.values[CONF] & 0x02:
            self.log.report(ReportKind.PROTOCOL, "CMD", "0xA0 without nvm_prog_en was ignored", self._now)
            return
        self._programming = True
        self._run(NVM_PROGRAM_NS, self._nvm_programmed)

    def _nvm_programmed(self, _time_ns: int) -> None:
        self.nvm[:] = self.registers.values[NVM_REGISTERS.start : NVM_REGISTERS.stop]
        self._programming = False
