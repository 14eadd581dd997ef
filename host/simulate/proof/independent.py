"""The increments of the closed loop through python-ins, a strapdown library that shares nothing with ours.

Samples are the same increments, an interval long. Its gravity is the same at the ellipsoid and has a simpler
term of height: the difference at each true place is added to the increments of velocity, in body axes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.sim.earth import radii_and_gravity
from host.sim.trajectory.kinematics import C_NB, FORCE, HEIGHT, LATITUDE, LONGITUDE, OMEGA_IB
from host.simulate.inverse import Closure, Inverse
from host.simulate.proof.closure import inverse_of
from host.simulate.proof.figure import Figure
from host.simulate.proof.scenes import scenario_of
from host.simulate.stream import Block

Floats = NDArray[np.float64]
JUDGED, TOLD = ("car",), ("car, shaken", "ship", "aircraft")
"""Of the others the figures are those of the library: it knows no term of third order in an interval's turn,
takes the Coriolis force from the interval's beginning, and is left behind by what shakes or swings."""
LIMIT_HORIZONTAL_M, LIMIT_HEIGHT_M, LEAST_FALL = 1e-3, 1e-2, 3.0


def figures() -> Iterator[Figure]:
    """Each scene: RMS over the run at 200 Hz, and how many times less it is at 400 Hz."""
    for name in (*JUDGED, *TOLD):
        coarse, fine = (library_errors(inverse_of(scenario_of(name), rate)) for rate in (200, 400))
        horizontal, finer = (_rms(np.hypot(one[:, 0], one[:, 1])) for one in (coarse, fine))
        words = f"{name}: python-ins"
        judged = name in JUDGED
        most_m, most_up_m, least = (
            (LIMIT_HORIZONTAL_M, LIMIT_HEIGHT_M, LEAST_FALL) if judged else (None, None, None)
        )
        yield Figure("independent", f"{words}, horizontal RMS", "m", horizontal, most=most_m)
        yield Figure("independent", f"{words}, height RMS", "m", _rms(coarse[:, 2]), most=most_up_m)
        yield Figure("independent", f"{words}, fall at 400 Hz", "×", horizontal / finer, least=least)


def library_errors(inverse: Inverse) -> Floats:
    """Errors of python-ins at all instants (n, 3): north, east, up in m."""
    import pandas
    from pyins import earth, strapdown, util

    blocks = list(inverse.blocks(Closure()))
    truth = np.vstack([block.truth for block in blocks])
    step_s = 1.0 / float(inverse.rate_hz)
    increments = _increments(blocks, earth, step_s)
    imu = pandas.DataFrame(
        np.vstack((increments[:1], increments)),
        columns=util.GYRO_COLS + util.ACCEL_COLS,
        index=np.arange(len(increments) + 1) * step_s,
    )
    first = inverse.motion.motion(np.zeros(1))[0]
    angles = np.degrees(first[[8, 7, 6]])
    start = np.hstack((np.degrees(first[:2]), first[2:6], angles))
    columns = util.LLA_COLS + util.VEL_COLS + util.RPH_COLS
    begin = pandas.Series(start, index=columns, name=0.0)
    found = strapdown.Integrator(begin).integrate(strapdown.compute_increments_from_imu(imu, "increment"))
    place = found[util.LLA_COLS].to_numpy()[-len(truth) :]
    north, _, parallel = earth.principal_radii(place[:, 0], place[:, 2])
    return np.column_stack(
        (
            (np.radians(place[:, 0]) - truth[:, LATITUDE]) * north,
            (np.radians(place[:, 1]) - truth[:, LONGITUDE]) * parallel,
            place[:, 2] - truth[:, HEIGHT],
        )
    )


def _increments(blocks: list[Block], earth: Any, step_s: float) -> Floats:
    """Δθ, Δv with the difference of the gravity models in them."""
    truth = np.vstack([block.truth for block in blocks])
    latitude, height = truth[:, LATITUDE], truth[:, HEIGHT]
    pairs = zip(np.sin(latitude).tolist(), height.tolist(), strict=True)
    ours = np.array([radii_and_gravity(sine, h)[2] for sine, h in pairs])
    lacking = (ours - earth.gravity(np.degrees(latitude), height)) * step_s
    down = truth[:, C_NB + 6 : C_NB + 9]
    pushed = truth[:, FORCE : FORCE + 3] + down * lacking[:, None]
    return np.hstack((truth[:, OMEGA_IB : OMEGA_IB + 3], pushed))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
