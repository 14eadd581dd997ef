"""python-ins, an independent strapdown library, integrates the simulator's increments back to its truth.

It gets exact increments (Boole's rule on four times finer samples) and, for its simpler height term, the
difference of the two gravity models.
"""

import ecef_mechanization as oracle
import numpy as np
import pytest
from drives import PERFECT, SCENARIOS, SMOOTH

from host.sim.scenario.load import load_scenario
from host.sim.simulated import SimulatedVehicle
from host.simulate.proof.closure import inverse_of
from host.simulate.proof.independent import library_errors
from host.simulate.proof.scenes import scenario_of

pd = pytest.importorskip("pandas")
pytest.importorskip("pyins")
from pyins import earth, strapdown, transform  # noqa: E402
from pyins.util import ACCEL_COLS, GYRO_COLS, LLA_COLS, RPH_COLS, VEL_COLS  # noqa: E402

SECOND = 1_000_000_000
pytestmark = pytest.mark.filterwarnings("ignore:The copy keyword is deprecated")


def pyins_errors(rate_hz, seconds):
    """Errors of python-ins after `seconds`: north, east, up in m."""
    vehicle = SimulatedVehicle(load_scenario(SCENARIOS / "town-open.toml", [*PERFECT, *SMOOTH]), seed=3)
    step = SECOND // rate_hz
    rows = vehicle.motion.rows(np.arange(4 * rate_hz * seconds + 1) * (step // 4))
    lat, height = rows[:, 0], rows[:, 2]
    theirs = earth.gravity(np.degrees(lat), height)
    more = rows[:, 12:15] * (_gravity(lat, height) - theirs)[:, None]
    felt = np.hstack((rows[:, 15:18], rows[:, 18:21] + more))
    boole = 7 * felt[:-1:4] + 32 * felt[1::4] + 12 * felt[2::4] + 32 * felt[3::4] + 7 * felt[4::4]
    increments = np.vstack((boole[:1], boole)) * (step * 1e-9 / 90.0)
    index = np.arange(len(increments)) * step * 1e-9
    imu = pd.DataFrame(increments, columns=GYRO_COLS + ACCEL_COLS, index=index)
    attitude = transform.mat_to_rph(rows[0, 6:15].reshape(3, 3))
    start = np.hstack((np.degrees(rows[0, :2]), rows[0, 2:6], attitude))
    pva = pd.Series(start, index=LLA_COLS + VEL_COLS + RPH_COLS, name=0.0)
    end = (
        strapdown.Integrator(pva).integrate(strapdown.compute_increments_from_imu(imu, "increment")).iloc[-1]
    )
    north, _, parallel = earth.principal_radii(end.lat, end.alt)
    return np.array(
        [
            (np.radians(end.lat) - rows[-1, 0]) * north,
            (np.radians(end.lon) - rows[-1, 1]) * parallel,
            end.alt - rows[-1, 2],
        ]
    )


def _gravity(lat, height):
    """Somigliana's gravity with the height terms of NIMA TR8350.2."""
    s2 = np.sin(lat) ** 2
    g0 = 9.7803253359 * (1.0 + 0.001931852652 * s2) / np.sqrt(1.0 - oracle.E2 * s2)
    x = height / oracle.A
    return g0 * (1.0 - 2.0 * x * (1.0 + oracle.F + oracle.M_RATIO - 2.0 * oracle.F * s2) + 3.0 * x * x)


def test_an_independent_strapdown_library_agrees():
    coarse, fine = pyins_errors(200, 300), pyins_errors(400, 300)
    assert np.linalg.norm(coarse[:2]) < 1e-3
    assert abs(coarse[2]) < 1e-2
    assert np.linalg.norm(coarse[:2]) > 3.0 * np.linalg.norm(fine[:2])


@pytest.mark.soak
def test_python_ins_over_twenty_minutes():
    coarse, fine = pyins_errors(200, 1200), pyins_errors(400, 1200)
    assert np.linalg.norm(coarse[:2]) < 3e-3
    assert abs(coarse[2]) < 1e-2
    assert np.linalg.norm(coarse[:2]) > 3.0 * np.linalg.norm(fine[:2])


def test_it_agrees_with_the_increments_of_the_inverse_too():
    """Of five minutes through town, found by the closed loop from the truth's points alone."""
    scenario = load_scenario(SCENARIOS / "town-open.toml", [*PERFECT, *SMOOTH, "duration_s=300.0"])
    coarse, fine = (library_errors(inverse_of(scenario, rate))[-1] for rate in (200, 400))
    assert np.linalg.norm(coarse[:2]) < 1e-3
    assert abs(coarse[2]) < 1e-2
    assert np.linalg.norm(coarse[:2]) > 3.0 * np.linalg.norm(fine[:2])


@pytest.mark.parametrize("scene", ["ship", pytest.param("aircraft", marks=pytest.mark.soak)])
def test_what_is_left_is_what_python_ins_leaves_out(scene):
    """The third-order term of an interval's turn, and the growth of the Coriolis force within an interval."""
    duration_s = 100.0 if scene == "ship" else 60.0
    plain, supplied = (
        np.linalg.norm(library_errors(inverse_of(scenario_of(scene, duration_s=duration_s), 200), terms)[-1])
        for terms in (False, True)
    )
    assert plain > 1e-4
    assert supplied < 0.1 * plain
