"""Inputs of the gyro-free kernels for the gate: filters met within a few seconds, in every reset mode."""

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.nav import layout as at
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import least_squares, steps
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.compass_calibration import take_field
from firmware.nav.gyro_free.config import GyroFreeConfig, new_sensor
from firmware.nav.gyro_free.filters import Federation, FilterConfig, begin, new_federation
from firmware.nav.gyro_free.packet import put_number, seal_packet
from firmware.nav.gyro_free.states import X_COMPASS_ERROR
from firmware.nav.gyro_free.table_calibration import RESULT_SIZE, take_position
from firmware.nav.imu import imu_step
from host.tables.chapter5 import PERIOD, PERIOD_NS, Feed, chapter5

Rng = np.random.Generator
SECONDS = 3


@functools.cache
def feed() -> Feed:
    return chapter5(SECONDS, 1)


@functools.cache
def driven(reset: str, samples: int) -> Federation:
    """After so many samples, with fusions at full seconds."""
    config = FilterConfig(reset=reset)
    federation = new_federation(config)
    begin(federation, config, feed().start)
    g, n = federation.g, federation.n
    for k in range(samples):
        t_ns = (k + 1) * PERIOD_NS
        for f, i in (federation.compass, federation.gps, federation.master):
            imu_step(f, i, t_ns, PERIOD, *feed().inertial[k].tolist())
        if (k + 1) % 20 == 0:
            steps.compass_step(g, n, *federation.compass, *feed().compass[(k + 1) // 20 - 1].tolist(), t_ns)
        if (k + 1) % 200 == 0:
            steps.gps_step(g, n, *federation.gps, feed().epochs[(k + 1) // 200 - 1])
            steps.fusion_step(g, n, *federation.all)
    return federation


def ridden(rng: Rng) -> tuple[list[NDArray[Any]], int]:
    """g, n, f1, i1, f2, i2, fm, im of their own, and the samples they have seen."""
    samples = int(rng.choice([60, 199, 240, 400]))
    federation = driven(gl.RESET_NAMES[rng.integers(0, 4)], samples)
    arrays = [one.copy() for one in (federation.g, federation.n, *federation.all)]
    if rng.integers(0, 4) == 0:
        arrays[1][gl.STATUS + rng.integers(0, 2)] = gl.ISOLATED
        arrays[1][gl.GOOD : gl.GOOD + 2] = rng.integers(0, 40, 2)
    arrays[1][gl.RATE_IS_OWN] = rng.integers(0, 2)
    if rng.integers(0, 3) == 0:
        arrays[2][at.D + X_COMPASS_ERROR + 2] += 0.01
        arrays[4][at.D + at.X_ATTITUDE + 2] += 0.1
    return arrays, samples


def sensor(rng: Rng) -> tuple[NDArray[Any], NDArray[np.int64]]:
    g, n = new_sensor(GyroFreeConfig(method=gl.METHOD_NAMES[rng.integers(0, 4)]))
    n[gl.HAVE_SAMPLE] = rng.integers(0, 2)
    places = (gl.ACCELERATION, 9, 3.0), (gl.ANGULAR_ACCELERATION, 12, 1.0), (gl.INTEGRAL, 9, 1.0)
    for place, count, size in places:
        g[place : place + count] = rng.normal(0.0, size, count)
    if rng.integers(0, 8) == 0:
        g[gl.ACCELERATION] = np.nan
    return g, n


def for_rate_step(rng: Rng) -> tuple[Any, ...]:
    return *sensor(rng), 0.005


def sample(rng: Rng) -> tuple[float, ...]:
    return tuple(feed().inertial[rng.integers(0, 600)].tolist())


def for_compass_step(rng: Rng) -> tuple[Any, ...]:
    arrays, samples = ridden(rng)
    return *arrays[:4], *feed().compass[rng.integers(0, 30)].tolist(), samples * PERIOD_NS


def epoch(rng: Rng, samples: int) -> NDArray[np.int64]:
    told = feed().epochs[rng.integers(0, SECONDS)].copy()
    told[gnss.VALID_NS] = (samples - 10) * PERIOD_NS
    return told


def for_gps_step(rng: Rng) -> tuple[Any, ...]:
    arrays, samples = ridden(rng)
    return *arrays[:2], *arrays[4:6], epoch(rng, samples)


def for_fusion_step(rng: Rng) -> tuple[Any, ...]:
    return tuple(ridden(rng)[0])


def words(rng: Rng, t_ns: int) -> NDArray[np.int64]:
    """A packet's words, as the acquisition fills them in."""
    packet = np.zeros(pk.WORDS, np.int64)
    put_number(packet, pk.TIME, t_ns // 1000, 3)
    counts = np.array([0, 0, -2000, 0, 0, -2000, 0, 0, -2000]) + rng.integers(-20, 20, 9)
    packet[pk.ACCELERATIONS : pk.ACCELERATIONS + 9] = counts & 0xFFFF
    packet[pk.FAULTS] = rng.choice([0, 0, 0, 4])
    packet[pk.FLAGS] = rng.integers(0, 16)
    packet[pk.HEADING : pk.ROLL + 1] = (300, 3, 0xFFFE)
    put_number(packet, pk.LATITUDE, 28_200_210_000, 4)
    put_number(packet, pk.LONGITUDE, 112_926_470_000, 4)
    put_number(packet, pk.HEIGHT, -5131, 2)
    put_number(packet, pk.SPEED, 22_222, 2)
    put_number(packet, pk.COURSE, 3_000_000, 2)
    packet[pk.GPS_AGE] = 500
    return packet


def for_packet_step(rng: Rng) -> tuple[Any, ...]:
    arrays, samples = ridden(rng)
    t_ns = (samples + 1) * PERIOD_NS
    arrays[1][gl.TICK] = samples * PERIOD_NS
    arrays[1][gl.FUSION_DUE] = t_ns + int(rng.integers(0, 2))
    felt = np.array([rng.integers(0, 2), *sample(rng)], np.float32)
    return *arrays[:2], words(rng, t_ns), felt, *arrays[2:]


def for_open_packet(rng: Rng) -> tuple[Any, ...]:
    data = np.zeros(pk.BYTES, np.uint8)
    seal_packet(words(rng, 1_000_000_000), data)
    if rng.integers(0, 3) == 0:
        data[rng.integers(0, pk.BYTES)] ^= 1 << rng.integers(0, 8)
    return data, np.zeros(pk.WORDS, np.int64)


def for_epoch_of_packet(rng: Rng) -> tuple[Any, ...]:
    return words(rng, 5_000_000_000), np.zeros(gnss.RECORD_SIZE, np.int64), 5_000_000_000


def for_gather_rest(rng: Rng) -> tuple[Any, ...]:
    return sensor(rng)[0], words(rng, 5_000_000_000), np.zeros(16, np.float32)


def equations(rng: Rng, unknowns: int) -> NDArray[np.float32]:
    """Some equations absorbed, mostly enough of them."""
    q = np.zeros(least_squares.SIZE, np.float32)
    for _ in range(int(rng.integers(2, 20))):
        if unknowns == 4:
            take_position(q, *rng.normal(0.0, 1.0, 4).tolist())
        else:
            angle = rng.uniform(0.0, 6.28)
            take_field(q, 0.1 + 1.2 * np.cos(angle), 0.2 + np.sin(angle))
    return q


def for_take_heading(rng: Rng) -> tuple[Any, ...]:
    return equations(rng, 5), float(rng.uniform(0.0, 6.28)), float(rng.uniform(0.0, 6.28))


def for_solve_deviation(rng: Rng) -> tuple[Any, ...]:
    return (equations(rng, 5),)


def for_take_field(rng: Rng) -> tuple[Any, ...]:
    return equations(rng, 5), *rng.normal(0.0, 1.0, 2).tolist()


def for_solve_ellipse(rng: Rng) -> tuple[Any, ...]:
    return equations(rng, 5), np.zeros(8, np.float32)


def for_take_position(rng: Rng) -> tuple[Any, ...]:
    return equations(rng, 4), *rng.normal(0.0, 1.0, 4).tolist()


def for_solve_positions(rng: Rng) -> tuple[Any, ...]:
    return *(equations(rng, 4) for _ in range(3)), np.zeros(RESULT_SIZE, np.float32)


INPUTS = {
    "firmware.nav.gyro_free.compass_calibration.take_heading": for_take_heading,
    "firmware.nav.gyro_free.compass_calibration.solve_deviation": for_solve_deviation,
    "firmware.nav.gyro_free.compass_calibration.take_field": for_take_field,
    "firmware.nav.gyro_free.compass_calibration.solve_ellipse": for_solve_ellipse,
    "firmware.nav.gyro_free.table_calibration.take_position": for_take_position,
    "firmware.nav.gyro_free.table_calibration.solve_positions": for_solve_positions,
    "firmware.nav.gyro_free.rates.rate_step": for_rate_step,
    "firmware.nav.gyro_free.steps.compass_step": for_compass_step,
    "firmware.nav.gyro_free.steps.gps_step": for_gps_step,
    "firmware.nav.gyro_free.steps.fusion_step": for_fusion_step,
    "firmware.nav.gyro_free.packet_step.packet_step": for_packet_step,
    "firmware.nav.gyro_free.packet_step.epoch_of_packet": for_epoch_of_packet,
    "firmware.nav.gyro_free.packet.open_packet": for_open_packet,
    "firmware.nav.gyro_free.alignment.gather_rest": for_gather_rest,
}
