"""What happens at sample instants: data registers, data ready, FIFO, motion detectors, offset measurement.

Nothing runs by itself. `observe` works off all samples up to a time that FIFO, detectors and measurement
want to see; while none of them is on, samples cost nothing until somebody reads them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from struct import unpack

import numpy as np

from boards.chips.bmi160.calibration import OffsetMeasurement, conversion
from boards.chips.bmi160.fifo import Fifo
from boards.chips.bmi160.fifo_feed import FifoFeed, unfiltered
from boards.chips.bmi160.interrupts import PULSE_NS, SOURCES, Interrupts, Source
from boards.chips.bmi160.motion import MotionDetectors
from boards.chips.bmi160.power import LOW_POWER, NORMAL, PowerModes, Sensor
from boards.chips.bmi160.register_map import ACC_RANGE, DRDY_ACC, DRDY_GYR
from boards.chips.bmi160.sampler import Plan, Sampler
from boards.chips.bmi160.sensor_clock import TICK_RATE_HZ, SensorClock
from boards.chips.bmi160.settings import ACCEL_COUNTS_PER_G, Stream
from boards.chips.world import ImuWorld

TEMPERATURE_FAST_TICKS, TEMPERATURE_SLOW_TICKS = 256, 32_768
"""Refresh: 10 ms with the gyroscope in normal mode, 1.28 s otherwise (fact sheet section 4)."""

_DETECTORS = (Source.ANY_MOTION, Source.NO_MOTION, Source.HIGH_G, Source.LOW_G)


def following(tick: int, period: int) -> int:
    """The next multiple of a period after a tick."""
    return (tick // period + 1) * period


class Acquisition:
    """The data side of the chip. `registers` are its register values."""

    def __init__(self, world: ImuWorld, registers: Sequence[int]) -> None:
        self.registers = registers
        self.world = world
        self.power = PowerModes()
        self.interrupts = Interrupts(registers)
        self.fifo = Fifo()
        self.feed = FifoFeed(registers, self.fifo)
        self.motion = MotionDetectors(registers)
        self.measurement: OffsetMeasurement | None = None
        self.inputs: Callable[[int], int] = lambda _time_ns: 0
        """Levels of INT1 (bit 0) and INT2 (bit 1) as inputs at a time, for FIFO tags."""
        self.restart(0, 0)

    def restart(self, start_ns: int, error_ppb: int) -> None:
        """All as after power-up, with the sensor clock starting at `start_ns`."""
        self.clock = SensorClock(start_ns, error_ppb)
        self.sampler = Sampler(self.clock, self.world, conversion(self.registers))
        self.power = PowerModes()
        self.interrupts.reset()
        self.fifo.flush()
        self.feed.changed = 0
        self.feed.configure(Plan())
        self.motion.restart()
        self.measurement = None
        self.gyro_stream: Stream | None = None
        self.accel_stream: Stream | None = None
        self._observed = 0
        self._step = 0
        self._detecting = False
        self._newest = {Sensor.GYRO: -1, Sensor.ACCEL: -1}
        self._read = {Sensor.GYRO: -1, Sensor.ACCEL: -1}
        self._announced = -1
        self._temperature = (0, 0)

    def look_anew(self, time_ns: int, error_ppb: int | None) -> None:
        """Sample anew from now on, with another error of the oscillator if one is given."""
        tick = self.clock.tick(time_ns)
        self._newest = {sensor: self._newest_sample(sensor, tick) for sensor in self._newest}
        if error_ppb is not None:
            self.clock.pull(time_ns, TICK_RATE_HZ, error_ppb)
        self.sampler.configure(tick, self.sampler.plan)

    # -- configuration -----------------------------------------------------------------------------

    def configure(self, time_ns: int, gyro: Stream, accel: Stream) -> None:
        """Follow power modes, rates and FIFO set-up from the next sample on."""
        tick = self.clock.tick(time_ns)
        self._newest = {sensor: self._newest_sample(sensor, tick) for sensor in self._newest}
        self.gyro_stream = gyro if self.power.gyro == NORMAL else None
        self.accel_stream = accel if self.power.accel in (NORMAL, LOW_POWER) else None
        raw_gyro, raw_accel = unfiltered(self.registers)
        plan = Plan(
            self.gyro_stream,
            self.accel_stream,
            raw_gyro and self.gyro_stream is not None,
            raw_accel and self.accel_stream is not None,
        )
        if plan != self.sampler.plan:
            self.sampler.configure(tick, plan)
        self.feed.configure(plan)
        shortest = min((s.period for s in (self.gyro_stream, self.accel_stream) if s), default=0)
        if shortest:
            half_period = shortest * self.clock.numerator // self.clock.denominator // 2
            self.interrupts.pulse_ns = min(PULSE_NS, half_period)
        self._choose_step()

    def convert(self, time_ns: int) -> None:
        """Follow ranges, offsets and self-test from the next sample on."""
        self.sampler.convert(self.clock.tick(time_ns), conversion(self.registers))
        self.motion.restart()

    def enables_changed(self, time_ns: int) -> None:
        """Follow the interrupt enables."""
        for source in SOURCES:
            if not source.enabled(self.registers):
                self.interrupts.disable(source)
        self.motion.restart()
        self.fifo_changed(time_ns)
        self._choose_step()

    def _choose_step(self) -> None:
        periods = [self.feed.step]
        self._detecting = bool(self.accel_stream) and any(s.enabled(self.registers) for s in _DETECTORS)
        if self.accel_stream and (self.measurement or self._detecting):
            periods.append(self.accel_stream.period)
        if self.gyro_stream and self.measurement:
            periods.append(self.gyro_stream.period)
        self._step = min((period for period in periods if period), default=0)

    def measure(self, measurement: OffsetMeasurement | None) -> None:
        """Begin (or, with None, end) collecting samples for an offset measurement."""
        self.measurement = measurement
        self._choose_step()

    @property
    def looks_at_samples(self) -> bool:
        """Whether FIFO, detectors or a measurement want to see each sample, in its order."""
        return self._step > 0

    # -- samples -----------------------------------------------------------------------------------

    def observe(self, time_ns: int) -> None:
        """Work off the samples up to `time_ns`; announce the newest."""
        tick = self.clock.tick(time_ns)
        if self._step and tick > self._observed:
            self.sampler.visit(self._observed, tick, self._step, self._sample)
        self._observed = max(tick, self._observed)
        self.announce_data(time_ns)

    def _sample(self, tick: int) -> None:
        time_ns = self.clock.instant(tick)
        if self.feed.step:
            self.feed.sample(tick, self.sampler, self.inputs(time_ns) if self.feed.tags_enabled else 0)
            self.fifo_changed(time_ns)
        if self.measurement is not None:
            self.measurement.add(self.sampler.physical(tick))
        if self._detecting and self.accel_stream is not None and tick % self.accel_stream.period == 0:
            self._detect(tick, time_ns)

    def flush_fifo(self, time_ns: int) -> None:
        """Empty the FIFO."""
        self.fifo.flush()
        self.fifo_changed(time_ns)

    def fifo_changed(self, time_ns: int) -> None:
        """The fill level changed: decide the FIFO's interrupt conditions again."""
        if Source.FIFO_WATERMARK.enabled(self.registers):
            self.interrupts.set_condition(Source.FIFO_WATERMARK, self.feed.watermark_reached, time_ns)
        if Source.FIFO_FULL.enabled(self.registers):
            self.interrupts.set_condition(Source.FIFO_FULL, self.feed.full, time_ns)

    def _detect(self, tick: int, time_ns: int) -> None:
        motion, interrupts, registers = self.motion, self.interrupts, self.registers
        values = unpack("<3h", self.sampler.registers(tick)[6:])
        slopes = motion.slopes(values)
        if slopes is not None and Source.ANY_MOTION.enabled(registers):
            condition, detail = motion.any_motion(slopes, interrupts.condition(Source.ANY_MOTION))
            interrupts.motion_detail = detail or interrupts.motion_detail
            interrupts.set_condition(Source.ANY_MOTION, condition, time_ns)
        if slopes is not None and Source.NO_MOTION.enabled(registers):
            condition = motion.slow_or_no_motion(slopes, interrupts.condition(Source.NO_MOTION), tick)
            interrupts.set_condition(Source.NO_MOTION, condition, time_ns)
        if Source.HIGH_G.enabled(registers):
            condition, detail = motion.high_g(values, interrupts.condition(Source.HIGH_G), tick)
            interrupts.high_g_detail = detail or interrupts.high_g_detail
            interrupts.set_condition(Source.HIGH_G, condition, time_ns)
        if Source.LOW_G.enabled(registers):
            per_g = ACCEL_COUNTS_PER_G.get(registers[ACC_RANGE], ACCEL_COUNTS_PER_G[0x3])
            condition = motion.low_g(values, interrupts.condition(Source.LOW_G), tick, per_g)
            interrupts.set_condition(Source.LOW_G, condition, time_ns)

    # -- data ready --------------------------------------------------------------------------------

    def _newest_sample(self, sensor: Sensor, tick: int) -> int:
        stream = self.gyro_stream if sensor is Sensor.GYRO else self.accel_stream
        return max(self._newest[sensor], self.sampler.last_sample(tick, stream))

    def data_read(self, sensors: Iterable[Sensor], time_ns: int) -> None:
        """The bus read data registers of these sensors."""
        self.announce_data(time_ns)
        tick = self.clock.tick(time_ns)
        for sensor in sensors:
            self._read[sensor] = tick
        self.interrupts.withdraw(Source.DATA_READY)

    def data_ready_bits(self, time_ns: int) -> int:
        """The data-ready bits of STATUS."""
        tick = self.clock.tick(time_ns)
        gyro = DRDY_GYR if self._newest_sample(Sensor.GYRO, tick) > self._read[Sensor.GYRO] else 0
        accel = DRDY_ACC if self._newest_sample(Sensor.ACCEL, tick) > self._read[Sensor.ACCEL] else 0
        return gyro | accel

    def announce_data(self, time_ns: int) -> None:
        """Fire the data-ready interrupt for the newest sample, once."""
        tick = self.clock.tick(time_ns)
        newest = max(self._newest_sample(sensor, tick) for sensor in self._newest)
        if newest > self._announced:
            self._announced = newest
            if Source.DATA_READY.enabled(self.registers):
                self.interrupts.event(Source.DATA_READY, self.clock.instant(newest))

    def next_sample(self, time_ns: int) -> int | None:
        """The next instant after `time_ns` at which a sample can change a pin."""
        tick = self.clock.tick(time_ns)
        ticks = []
        if self._detecting and self.accel_stream is not None:
            ticks.append(following(tick, self.accel_stream.period))
        if Source.DATA_READY.enabled(self.registers):
            streams = (self.gyro_stream, self.accel_stream)
            ticks += [following(tick, stream.period) for stream in streams if stream is not None]
        steps = self.feed.steps_to_interrupt()
        if steps:
            ticks.append(following(tick, self.feed.step) + (steps - 1) * self.feed.step)
        return self.clock.instant(min(ticks)) if ticks else None

    # -- temperature -------------------------------------------------------------------------------

    def temperature(self, time_ns: int) -> int:
        """TEMPERATURE: 1/512 °C per LSB from 23 °C; 0 until the first refresh."""
        tick = self.clock.tick(time_ns)
        refresh = TEMPERATURE_FAST_TICKS if self.power.gyro == NORMAL else TEMPERATURE_SLOW_TICKS
        tick -= tick % refresh
        if tick > self._temperature[0]:
            counts = round((self._celsius(tick) - 23.0) * 512.0)
            self._temperature = (tick, max(-32767, min(32767, counts)) & 0xFFFF)
        return self._temperature[1]

    def _celsius(self, tick: int) -> float:
        sampler = self.sampler
        if sampler.grid:
            sampler.cover(tick)
            if sampler.first_tick < sampler.end_tick:
                return float(sampler.physical(max(tick, sampler.first_tick))[6])
        instants = np.array([self.clock.instant(tick)], dtype=np.int64)
        return float(self.world.sample(instants, 1.0)[0, 6])
