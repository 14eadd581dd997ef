"""The registers behind the bus: modes, samples, flags, and what writes and reads set going.

Nothing runs while nobody looks. `advance` brings the chip up to a time: samples into the FIFO, detection,
trigger, auto-sleep, in the order in which they happen.
"""

from __future__ import annotations

from boards.chips.adxl345.detection import REGISTERS as DETECTION_REGISTERS
from boards.chips.adxl345.detection import UNDECIMATED, Detection
from boards.chips.adxl345.fifo import BYPASS, POP_NS, Fifo
from boards.chips.adxl345.register_map import (
    ACTIVITY,
    ASLEEP,
    AUTO_SLEEP,
    BW_RATE,
    DATA_FORMAT,
    DATA_READY,
    DETECTED,
    FIFO_CTL,
    INT_ENABLE,
    INT_MAP,
    LINK,
    LIVE,
    LOW_POWER,
    MEASURE,
    OFFSETS,
    OFSX,
    OVERRUN,
    POWER_CTL,
    REGISTERS,
    SELF_TEST,
    SLEEP,
    WATERMARK,
)
from boards.chips.adxl345.sampler import Plan, Response, Sampler
from boards.chips.adxl345.settings import (
    TICK_RATE_HZ,
    TURN_ON_NS,
    noise_bandwidth_hz,
    offset_g,
    rate_period,
    self_test_g,
    supply_effect,
    wakeup_period,
    word_format,
)
from boards.chips.oscillator import Oscillator
from boards.chips.registers import AccessLog, RegisterFile
from boards.chips.world import ImuWorld


class Core:
    """Everything but bus rules and pins."""

    def __init__(self, world: ImuWorld, log: AccessLog, error_ppb: int, supply_v: float) -> None:
        self.registers = RegisterFile(REGISTERS, log)
        self._world = world
        self._error_ppb = error_ppb
        self._gain, self._supply_bias = supply_effect(supply_v)
        self._self_test = self_test_g(supply_v)
        self.fifo = Fifo()
        self.detection = Detection(self.registers.values)
        self.tick = 0
        """The chip is up to date with this tick of the sampler's clock."""
        self._asleep = False
        """By auto-sleep."""
        self.trigger_ns: int | None = None
        """When the FIFO was triggered."""
        self._now = self._end = 0
        self._install_hooks()
        self.restart()

    def restart(self) -> None:
        """As after power-on: standby, everything at its reset value."""
        self.registers.reset()
        values = self.registers.values
        self.sampler = Sampler(
            self._world, self._response(), word_format(values[DATA_FORMAT], values[BW_RATE])
        )
        self.fifo.reset()
        self.detection.reset()
        self.tick = 0
        self._asleep = False
        self.trigger_ns = None

    def look_anew(self, time_ns: int, error_ppb: int | None) -> None:
        """Sample anew from now on, with another error of the oscillator if one is given."""
        self.advance(time_ns)
        if error_ppb is not None:
            self._error_ppb = error_ppb
        if self.sampler.plan is not None:
            if error_ppb is not None:
                self.sampler.clock.pull(time_ns, TICK_RATE_HZ, error_ppb)
            self.sampler.configure(self.tick, self.sampler.plan)

    def _install_hooks(self) -> None:
        written = self.registers.after_write
        for register in DETECTION_REGISTERS:
            written[register] = lambda old, new, register=register: self._detection(register, old, new)  # type: ignore[misc]
        for register in OFFSETS:
            written[register] = lambda _old, _new: self._convert()
        written[DATA_FORMAT] = lambda _old, _new: self._convert()
        written[BW_RATE] = self._rate_changed
        written[POWER_CTL] = self._power_changed
        written[FIFO_CTL] = lambda _old, new: self.fifo.control(new, self.sampler.registers(self.tick))

    # -- modes -------------------------------------------------------------------------------------

    @property
    def measuring(self) -> bool:
        """Not in standby."""
        return bool(self.registers.values[POWER_CTL] & MEASURE)

    @property
    def sleeping(self) -> bool:
        """Sampling at the wake-up rate, by command or by itself."""
        return bool(self.registers.values[POWER_CTL] & SLEEP) or self._asleep

    def _plan(self) -> Plan | None:
        if not self.measuring:
            return None
        values = self.registers.values
        rate = values[BW_RATE]
        period = wakeup_period(values[POWER_CTL]) if self.sleeping else rate_period(rate)
        decimates = period > 1 and not self.sleeping and not rate & LOW_POWER
        fine = decimates and bool(self.detection.enabled & UNDECIMATED)
        return Plan(period, fine, noise_bandwidth_hz(1 if fine else period, rate))

    def _response(self) -> Response:
        values = self.registers.values
        x, y, z = (offset_g(values[OFSX + axis]) + self._supply_bias[axis] for axis in range(3))
        deflects = values[DATA_FORMAT] & SELF_TEST
        return Response(self._gain, (x, y, z), self._self_test if deflects else (0.0, 0.0, 0.0))

    def _convert(self) -> None:
        values = self.registers.values
        form = word_format(values[DATA_FORMAT], values[BW_RATE])
        self.sampler.convert(self.tick, self._response(), form)

    def _rate_changed(self, _old: int, _new: int) -> None:
        self._convert()
        self._replan()

    def _replan(self) -> None:
        """Another grid on the clock that runs."""
        plan = self._plan()
        if plan != self.sampler.plan:
            self.sampler.configure(self.tick, plan)

    def _begin(self, start_ns: int) -> None:
        """A new stretch of sampling, of which the first period begins at `start_ns`."""
        clock = Oscillator(TICK_RATE_HZ, start_ns, self._error_ppb)
        self.detection.restart(asleep=self.sleeping)
        self.sampler.restart(self.tick, clock, self._plan())
        self.tick = 0

    def _power_changed(self, old: int, new: int) -> None:
        was_sleeping = bool(old & SLEEP) or self._asleep
        if not new & LINK or not new & AUTO_SLEEP or not new & MEASURE:
            self._asleep = False
        self.detection.written(POWER_CTL, old, new, asleep=self.sleeping)
        if not new & MEASURE:
            self.sampler.restart(self.tick, self.sampler.clock, None)
            self.tick = 0
        elif not old & MEASURE or (was_sleeping and not self.sleeping):
            self._begin(self._end + TURN_ON_NS)
        elif self.sleeping and not was_sleeping:
            self._begin(self._end)
        else:
            self._replan()

    def _detection(self, register: int, old: int, new: int) -> None:
        self.detection.written(register, old, new, asleep=self.sleeping)
        self._replan()

    def _turn_in_or_out(self, time_ns: int) -> None:
        """Auto-sleep: from inactivity of a linked pair, once no activity waits to be read, until activity."""
        power = self.registers.values[POWER_CTL]
        if power & (LINK | AUTO_SLEEP) != LINK | AUTO_SLEEP or not power & MEASURE:
            return
        waits = bool(self.detection.flags & self.registers.values[INT_ENABLE] & ACTIVITY)
        asleep = self.detection.rests and (self._asleep or not waits)
        if asleep == self._asleep:
            return
        self._asleep = asleep
        if not power & SLEEP:
            self._begin(time_ns if asleep else time_ns + TURN_ON_NS)

    # -- time --------------------------------------------------------------------------------------

    def advance(self, time_ns: int) -> None:
        """Bring the chip up to a time."""
        while self.sampler.plan is not None:
            tick = self.sampler.clock.tick(time_ns)
            if tick <= self.tick:
                break
            self._step(tick)
        self._now = time_ns

    def resume(self, row: int) -> None:
        """The FIFO has been brought up to date with that row of the block."""
        self.tick = max(self.tick, self.sampler.tick_of(row))

    def _step(self, upto: int) -> None:
        """Up to the first tick at which something changes, at most to `upto`."""
        sampler = self.sampler
        plan = sampler.plan
        assert plan is not None
        before, stop = self.tick, upto
        if self.fifo.armed and not self.sleeping:
            count = self.fifo.samples_to_change(*self._wanted(self._trigger_mask()))
            if count:
                stop = min(stop, (before // plan.period + count) * plan.period)
        if self.detection.enabled:
            sampler.cover(before + 1)
            stop = min(stop, max(sampler.end_tick - 1, before + 1))
            stop = self.detection.run(sampler, before, stop)
        if not self.sleeping:
            self.fifo.take(sampler, before, stop // plan.period - before // plan.period)
        self.tick = stop
        if self.fifo.armed:
            self._pull_trigger()
        if self.detection.enabled:
            self._turn_in_or_out(sampler.clock.instant(stop))

    def _trigger_mask(self) -> int:
        """Enabled sources on the pin that triggers the FIFO."""
        values = self.registers.values
        mapped = values[INT_MAP] if values[FIFO_CTL] & 0x20 else ~values[INT_MAP]
        return values[INT_ENABLE] & mapped & 0xFF

    def _pull_trigger(self) -> None:
        if self.source() & self._trigger_mask():
            self.fifo.trigger()
            self.trigger_ns = self.sampler.clock.instant(self.tick) if self.sampler.plan else self._now

    @staticmethod
    def _wanted(mask: int) -> tuple[bool, bool, bool]:
        return bool(mask & DATA_READY), bool(mask & WATERMARK), bool(mask & OVERRUN)

    # -- what shows --------------------------------------------------------------------------------

    def source(self) -> int:
        """INT_SOURCE as of the last `advance`."""
        fifo = self.fifo
        return (
            self.detection.flags
            | (DATA_READY if fifo.data_ready else 0)
            | (WATERMARK if fifo.watermark else 0)
            | (OVERRUN if fifo.overrun else 0)
        )

    def asserted(self) -> tuple[bool, bool]:
        """Whether INT1 and INT2 are active as of the last `advance`."""
        values = self.registers.values
        active = self.source() & values[INT_ENABLE]
        return bool(active & ~values[INT_MAP]), bool(active & values[INT_MAP])

    def act_tap_status(self) -> int:
        """ACT_TAP_STATUS."""
        return self.detection.sources | (ASLEEP if self._asleep else 0)

    def next_change(self, mask: int) -> int | None:
        """The time (ns) at which one of the sources in `mask`, or the detection that they hang on, can change
        at the earliest; None when time alone changes nothing."""
        sampler = self.sampler
        if sampler.plan is None:
            return None
        times = []
        count = 0 if self.sleeping else self.fifo.samples_to_change(*self._wanted(mask & LIVE))
        if count:
            times.append(sampler.instant_after(self.tick, count))
        power = self.registers.values[POWER_CTL]
        turns = power & AUTO_SLEEP and power & LINK
        if self.detection.enabled & mask & DETECTED or (self.detection.enabled and turns) or self.fifo.armed:
            stop = self.tick + 1
            if self.detection.enabled:
                stop = max(stop, self.detection.foresee(sampler, self.tick))
                times.append(sampler.clock.instant(stop))
            count = self.fifo.samples_to_change(*self._wanted(self._trigger_mask())) if self.fifo.armed else 0
            if count:
                times.append(sampler.instant_after(self.tick, count))
        return min(times, default=None)

    # -- bus access --------------------------------------------------------------------------------

    def newest(self) -> bytes:
        """A zero and the data registers of the newest sample."""
        return self.sampler.registers(self.tick)

    def source_read(self) -> None:
        """INT_SOURCE was read: its latches fall."""
        self.detection.clear()
        self._turn_in_or_out(self._now)

    def write(self, address: int, value: int, start_ns: int, end_ns: int) -> None:
        """One register; the chip is up to date with `start_ns`. What takes its time counts from `end_ns`."""
        self._end = end_ns
        self.registers.write(address, value, start_ns)
        if self.fifo.armed:
            self._pull_trigger()

    @property
    def steady(self) -> bool:
        """Whether nothing but output samples can change anything."""
        fifo = self.fifo
        return (
            self.sampler.plan is not None
            and not self.sleeping
            and not self.detection.enabled
            and not fifo.armed
            and (self.trigger_ns is None or self._now > self.trigger_ns + POP_NS)
        )

    @property
    def plain_bypass(self) -> bool:
        """Whether a read of the data needs nothing but the newest sample of steady sampling."""
        return self.fifo.mode == BYPASS and self.steady
