"""The command register and what takes its time (fact sheet sections 2 and 5).

One command runs at a time; a further one meanwhile is dropped and sets drop_cmd_err, but for the soft
reset, which is always taken. What a command is for shows when its time has passed. Nothing is scheduled
for that: whoever looks at the chip first settles what became due until then, in order.
"""

from __future__ import annotations

from collections.abc import Callable

from boards.chips.bmi160.acquisition import Acquisition
from boards.chips.bmi160.calibration import FOC_NS, OffsetMeasurement
from boards.chips.bmi160.power import MODE_COMMANDS, NORMAL, Sensor
from boards.chips.bmi160.register_map import CONF, FOC_CONF, FOC_RDY, GYR_SELF_TEST_OK, NVM_RDY, NVM_REGISTERS
from boards.chips.registers import AccessLog, ReportKind

NVM_PROGRAM_NS = 20_000_000
GYRO_SELF_TEST_NS = 20_000_000

_START_FOC, _PROGRAM_NVM, _FLUSH, _RESET_INTERRUPTS, _CLEAR_STEPS, _SOFT_RESET = (
    0x03,
    0xA0,
    0xB0,
    0xB1,
    0xB2,
    0xB6,
)

_NVM = slice(NVM_REGISTERS.start, NVM_REGISTERS.stop)

Action = Callable[[int], None]


class Commands:
    """Commands at work and their results. `mode_changed(time_ns)` hears when a sensor is in a new mode."""

    def __init__(
        self, registers: bytearray, data: Acquisition, log: AccessLog, mode_changed: Callable[[int], None]
    ) -> None:
        self.nvm = bytearray(len(NVM_REGISTERS))
        """What NV_CONF and OFFSET are loaded with at a reset; survives power cuts."""
        self._registers = registers
        self._data = data
        self._log = log
        self._mode_changed = mode_changed
        self.restart(0)

    def restart(self, time_ns: int) -> None:
        """As after power-up: nothing runs, registers loaded from the non-volatile memory."""
        self._registers[_NVM] = self.nvm
        self.reset_requested = False
        self.dropped = False
        """drop_cmd_err."""
        self._due: list[tuple[int, Action]] = []
        self._busy_until = time_ns
        self._now = self._end = time_ns
        self._results = 0
        self._programming = False

    # -- time --------------------------------------------------------------------------------------

    @property
    def next_due(self) -> int | None:
        """When the next command or test completes (ns)."""
        return self._due[0][0] if self._due else None

    def settle(self, time_ns: int) -> None:
        """Complete what became due up to `time_ns`, with the samples before it worked off."""
        while self._due and self._due[0][0] <= time_ns:
            due_ns, action = self._due.pop(0)
            self._data.observe(due_ns)
            action(due_ns)

    def _later(self, delay_ns: int, action: Action) -> None:
        self._due.append((self._end + delay_ns, action))
        self._due.sort(key=lambda entry: entry[0])

    def _run(self, duration_ns: int, action: Action) -> None:
        """Do `action` when the command at work is complete."""
        if duration_ns:
            self._busy_until = self._end + duration_ns
            self._later(duration_ns, action)
        else:
            action(self._now)

    def status(self) -> int:
        """foc_rdy, nvm_rdy and gyr_self_test_ok of STATUS."""
        unlocked = self._registers[CONF] & 0x02
        return self._results | (NVM_RDY if unlocked and not self._programming else 0)

    # -- execution ---------------------------------------------------------------------------------

    def execute(self, code: int, time_ns: int, end_ns: int) -> None:
        """A write to CMD on the wire from `time_ns` to `end_ns`; durations count from its end."""
        self._now, self._end = time_ns, end_ns
        if code == _SOFT_RESET:
            self.reset_requested = True
        elif time_ns < self._busy_until:
            self.dropped = True
            self._log.report(ReportKind.DROPPED, "CMD", f"0x{code:02X} while another runs", time_ns)
        elif code in MODE_COMMANDS:
            self._change_mode(*MODE_COMMANDS[code])
        elif code == _START_FOC:
            self._start_foc()
        elif code == _PROGRAM_NVM:
            self._program_nvm()
        elif code == _FLUSH:
            self._data.flush_fifo(time_ns)
        elif code == _RESET_INTERRUPTS:
            self._data.interrupts.reset()
        elif code != _CLEAR_STEPS:
            self._log.report(ReportKind.RESERVED_VALUE, "CMD", f"0x{code:02X} ignored", time_ns)

    def start_gyro_self_test(self, time_ns: int, end_ns: int) -> None:
        """The bit in SELF_TEST was set."""
        self._now, self._end = time_ns, end_ns
        self._results &= ~GYR_SELF_TEST_OK
        self._later(GYRO_SELF_TEST_NS, self._gyro_self_test_done)

    def _gyro_self_test_done(self, _time_ns: int) -> None:
        if self._data.power.gyro == NORMAL:
            self._results |= GYR_SELF_TEST_OK

    def _change_mode(self, sensor: Sensor, mode: int) -> None:
        if sensor is Sensor.MAG and mode:
            reason = "secondary interface (magnetometer, OIS)"
            self._log.report(ReportKind.NOT_MODELLED, "CMD", reason, self._now)
        duration = self._data.power.change_duration(sensor, mode)
        self._run(duration, lambda time_ns: self._enter(sensor, mode, time_ns))

    def _enter(self, sensor: Sensor, mode: int, time_ns: int) -> None:
        data = self._data
        if data.power.modes[sensor] == mode:
            return
        data.power.modes[sensor] = mode
        if sensor is Sensor.ACCEL:
            data.motion.restart()
        if not data.fifo.header_mode:
            data.flush_fifo(time_ns)
        self._mode_changed(time_ns)

    def _start_foc(self) -> None:
        power = self._data.power
        conf = self._registers[FOC_CONF]
        measurement = OffsetMeasurement(conf, accel=power.accel == NORMAL, gyro=power.gyro == NORMAL)
        if not measurement.complete(conf):
            detail = "FOC of a sensor that is not in normal mode was left out"
            self._log.report(ReportKind.PROTOCOL, "FOC_CONF", detail, self._now)
        if not measurement.runs:
            self._results |= FOC_RDY
            return
        self._results &= ~FOC_RDY
        self._data.measure(measurement)
        self._run(FOC_NS, self._foc_done)

    def _foc_done(self, time_ns: int) -> None:
        measurement = self._data.measurement
        assert measurement is not None
        measurement.write(self._registers)
        self._data.measure(None)
        self._data.convert(time_ns)
        self._results |= FOC_RDY

    def _program_nvm(self) -> None:
        if not self._registers[CONF] & 0x02:
            detail = "0xA0 without nvm_prog_en was ignored"
            self._log.report(ReportKind.PROTOCOL, "CMD", detail, self._now)
            return
        self._programming = True
        self._run(NVM_PROGRAM_NS, self._nvm_programmed)

    def _nvm_programmed(self, _time_ns: int) -> None:
        self.nvm[:] = self._registers[_NVM]
        self._programming = False
