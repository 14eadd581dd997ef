"""Strapdown against closed forms and against pyins, an independent library, without any filter update."""

import math

import numpy as np
import pytest
from nav_run import dcm
from scipy.spatial.transform import Rotation

from firmware.nav import layout as at
from firmware.nav.config import NavConfig, new_state
from firmware.nav.imu import imu_step

pyins_sim = pytest.importorskip("pyins.sim")
pyins_earth = pytest.importorskip("pyins.earth")

NS = 1_000_000_000
EARTH_RATE = 7.292115e-5
UNITS = 2.0**40
FREE = {"constraint": False, "standstill": False}
"""Inertial navigation alone."""


def begun(config: NavConfig, lla, velocity, rph):
    """A state that navigates from (latitude °, longitude °, height), v NED, (roll, pitch, yaw °)."""
    f, i = new_state(config)
    i[at.MODE], i[at.TIME], i[at.HAVE_SAMPLE] = 3, 0, 0
    i[at.GOOD_SAMPLE_TIME] = 0
    i[at.LATITUDE], i[at.LONGITUDE] = (round(math.radians(a) * UNITS) for a in lla[:2])
    f[at.HEIGHT] = lla[2]
    f[at.VELOCITY : at.VELOCITY + 3] = velocity
    roll, pitch, yaw = np.radians(rph)
    q_nb = Rotation.from_euler("ZYX", (yaw, pitch, roll))
    f[at.QUATERNION : at.QUATERNION + 4] = q_nb.as_quat(scalar_first=True)
    f[at.C_N_B : at.C_N_B + 9] = dcm(yaw, pitch, roll).ravel()
    s2 = math.sin(math.radians(lla[0])) ** 2
    w = math.sqrt(1 - 0.00669437999014 * s2)
    m, n = 6378137.0 * (1 - 0.00669437999014) / w**3 + lla[2], 6378137.0 / w + lla[2]
    f[at.EARTH_RATE_N] = EARTH_RATE * math.cos(math.radians(lla[0]))
    f[at.EARTH_RATE_D] = -EARTH_RATE * math.sin(math.radians(lla[0]))
    f[at.PER_MERIDIAN_RADIUS], f[at.PER_NORMAL_RADIUS] = 1 / m, 1 / n
    f[at.TAN_LATITUDE] = math.tan(math.radians(lla[0]))
    f[at.PER_COS_LATITUDE] = 1 / math.cos(math.radians(lla[0]))
    f[at.GRAVITY] = pyins_earth.gravity(lla[0], lla[2])
    return f, i


def drive_samples(f, i, times, rates, forces):
    """All samples through the door, the first at time 0."""
    dt = times[1] - times[0]
    for t, w, a in zip(times.tolist(), rates.tolist(), forces.tolist(), strict=True):
        imu_step(f, i, round(t * NS), dt, *w, *a)


def attitude(f):
    """C_n_b of the state, float64."""
    return f[at.C_N_B : at.C_N_B + 9].astype(float).reshape(3, 3)


def angle_between(a, b):
    """Rotation angle between two attitudes, rad."""
    d = a @ b.T
    return np.linalg.norm([d[2, 1] - d[1, 2], d[0, 2] - d[2, 0], d[1, 0] - d[0, 1]]) / 2


def north(i, latitude_deg):
    """Metres north of a latitude."""
    return (i[at.LATITUDE] - math.radians(latitude_deg) * UNITS) / UNITS * 6.37e6


def test_rests_on_the_turning_earth():
    """At rest the gyros feel the Earth and the accelerometers gravity: nothing moves for a minute."""
    lla, rph = (52.0, 13.0, 100.0), (2.0, -3.0, 75.0)
    f, i = begun(NavConfig(**FREE), lla, (0, 0, 0), rph)
    C = dcm(*np.radians(rph[::-1]))
    rate = C.T @ (EARTH_RATE * np.array([math.cos(math.radians(52)), 0, -math.sin(math.radians(52))]))
    force = C.T @ (0, 0, -float(pyins_earth.gravity(52.0, 100.0)))
    times = np.arange(6001) * 0.01
    drive_samples(f, i, times, np.tile(rate, (6001, 1)), np.tile(force, (6001, 1)))
    assert angle_between(attitude(f), C) < 3e-5  # 6000 roundings of a float32 quaternion, none of them random
    assert np.max(np.abs(f[at.VELOCITY : at.VELOCITY + 3])) < 0.02
    without_earth = EARTH_RATE * 60.0
    assert without_earth > 100 * 3e-5


def test_pure_coning_is_followed():
    """Coning of 1° at 5 Hz, closed form: the compensated rotation stays with it, the plain sum would not."""
    half, freq, seconds = math.radians(1.0), 5.0, 60.0
    omega = 2 * math.pi * freq
    times = np.arange(round(seconds * 100) + 1) * 0.01
    drift = omega * (1 - math.cos(half))
    rates = np.column_stack(
        (
            -omega * math.sin(half) * np.sin(omega * times),
            omega * math.sin(half) * np.cos(omega * times),
            np.full_like(times, -drift),
        )
    )
    f, i = new_state(NavConfig(**FREE))
    i[at.MODE], i[at.GOOD_SAMPLE_TIME], i[at.TIME], i[at.HAVE_SAMPLE] = 3, 0, 0, 0
    f[at.PER_COS_LATITUDE] = 1.0

    def cone(t):
        axis = np.array([math.cos(omega * t), math.sin(omega * t), 0.0])
        return Rotation.from_rotvec(half * axis)

    f[at.QUATERNION : at.QUATERNION + 4] = cone(0.0).as_quat(scalar_first=True)
    f[at.C_N_B : at.C_N_B + 9] = cone(0.0).as_matrix().ravel()
    drive_samples(f, i, times, rates, np.zeros_like(rates))
    error = angle_between(attitude(f), cone(seconds).as_matrix())
    # the trapezoid loses (ωT)²/12 of the amplitude, twice that of the drift: 1.6 %
    assert math.degrees(drift * seconds) > 16.0
    assert error < 0.025 * drift * seconds


def flight(rate_hz, seconds):
    """A turning, climbing, banking drive with its exact samples by pyins."""
    t = np.arange(0, seconds + 0.5 / rate_hz, 1 / rate_hz)
    v = 12.0 + 4.0 * np.sin(0.2 * t)
    yaw = 0.3 * t + 0.4 * np.sin(0.5 * t)
    velocity = np.column_stack((v * np.cos(yaw), v * np.sin(yaw), -1.5 * np.sin(0.3 * t)))
    rph = np.degrees(np.column_stack((0.1 * np.sin(2.0 * t), 0.05 * np.cos(1.3 * t), yaw)))
    return pyins_sim.generate_imu(t, (48.0, 11.0, 500.0), rph, velocity, sensor_type="rate")


def errors_after_flight(two_sample):
    """Position m, velocity m/s, attitude ° after 100 s of lively motion."""
    trajectory, imu = flight(100.0, 100.0)
    start, end = trajectory.iloc[0], trajectory.iloc[-1]
    f, i = begun(
        NavConfig(**FREE, two_sample=two_sample),
        start[["lat", "lon", "alt"]].to_numpy(),
        start[["VN", "VE", "VD"]].to_numpy(),
        start[["roll", "pitch", "heading"]].to_numpy(),
    )
    rates, forces = imu[["gyro_x", "gyro_y", "gyro_z"]], imu[["accel_x", "accel_y", "accel_z"]]
    drive_samples(f, i, trajectory.index.to_numpy(), rates.to_numpy(), forces.to_numpy())
    true = dcm(*np.radians(end[["heading", "pitch", "roll"]].to_numpy()))
    velocity = f[at.VELOCITY : at.VELOCITY + 3] - end[["VN", "VE", "VD"]].to_numpy()
    position = np.hypot(north(i, end.lat), float(f[at.HEIGHT]) - end.alt)
    return position, np.linalg.norm(velocity), math.degrees(angle_between(attitude(f), true))


def test_follows_pyins():
    """Position, velocity and attitude stay with the truth of an independent library."""
    position, velocity, degrees = errors_after_flight(two_sample=True)
    assert position < 0.1
    assert velocity < 0.01
    assert degrees < 0.01


def test_two_samples_beat_one():
    """The one-sample algorithm of the thesis on the same instants is worse by an order of magnitude."""
    _, velocity, degrees = errors_after_flight(two_sample=True)
    _, old_velocity, old_degrees = errors_after_flight(two_sample=False)
    assert old_velocity > 10 * velocity
    assert old_degrees > 10 * degrees
