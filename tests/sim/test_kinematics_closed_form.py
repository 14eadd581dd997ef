"""What perfect sensors feel in motions whose answer is known on paper, to 1e-9 relative."""

import math

import numpy as np
import pytest
from segment import SECOND, Plain, c_nb, motion, row

from host.sim.trajectory.disturbance import Coning, Disturbance, Sinusoid
from host.sim.trajectory.piece import Piece, constant, wave
from host.sim.trajectory.segments import MotionState, SegmentRates

A, F, W = 6378137.0, 1.0 / 298.257223563, 7.292115e-5
E2 = F * (2.0 - F)


def normal_gravity(lat, h):
    """Somigliana with height, written down once more (NIMA TR8350.2)."""
    s2 = math.sin(lat) ** 2
    b = A * (1 - F)
    k = b * 9.8321849378 / (A * 9.7803253359) - 1
    m = W * W * A * A * b / 3.986004418e14
    g0 = 9.7803253359 * (1 + k * s2) / math.sqrt(1 - E2 * s2)
    return g0 * (1 - 2 / A * (1 + F + m - 2 * F * s2) * h + 3 * h * h / A**2)


def test_rest_on_the_turning_earth():
    yaw, pitch, roll, lat = 1.1, 0.2, -0.3, 0.5328
    r = row(motion(state=MotionState(0.0, yaw, pitch, roll), origin=(lat, 2.0, 30.0)), 100.0)
    np.testing.assert_allclose(r[:3], [lat, 2.0, 30.0], rtol=1e-15)
    g = normal_gravity(lat, 30.0)
    np.testing.assert_allclose(
        r[18:21],
        [g * math.sin(pitch), -g * math.cos(pitch) * math.sin(roll), -g * math.cos(pitch) * math.cos(roll)],
        rtol=1e-12,
    )
    earth_n = np.array([W * math.cos(lat), 0.0, -W * math.sin(lat)])
    np.testing.assert_allclose(r[15:18], c_nb(r).T @ earth_n, rtol=1e-12)
    assert np.linalg.norm(r[15:18]) == pytest.approx(W, rel=1e-12)
    assert np.linalg.norm(r[21:24]) < 1e-20


def test_great_circle_along_the_equator():
    v, h = 30.0, 100.0
    m = motion(state=MotionState(v, math.pi / 2), origin=(0.0, 0.3, h))
    r = row(m, 600.0)
    radius = A + h
    assert r[1] - 0.3 == pytest.approx(v * 600.0 / radius, rel=1e-11)
    assert abs(r[0]) < 1e-15
    # f = ω²r of the total rotation against gravitation; gravity holds the Earth's own part
    total = W + v / radius
    expected_up = normal_gravity(0.0, h) - (total**2 - W**2) * radius
    np.testing.assert_allclose(r[20], -expected_up, rtol=1e-11)
    np.testing.assert_allclose(r[15:18] @ c_nb(r).T, [total, 0.0, 0.0], rtol=1e-9, atol=1e-18)


def test_along_a_meridian():
    v, lat0, h = 25.0, 0.6, 50.0
    m = motion(state=MotionState(v, 0.0), origin=(lat0, -1.0, h))
    r = row(m, 900.0)
    radius = A * (1 - E2) / (1 - E2 * math.sin(r[0]) ** 2) ** 1.5 + h
    assert r[16] == pytest.approx(-v / radius, rel=1e-9)
    # going north it comes nearer to the axis: a force to the west holds it back from running ahead eastwards
    assert r[19] == pytest.approx(-2 * W * math.sin(r[0]) * v, rel=1e-9)
    assert r[20] == pytest.approx(-(normal_gravity(r[0], h) - v * v / radius), rel=1e-11)
    # arc length by quadrature of the meridian's radius
    phi = np.linspace(lat0, r[0], 20001)
    arc = np.trapezoid(A * (1 - E2) / (1 - E2 * np.sin(phi) ** 2) ** 1.5 + h, phi)
    assert arc == pytest.approx(v * 900.0, rel=1e-9)


def test_pure_coning():
    alpha, f = math.radians(0.5), 5.0
    shaking = Disturbance(coning=Coning(alpha, f), always=True)
    m = motion(origin=(0.5, 0.1, 0.0), disturbance=shaking)
    earth_n = np.array([W * math.cos(0.5), 0.0, -W * math.sin(0.5)])
    for t in (0.0, 1.237, 77.00123):
        r = row(m, t)
        k = 2 * math.pi * f
        s, c = math.sin(k * t), math.cos(k * t)
        nb = r[15:18] - c_nb(r).T @ earth_n
        expected = [
            -k * math.sin(alpha) * s,
            k * math.sin(alpha) * c,
            -2 * k * math.sin(alpha / 2) ** 2,
        ]
        np.testing.assert_allclose(nb, expected, rtol=0, atol=1e-9 * k * math.sin(alpha))
        axis = c_nb(r)[:, 2]
        assert math.acos(axis[2]) == pytest.approx(alpha, rel=1e-9)


def test_along_a_parallel():
    """Eastwards along a parallel at speed: three rates about the Earth's axis make up what is felt."""
    v, lat, h = 250.0, 0.9, 10_000.0
    turning = Plain(600.0, SegmentRates())
    m = motion([turning], MotionState(v, math.pi / 2), (lat, 0.2, h))
    r = row(m, 0.0)
    n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2) + h
    total = W + v / (n * math.cos(lat))
    # it turns with the ground, and by v / r about the same axis
    axis = np.array([math.cos(lat), 0.0, -math.sin(lat)])
    np.testing.assert_allclose(c_nb(r) @ r[15:18], total * axis, rtol=1e-9, atol=1e-18)
    outwards = (total**2 - W**2) * n * math.cos(lat)
    felt = c_nb(r) @ r[18:21]
    expected = [outwards * math.sin(lat), 0.0, -normal_gravity(lat, h) + outwards * math.cos(lat)]
    np.testing.assert_allclose(felt, expected, rtol=1e-9, atol=1e-9)


def test_pure_sculling():
    """Speed a/Ω sin Ωt along x, pitch b cos Ωt about y, on the equator heading north."""
    a, b, k, h = 5.0, math.radians(2.0), 2 * math.pi * 3.0, 50.0
    swing = Piece(100.0, (0.0,), (0.0,), (b,), k)
    rates = SegmentRates([wave(100.0, a, 2 * math.pi / k, 0.5 * math.pi)], pitch_course=[swing])
    m = motion([Plain(100.0, rates)], MotionState(0.0, 0.0, b), (0.0, 0.0, h))
    for t in (0.0, 1.2345, 61.00017):
        r = row(m, t)
        v, v1 = a / k * math.sin(k * t), a * math.cos(k * t)
        pitch, pitch1 = b + b * math.cos(k * t), -b * k * math.sin(k * t)
        sin, cos = math.sin(pitch), math.cos(pitch)
        lat, alt = r[0], r[2]
        w2 = 1 - E2 * math.sin(lat) ** 2
        meridian = A * (1 - E2) / w2**1.5 + alt
        north, down = v * cos, -v * sin
        # the plane of north and down turns by −v_N / (M + h) about east; the Earth turns about north
        curve = -north / meridian
        force_north = v1 * cos - v * sin * pitch1 - (-curve * down)
        force_down = -(v1 * sin + v * cos * pitch1) - curve * north - normal_gravity(lat, alt)
        expected = [force_north * cos - force_down * sin, force_north * sin + force_down * cos]
        np.testing.assert_allclose([r[18], r[20]], expected, rtol=1e-9)
        np.testing.assert_allclose(r[16], pitch1 + curve, rtol=1e-9)
        # the Earth's turn makes a force to the west or east: 2 ω × v
        assert r[19] == pytest.approx(2 * W * (-math.sin(lat) * north - math.cos(lat) * down), abs=1e-12)


def test_a_circle_gives_centripetal_force_and_its_diameter():
    v, rate = 10.0, 0.2
    circle = Plain(1000.0, SegmentRates(turn_rate=[constant(1000.0, rate)]))
    m = motion([circle], MotionState(v), (0.0, 0.0, 0.0))
    times = np.arange(0, 40 * SECOND, 10_000_000)
    rows = m.rows(times)
    lateral = rows[:, 19]
    assert abs(lateral.mean() - v * rate) < 1e-5
    east = rows[:, 1] * A
    assert east.max() - east.min() == pytest.approx(2 * v / rate, rel=1e-6)


@pytest.mark.parametrize("t", [3.0, 11.7, 40.2])
def test_rates_are_the_derivatives_of_attitude_and_velocity(t):
    """Every shaking at once: numerical derivatives of the truth agree with its analytic rates."""
    shaking = Disturbance(
        tuple(
            Sinusoid(target, size, 1.0 + 0.37 * k, 0.1 * k)
            for k, (target, size) in enumerate(
                [
                    ("roll", 0.02),
                    ("pitch", 0.03),
                    ("yaw", 0.01),
                    ("shift_x", 0.01),
                    ("shift_y", 0.02),
                    ("shift_z", 0.03),
                ]
            )
        ),
        Coning(0.05, 1.3),
    )
    rates = SegmentRates(
        [wave(100.0, 1.0, 9.0, 0.3)], [wave(100.0, 0.3, 7.0, 0.0)], end_pitch=0.3, end_roll=-0.2
    )
    m = motion([Plain(100.0, rates)], MotionState(6.0, 0.5, 0.1, 0.05), disturbance=shaking)
    h = 20_000
    at = round(t * SECOND)
    before, now, after = m.rows(np.array([at - h, at, at + h]))
    slope = (after - before) / (2e-9 * h)
    turn = c_nb(now).T @ slope[6:15].reshape(3, 3)
    lat, alt = now[0], now[2]
    n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
    meridian = n * (1 - E2) / (1 - E2 * math.sin(lat) ** 2) + alt
    en = np.array([now[4] / (n + alt), -now[3] / meridian, -now[4] * math.tan(lat) / (n + alt)])
    ie = np.array([W * math.cos(lat), 0.0, -W * math.sin(lat)])
    expected = np.array([turn[2, 1], turn[0, 2], turn[1, 0]]) + c_nb(now).T @ (ie + en)
    np.testing.assert_allclose(now[15:18], expected, atol=2e-9)
    np.testing.assert_allclose(now[21:24], slope[15:18], atol=2e-8)
    np.testing.assert_allclose(slope[2], -now[5], atol=2e-6)
    f_n = slope[3:6] + np.cross(2 * ie + en, now[3:6]) - [0, 0, normal_gravity(lat, alt)]
    np.testing.assert_allclose(c_nb(now) @ now[18:21], f_n, atol=1e-6)
