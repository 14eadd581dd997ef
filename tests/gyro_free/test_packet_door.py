"""Packets: written and read, spoilt ones refused, and a drive through them on the chips' own noise."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from packet_drive import accelerometer_words, packet_words

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav.gyro_free import alignment
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.config import GyroFreeConfig
from firmware.nav.gyro_free.filters import adxl345_filters, begin, new_federation
from firmware.nav.gyro_free.packet import open_packet, put_number, seal_packet
from firmware.nav.gyro_free.packet_door import (
    COMPASS_BELIEVED,
    FUSED,
    GPS_BELIEVED,
    SAMPLE_USED,
    PacketDoor,
)
from firmware.nav.gyro_free.packet_step import epoch_of_packet
from host.tables.chapter5 import HEADING, SPEED, chapter5

FROM_REGISTERS = np.zeros(7, np.float32)
words_of = st.lists(st.integers(0, 0xFFFF), min_size=pk.WORDS, max_size=pk.WORDS)


def sealed(values: list[int]) -> np.ndarray:
    data = np.zeros(pk.BYTES, np.uint8)
    seal_packet(np.array(values, np.int64), data)
    return data


@settings(deadline=None)
@given(words_of)
def test_a_packet_comes_back_as_it_was(values: list[int]) -> None:
    words = np.zeros(pk.WORDS, np.int64)
    assert open_packet(sealed(values), words) == pk.GOOD
    assert words[2:47].tolist() == values[2:47]


@settings(deadline=None)
@given(words_of, st.integers(0, pk.BYTES * 8 - 1))
def test_one_wrong_bit_is_seen(values: list[int], bit: int) -> None:
    data = sealed(values)
    data[bit // 8] ^= 1 << (bit % 8)
    assert open_packet(data, np.zeros(pk.WORDS, np.int64)) != pk.GOOD


@pytest.mark.parametrize("slip", [1, 2, 4, -2, 95])
def test_a_slip_is_seen(slip: int) -> None:
    data = sealed(list(range(7, 7 + pk.WORDS)))
    assert open_packet(np.roll(data, slip).copy(), np.zeros(pk.WORDS, np.int64)) == pk.NO_SYNC


@settings(deadline=None)
@given(st.integers(-(2**63), 2**63 - 1), st.integers(-(2**31), 2**31 - 1))
def test_numbers_of_an_epoch_come_back(latitude: int, height: int) -> None:
    words, epoch = np.zeros(pk.WORDS, np.int64), np.zeros(gnss.RECORD_SIZE, np.int64)
    put_number(words, pk.LATITUDE, latitude, 4)
    put_number(words, pk.HEIGHT, height, 2)
    words[pk.GPS_AGE] = 1234
    epoch_of_packet(words, epoch, 10**9)
    assert epoch[gnss.LAT_NANODEG] == latitude
    assert epoch[gnss.HEIGHT_MM] == height
    assert epoch[gnss.VALID_NS] == 10**9 - 123_400_000


def test_a_drive_on_the_chips_own_noise_is_held_by_compass_and_gps() -> None:
    seconds = 40
    feed = chapter5(seconds, 5)
    offsets = np.random.default_rng(5).normal(0.0, 0.03 * 9.80665, 9)
    offsets[6:] = 0.0  # those at the origin are calibrated
    accelerations = accelerometer_words(feed, 5, offsets)
    sensor = GyroFreeConfig()
    config = adxl345_filters(sensor)
    federation = new_federation(config)
    sums, angles = np.zeros(alignment.SIZE, np.float32), np.zeros(3, np.float32)
    for sample in range(2000):
        alignment.gather_rest(federation.g, packet_words(feed, sample, accelerations), sums)
    assert alignment.finish_alignment(federation.g, federation.n, sums, angles)
    assert federation.g[gl.OFFSET : gl.OFFSET + 6] == pytest.approx(offsets[:6], abs=0.02)
    assert angles[0] == pytest.approx(HEADING, abs=0.02)
    begin(federation, config, feed.start)
    door = PacketDoor(federation)
    told = [
        door.take(packet_words(feed, sample, accelerations), FROM_REGISTERS)
        for sample in range(seconds * 200)
    ]
    assert told[198] == SAMPLE_USED
    assert told[199] == SAMPLE_USED | COMPASS_BELIEVED | GPS_BELIEVED | FUSED
    assert sum(bool(one & FUSED) for one in told) == 10 * seconds
    f, i = federation.master
    assert not federation.n[gl.STATUS : gl.STATUS + 2].any()
    north = (math.degrees(i[at.LATITUDE] * 2.0**-40) - math.degrees(feed.truth[-1, 0])) * 111e3
    assert abs(north) < 20.0
    assert math.hypot(f[at.VELOCITY], f[at.VELOCITY + 1]) == pytest.approx(SPEED, abs=1.0)
    w, x, y, z = f[:4].astype(float)
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    assert yaw == pytest.approx(HEADING, abs=math.radians(3.0))
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    assert abs(roll) < math.radians(2.0)
    # the rate would have gone far away meanwhile, but for what the filters know of it
    assert np.max(np.abs(federation.g[gl.INTEGRAL : gl.INTEGRAL + 3])) < math.radians(5.0)


def test_a_missing_chip_is_no_sample_and_the_past_is_no_packet() -> None:
    feed = chapter5(3, 5)
    accelerations = accelerometer_words(feed, 5, np.zeros(9))
    config = adxl345_filters(GyroFreeConfig())
    federation = new_federation(config)
    begin(federation, config, feed.start)
    door = PacketDoor(federation)
    for sample in range(100):
        words = packet_words(feed, sample, accelerations)
        words[pk.FAULTS] = 0b100 if sample >= 50 else 0
        assert bool(door.take(words, FROM_REGISTERS) & SAMPLE_USED) == (sample < 50)
    state = [one.copy() for one in federation.all]
    assert door.take(packet_words(feed, 10, accelerations), FROM_REGISTERS) == 0
    assert all(np.array_equal(a, b) for a, b in zip(state, federation.all, strict=True))
    assert np.all(np.isfinite(federation.master[0][:9]))


@pytest.mark.parametrize("told", [True, False])
def test_an_acquisition_that_begins_anew_is_gone_on_with(told: bool) -> None:
    """Its clock starts at 0 again after 0.8 s of silence, 20 s into the drive."""
    feed = chapter5(30, 5)
    accelerations = accelerometer_words(feed, 5, np.zeros(9))
    config = adxl345_filters(GyroFreeConfig())
    federation = new_federation(config)
    begin(federation, config, feed.start)
    door = PacketDoor(federation)
    for sample in range(30 * 200):
        if 4000 <= sample < 4160:
            continue
        words = packet_words(feed, sample, accelerations)
        if sample >= 4160:
            put_number(words, pk.TIME, (sample - 4159) * 5000, 3)
        done = door.take(words, FROM_REGISTERS, sample * 5_000_000 if told else None)
        assert done or 4160 <= sample < 4400
    assert federation.n[gl.RESTARTS] == 1
    assert not federation.n[gl.STATUS : gl.STATUS + 2].any()
    f, i = federation.master
    if told:
        assert i[at.TIME] == pytest.approx(30_000_000_000, abs=10_000_000)
    north = (math.degrees(i[at.LATITUDE] * 2.0**-40) - math.degrees(feed.truth[-1, 0])) * 111e3
    assert abs(north) < 20.0
    assert math.hypot(f[at.VELOCITY], f[at.VELOCITY + 1]) == pytest.approx(SPEED, abs=1.5)
