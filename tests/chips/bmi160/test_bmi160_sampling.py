"""Sample clock, rates, scales, data registers, sensor time, temperature (fact sheet sections 3, 4, 7)."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import ceil, floor, pi, radians

import numpy as np
import pytest
from bmi160_rig import BYTE_NS, MS, G, Rig, rising
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.chips.bmi160.sensor_clock import SensorClock

DATA_READY_ON_INT1 = ((0x53, 0x0A), (0x56, 0x80), (0x51, 0x10))

# Fact sheet section 4: counts per g, counts per deg/s.
ACCEL_SCALES = {0x03: 16384, 0x05: 8192, 0x08: 4096, 0x0C: 2048}
GYRO_SCALES = {0: 16.4, 1: 32.8, 2: 65.6, 3: 131.2, 4: 262.4}
# Fact sheet section 3: ODR codes.
RATES = {
    1: 0.78125,
    2: 1.5625,
    3: 3.125,
    4: 6.25,
    5: 12.5,
    6: 25,
    7: 50,
    8: 100,
    9: 200,
    10: 400,
    11: 800,
    12: 1600,
}


def data_ready_rig(**options: object) -> Rig:
    rig = Rig(listen="INT1", **options)  # type: ignore[arg-type]
    rig.start(accel=False, gyro=False)
    for register, value in DATA_READY_ON_INT1:
        rig.write(register, value)
    return rig


# -- rates -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("code", "rate"), [(code, RATES[code]) for code in (1, 4, 5, 6, 8, 11, 12)])
def test_accelerometer_samples_over_ten_seconds(code: int, rate: float) -> None:
    rig = data_ready_rig()
    rig.write(0x40, 0x20 | code)
    rig.write(0x7E, 0x11, gap_ns=4 * MS)
    rig.edges["INT1"].clear()
    begin = rig.time.now
    rig.until(begin + 10_000 * MS)
    assert abs(len(rising(rig.edges["INT1"])) - 10 * rate) <= 1


@pytest.mark.parametrize(("code", "rate"), [(6, 25), (8, 100), (13, 3200)])
def test_gyroscope_samples_over_ten_seconds(code: int, rate: float) -> None:
    rig = data_ready_rig()
    rig.write(0x42, 0x20 | code)
    rig.write(0x7E, 0x15, gap_ns=80 * MS)
    rig.edges["INT1"].clear()
    rig.until(rig.time.now + 10_000 * MS)
    assert abs(len(rising(rig.edges["INT1"])) - 10 * rate) <= 1


@pytest.mark.parametrize("ppm", [-3000.0, 0.0, 5000.0, 1234.567])
def test_sample_instants_are_exact(ppm: float) -> None:
    """The n-th multiple of 256 ticks of a 25.6 kHz clock that is fast by e: n · 256 / (25600 (1 + e)) s."""
    rig = data_ready_rig(clock_error_ppm=ppm)
    rig.start(gyro=False)
    rig.wait(3_000 * MS)
    period = Fraction(256 * 10**9) / (25600 * (1 + Fraction(round(ppm * 1000), 10**9)))
    first = rising(rig.edges["INT1"])[0]
    index = round(first / period)
    for n, instant in enumerate(rising(rig.edges["INT1"])):
        assert instant == int((index + n) * period)


def test_phase_and_start_shift_the_clock() -> None:
    plain = data_ready_rig()
    shifted = data_ready_rig(start_ns=2 * MS, phase_ns=12_345)
    for rig in (plain, shifted):
        rig.start(gyro=False)
        rig.wait(100 * MS)
    a, b = rising(plain.edges["INT1"])[-1], rising(shifted.edges["INT1"])[-1]
    assert (b - a) % (10 * MS) == 2 * MS + 12_345


def test_accelerometer_and_gyroscope_sample_on_one_clock() -> None:
    """Both at their rates: the slower one's new samples coincide with the faster one's."""
    rig = Rig(motion=lambda t: {"fx": t, "wx": t})
    rig.start()
    rig.write(0x40, 0x26)  # accelerometer 25 Hz
    rig.write(0x42, 0x28)  # gyroscope 100 Hz
    rig.wait(200 * MS)
    seen = []
    for _ in range(200):
        data = rig.sample()
        seen.append((data[0], data[3]))
        rig.wait(1 * MS - 13 * BYTE_NS)
    gyro_steps = [i for i in range(1, 200) if seen[i][0] != seen[i - 1][0]]
    accel_steps = [i for i in range(1, 200) if seen[i][1] != seen[i - 1][1]]
    assert len(gyro_steps) in (19, 20)
    assert len(accel_steps) == 5
    assert set(accel_steps) <= set(gyro_steps)


# -- data registers ----------------------------------------------------------------------------------------


def test_data_are_zero_until_the_first_sample_in_normal_mode() -> None:
    rig = Rig(motion=lambda t: {"fx": 5.0, "fz": G, "wx": 1.0})
    rig.start(accel=False, gyro=False)
    assert rig.sample() == (0,) * 6
    rig.spi(b"\x7e\x11")
    rig.wait(3_700_000)
    assert rig.sample() == (0,) * 6
    rig.wait(20 * MS)
    assert rig.sample()[:3] == (0, 0, 0)
    assert rig.sample()[5] == 16384
    rig.spi(b"\x7e\x15")
    rig.wait(79 * MS)
    assert rig.sample()[:3] == (0, 0, 0)
    rig.wait(20 * MS)
    assert rig.sample()[0] != 0


def test_suspended_sensor_keeps_its_last_sample() -> None:
    rig = Rig(motion=lambda t: {"fx": t, "wx": t})
    rig.start()
    rig.wait(50 * MS)
    rig.write(0x7E, 0x14)
    before = rig.sample()
    rig.wait(500 * MS)
    after = rig.sample()
    assert after[:3] == before[:3]
    assert after[3] > before[3]


@pytest.mark.parametrize(("code", "counts"), ACCEL_SCALES.items())
def test_accelerometer_scale(code: int, counts: int) -> None:
    rig = Rig(motion=lambda t: {"fx": 0.25 * G, "fy": -1.5 * G, "fz": 1.999 * G})
    rig.start(gyro=False)
    rig.write(0x41, code)
    rig.wait(20 * MS)
    assert rig.sample()[3:] == (round(0.25 * counts), round(-1.5 * counts), round(1.999 * counts))


@pytest.mark.parametrize(("code", "counts"), GYRO_SCALES.items())
def test_gyroscope_scale(code: int, counts: float) -> None:
    rig = Rig(motion=lambda t: {"wx": radians(100.0), "wy": radians(-33.3), "wz": radians(1.0)})
    rig.start(accel=False)
    rig.write(0x43, code)
    rig.wait(20 * MS)
    assert rig.sample()[:3] == (round(100 * counts), round(-33.3 * counts), round(counts))


def test_saturation() -> None:
    rig = Rig(motion=lambda t: {"fx": 2.5 * G, "fy": -2.5 * G, "wx": radians(2100.0), "wy": -radians(2100.0)})
    rig.start()
    rig.wait(20 * MS)
    assert rig.sample()[:5] == (32767, -32768, 0, 32767, -32768)
    rig.write(0x41, 0x05)
    rig.wait(20 * MS)
    assert rig.sample()[3:5] == (20480, -20480)


def test_range_changes_from_the_next_sample_on() -> None:
    rig = Rig()
    rig.start(gyro=False)
    rig.until(200 * MS + 1)
    rig.write(0x41, 0x0C, gap_ns=2_000)
    assert rig.sample()[5] == 16384
    rig.until(210 * MS)
    assert rig.sample()[5] == 2048


def test_rate_change_fetches_again_from_the_next_sample_on() -> None:
    rig = Rig(motion=lambda t: {"fx": t})
    rig.start(gyro=False)
    rig.until(200 * MS + 1)
    held = rig.sample()[3]
    rig.write(0x40, 0x29, gap_ns=2_000)
    assert rig.sample()[3] == held
    rig.until(205 * MS)
    assert rig.sample()[3] == round(0.205 * 16384 / G)


def test_range_code_without_a_range_means_two_g() -> None:
    rig = Rig()
    rig.start(gyro=False)
    rig.write(0x41, 0x00)
    rig.wait(20 * MS)
    assert rig.sample()[5] == 16384


def test_burst_reads_one_sampling_instant() -> None:
    """The registers as of the start of the burst, however long it takes."""
    rig = Rig(motion=lambda t: dict.fromkeys(("fx", "fy", "fz", "wx", "wy", "wz"), t))
    rig.start()
    rig.until(500 * MS - 5_000)
    data = rig.sample()
    assert data[3] == data[4] == data[5] == round(0.490 * 16384 / G)
    assert data[0] == data[1] == data[2] == round(0.490 * 16.4 * 180 / pi)


def test_every_length_and_start_of_a_burst_shows_the_same_registers() -> None:
    rig = Rig(motion=lambda t: {"fx": t, "fy": -t, "wx": t, "wz": 2 * t})
    rig.start()
    rig.until(1_234 * MS)
    time = rig.time.now
    whole = rig.chip.transaction(b"\x8c" + bytes(15), time, time + 1)
    for first in range(0x0C, 0x1B):
        for count in {1, min(2, 0x1B - first), 0x1B - first}:
            part = rig.chip.transaction(bytes((0x80 | first,)) + bytes(count), time, time + 1)
            assert part[1:] == whole[1 + first - 0x0C : 1 + first - 0x0C + count]


# -- sensor time -------------------------------------------------------------------------------------------


def test_sensor_time_counts_25600_a_second_in_suspend_too() -> None:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    for second in (1, 2, 100):
        rig.until(second * 1_000 * MS)
        assert rig.sensor_time() == second * 25600


def test_sensor_time_wraps_after_655_36_seconds() -> None:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    rig.until(655_360 * MS - 1)
    assert rig.sensor_time() == 0xFFFFFF
    rig.until(655_360 * MS + 100_000)
    assert rig.sensor_time() == 2


@pytest.mark.parametrize(("bit", "rate"), [(8, 100), (7, 200), (6, 400), (4, 1600), (3, 3200)])
def test_sensor_time_bits_toggle_at_the_output_rates(bit: int, rate: int) -> None:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    levels = []
    for step in range(2000):
        time = 1_000 * MS + step * 50_000
        data = rig.chip.transaction(b"\x98" + bytes(3), time, time + 1)
        levels.append(int.from_bytes(data[1:], "little") >> bit & 1)
    toggles = sum(a != b for a, b in pairwise(levels))
    assert abs(toggles - rate / 10) <= 1


def test_sensor_time_in_the_common_burst_is_the_counter_at_its_start() -> None:
    rig = Rig(clock_error_ppm=5000.0)
    rig.start()
    clock = Fraction(25600) * Fraction(1005, 1000) / 10**9
    for step in range(300):
        time = 200 * MS + step * 1_237_001
        data = rig.chip.transaction(b"\x8c" + bytes(15), time, time + 24_000)
        assert int.from_bytes(data[13:], "little") == int(time * clock + clock * Fraction(999_999, 1_000_000))


@pytest.mark.parametrize("ppm", [-99_999.0, 0.0, 5000.0, 99_999.0])
def test_sensor_time_right_after_data_ready_at_the_borders_of_the_counter(ppm: float) -> None:
    rig = data_ready_rig(clock_error_ppm=ppm)
    rig.start()
    rate = Fraction(25_600) * (1 + Fraction(round(ppm * 1000), 10**9)) / 10**9
    for ticks in (0, 1, 2, 3, 200):
        for offset_ns in (-1, 0, 1):
            rig.spi(b"\x8c" + bytes(15))
            rig.until(rig.time.next_due)
            sampled = ceil((rig.time.now + 1) * rate) - 1
            rig.until(max(rig.time.now, floor((sampled + ticks) / rate) + offset_ns))
            expected = ceil((rig.time.now + 1) * rate) - 1
            assert expected - sampled == (ticks - 1 if offset_ns < 0 and ticks else ticks)
            assert int.from_bytes(rig.spi(b"\x8c" + bytes(15))[13:], "little") == expected


@settings(max_examples=200, deadline=None)
@given(ppb=st.integers(-50_000_000, 50_000_000), start=st.integers(0, 10**12), tick=st.integers(0, 10**10))
def test_tick_and_instant_are_inverse(ppb: int, start: int, tick: int) -> None:
    clock = SensorClock(start, ppb)
    instant = clock.instant(tick)
    assert instant == start + int(Fraction(tick * 10**18, 25600 * (10**9 + ppb)))
    assert clock.tick(instant) == tick
    assert clock.tick(instant - 1) == max(tick - 1, 0)
    assert clock.grid(tick, 256, 5).tolist() == [clock.instant(tick + 256 * i) for i in range(5)]


# -- bandwidth ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("acc_conf", "bandwidth"),
    [
        (0x25, 5.06), (0x26, 10.12), (0x27, 20.25), (0x28, 40.5), (0x29, 80), (0x2A, 162), (0x2B, 324),
        (0x2C, 684), (0x18, 20.25), (0x08, 10.125), (0x07, 5.0625), (0x24, 2.53), (0x21, 5.06 / 16),
        (0x88, 684), (0xA8, 171),
    ],
)  # fmt: skip
def test_accelerometer_bandwidth_that_the_world_is_asked_for(acc_conf: int, bandwidth: float) -> None:
    rig = Rig()
    rig.start(gyro=False)
    rig.write(0x40, acc_conf)
    rig.wait(3_000 * MS)
    rig.sample()
    assert rig.world.calls[-1][3] == pytest.approx(bandwidth)


@pytest.mark.parametrize(
    ("gyr_conf", "bandwidth"),
    [(0x26, 10.7), (0x27, 20.8), (0x28, 39.9), (0x29, 74.6), (0x2A, 136.6), (0x2B, 254.6), (0x2C, 523.9),
     (0x2D, 890), (0x18, 19.95), (0x08, 9.975)],
)  # fmt: skip
def test_gyroscope_bandwidth_that_the_world_is_asked_for(gyr_conf: int, bandwidth: float) -> None:
    rig = Rig()
    rig.start(accel=False)
    rig.write(0x42, gyr_conf)
    rig.wait(100 * MS)
    rig.sample()
    assert rig.world.calls[-1][3] == pytest.approx(bandwidth)


@pytest.mark.parametrize(("acc_conf", "ratio"), [(0x18, 2), (0x08, 4), (0x27, 2), (0x26, 4), (0x06, 16)])
def test_narrower_sensor_has_less_noise_when_the_other_one_is_wide(acc_conf: int, ratio: int) -> None:
    """The world is asked with the gyroscope's 40 Hz; the accelerometer's variance falls with its own."""
    generator = np.random.Generator(np.random.PCG64(1))
    rig = Rig(
        motion=lambda t: {"fx": generator.normal(0.0, 0.5, len(t)), "wx": generator.normal(0.0, 0.5, len(t))}
    )
    rig.start()
    rig.write(0x40, acc_conf)
    rig.wait(1_000 * MS)
    gyro, accel = [], []
    for _ in range(4_000):
        data = rig.sample()
        gyro.append(data[0])
        accel.append(data[3])
        rig.wait(40 * MS - 13 * BYTE_NS)
    assert np.std(gyro) == pytest.approx(0.5 * 16.4 * 180 / pi, rel=0.05)
    assert np.std(accel) == pytest.approx(0.5 / G * 16384 / ratio**0.5, rel=0.08)


# -- laziness ----------------------------------------------------------------------------------------------


def test_no_event_without_a_listener() -> None:
    rig = Rig()
    rig.start()
    for register, value in DATA_READY_ON_INT1:
        rig.write(register, value)
    rig.write(0x47, 0xD0)
    events = rig.time.events_run
    rig.wait(5_000 * MS)
    assert rig.time.events_run == events
    assert rig.sample()[5] == 16384


def test_one_event_a_sample_while_the_data_are_read() -> None:
    rig = data_ready_rig()
    rig.start()
    rig.until(rising(rig.edges["INT1"])[-1] + 1 * MS)
    for _ in range(3):  # a pulse that ends by itself, then reads in time
        rig.until(rig.time.next_due + 20_000)
        rig.spi(b"\x8c" + bytes(15))
    rig.until(rig.time.now + 1 * MS)
    begin, events = len(rising(rig.edges["INT1"])), rig.time.events_run
    for _ in range(500):
        rig.until(rig.time.next_due + 20_000)
        rig.spi(b"\x8c" + bytes(15))
    assert len(rising(rig.edges["INT1"])) - begin == 500
    assert rig.time.events_run - events == 500


def test_reading_after_a_long_time_costs_one_block() -> None:
    rig = Rig(motion=lambda t: {"fx": t * 1e-3})
    rig.start()
    rig.sample()
    calls = len(rig.world.calls)
    rig.until(3_600_000 * MS)
    assert rig.sample()[3] == round(3.6 * 16384 / G)
    assert len(rig.world.calls) == calls + 1
    assert rig.world.calls[-1][2] == 88


def test_world_is_asked_in_long_blocks_after_a_first_short_one() -> None:
    rig = data_ready_rig()
    rig.start()
    rig.wait(20_000 * MS)
    blocks = [call for call in rig.world.calls if call[2] > 1]
    steady = next(k for k, call in enumerate(blocks) if call[2] != 88)
    assert steady > 0
    assert len(blocks) > steady + 1
    for first_ns, last_ns, count, _ in blocks[steady:]:
        assert count == 704
        assert last_ns - first_ns == 7030 * MS
    assert all(later[0] - earlier[1] == 10 * MS for earlier, later in pairwise(blocks[steady - 1 :]))
