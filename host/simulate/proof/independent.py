"""The increments of the closed loop through python-ins, a strapdown library that shares nothing with ours.

Samples are the same increments, an interval long. Its gravity is the same at the ellipsoid and has a simpler
term of height: the difference at each true place is added to the increments of velocity, in body axes.

It leaves out two small terms: Δθ × (Δθ × Δv) / 6 of what an interval's turn does to its force, and the growth
of the Coriolis force within an interval. Where a vehicle shakes, swings or is fast, they are what one sees.
That they are all that one sees is measured too: the same run with both supplied (from the increments and the
true motion) must end within the same limits in every scene.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import EARTH_RATE, radii_and_gravity
from host.sim.trajectory.kinematics import C_NB, FORCE, HEIGHT, LATITUDE, LONGITUDE, OMEGA_IB
from host.sim.truth import euler_angles
from host.simulate.attitude_forms import matrices
from host.simulate.inverse import Closure, Inverse
from host.simulate.proof.closure import inverse_of
from host.simulate.proof.figure import Figure
from host.simulate.proof.scenes import scenario_of

Floats = NDArray[np.float64]
PLAIN = "car"
"""Judged as the library is; other scenes are told so, and judged with the terms that it leaves out."""
SCENES = (PLAIN, "basic motion", "car, shaken", "ship", "aircraft")
LIMIT_HORIZONTAL_M, LIMIT_HEIGHT_M, LEAST_FALL = 1e-3, 1e-2, 3.0


def figures() -> Iterator[Figure]:
    """Each scene: RMS over the run at 200 Hz, how many times less at 400 Hz, and with what lacks."""
    for name in SCENES:
        coarse, fine = (library_errors(inverse_of(scenario_of(name), rate)) for rate in (200, 400))
        horizontal, finer = (_rms(np.hypot(one[:, 0], one[:, 1])) for one in (coarse, fine))
        words = f"{name}: python-ins"
        judged = name == PLAIN
        yield from _ends(words, coarse, judged)
        least = LEAST_FALL if judged else None
        yield Figure("independent", f"{words}, fall at 400 Hz", "×", horizontal / finer, least=least)
        supplied = library_errors(inverse_of(scenario_of(name), 200), supplied=True)
        yield from _ends(f"{words}, with the terms it leaves out", supplied, True)


def _ends(words: str, errors: Floats, judged: bool) -> Iterator[Figure]:
    most_m, most_up_m = (LIMIT_HORIZONTAL_M, LIMIT_HEIGHT_M) if judged else (None, None)
    horizontal = _rms(np.hypot(errors[:, 0], errors[:, 1]))
    yield Figure("independent", f"{words}, horizontal RMS", "m", horizontal, most=most_m)
    yield Figure("independent", f"{words}, height RMS", "m", _rms(errors[:, 2]), most=most_up_m)


def library_errors(inverse: Inverse, supplied: bool = False) -> Floats:
    """Errors of python-ins at all instants (n, 3): north, east, up in m; with the terms that it leaves out
    `supplied` or not."""
    import pandas
    from pyins import earth, strapdown, util

    blocks = list(inverse.blocks(Closure()))
    truth = np.vstack([block.truth for block in blocks])
    step_s = 1.0 / float(inverse.rate_hz)
    increments = _increments(truth, earth, step_s)
    first = inverse.motion.states(np.zeros(1))[0]
    if supplied:
        increments[:, 3:] += _coriolis_growth(truth, first, step_s)
    imu = pandas.DataFrame(
        np.vstack((increments[:1], increments)),
        columns=util.GYRO_COLS + util.ACCEL_COLS,
        index=np.arange(len(increments) + 1) * step_s,
    )
    yaw, pitch, roll = (float(angle[0]) for angle in euler_angles(matrices(first[None, 6:])))
    angles = np.degrees([roll, pitch, yaw])
    start = np.hstack((np.degrees(first[:2]), first[2:6], angles))
    columns = util.LLA_COLS + util.VEL_COLS + util.RPH_COLS
    begin = pandas.Series(start, index=columns, name=0.0)
    steps = strapdown.compute_increments_from_imu(imu, "increment")
    if supplied:
        turned, pushed = increments[:, :3], increments[:, 3:]
        steps[["dv_x", "dv_y", "dv_z"]] += np.cross(turned, np.cross(turned, pushed)) / 6.0
    found = strapdown.Integrator(begin).integrate(steps)
    place = found[util.LLA_COLS].to_numpy()[-len(truth) :]
    north, _, parallel = earth.principal_radii(place[:, 0], place[:, 2])
    return np.column_stack(
        (
            (np.radians(place[:, 0]) - truth[:, LATITUDE]) * north,
            (np.radians(place[:, 1]) - truth[:, LONGITUDE]) * parallel,
            place[:, 2] - truth[:, HEIGHT],
        )
    )


def _increments(truth: Floats, earth: Any, step_s: float) -> Floats:
    """Δθ, Δv with the difference of the gravity models in them."""
    latitude, height = truth[:, LATITUDE], truth[:, HEIGHT]
    pairs = zip(np.sin(latitude).tolist(), height.tolist(), strict=True)
    ours = np.array([radii_and_gravity(sine, h)[2] for sine, h in pairs])
    lacking = (ours - earth.gravity(np.degrees(latitude), height)) * step_s
    down = truth[:, C_NB + 6 : C_NB + 9]
    pushed = truth[:, FORCE : FORCE + 3] + down * lacking[:, None]
    return np.hstack((truth[:, OMEGA_IB : OMEGA_IB + 3], pushed))


def _coriolis_growth(truth: Floats, first: Floats, step_s: float) -> Floats:
    """What the Coriolis force halfway through each interval is more than at its beginning, as an increment
    of velocity in body axes (n, 3)."""
    states = np.vstack((first[:6], truth[:, :6]))
    begin, velocity = states[:-1], states[:, 3:6]
    sine, cosine = np.sin(begin[:, 0]), np.cos(begin[:, 0])
    pairs = zip(sine.tolist(), begin[:, 2].tolist(), strict=True)
    meridian, normal = np.array([radii_and_gravity(*pair)[:2] for pair in pairs]).T
    none = np.zeros_like(sine)
    earth_rate = EARTH_RATE * np.column_stack((cosine, none, -sine))

    def force(v: Floats) -> Floats:
        transport = np.column_stack(
            (v[:, 1] / normal, -v[:, 0] / meridian, -v[:, 1] * sine / cosine / normal)
        )
        return -np.cross(2.0 * earth_rate + transport, v)

    grown = force(0.5 * (velocity[1:] + velocity[:-1])) - force(velocity[:-1])
    in_body: Floats = np.einsum("nji,nj->ni", truth[:, C_NB : C_NB + 9].reshape(-1, 3, 3), grown) * step_s
    return in_body


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
