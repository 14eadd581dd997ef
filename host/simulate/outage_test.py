"""How far a loosely coupled filter drifts without a receiver: outages of equal length along one drive.

source 002, section 4.5. The sensor's errors are those of a preset alone, the receiver's are white: 2 cm and
2 cm/s on every axis at 1 Hz. A drive that is too short is driven again and again. Biases last longer than the
gap between outages, so that those of one drive are alike: only several drives, each with errors of its own,
tell a sensor's drift.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from host.sim.errors.drawn import draw_specimen
from host.sim.errors.presets import load_preset
from host.sim.errors.schema import ImuErrors
from host.sim.gnss.schedule import held
from host.sim.gnss.settings import GnssSettings
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import Scenario
from host.sim.seeding import generator
from host.sim.simulated import SimulatedVehicle
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE, VELOCITY
from host.sim.truth import euler_angles
from host.simulate.attitude_forms import matrices, quaternions
from host.simulate.drift import Drift, Plan
from host.simulate.instants import NS
from host.simulate.loose_filter import Known, LooseFilter, known_of
from host.simulate.stream import IMU, Block, Convention, Drive, Request

Floats = NDArray[np.float64]
Progress = Callable[[float, float], None]

RATE_HZ = 200
GNSS_M, GNSS_MPS = 0.02, 0.02
START_TILT, START_YAW = math.radians(0.1), math.radians(0.5)
EARTH_RADIUS = 6.371e6


def driven(scenario: Scenario, plan: Plan, preset: str) -> Scenario:
    """The scenario as this test wants it. Raises ScenarioError when its motion is impossible."""
    plain = scenario.model_copy(
        update={
            "duration_s": None,
            "imu": ImuErrors(preset=preset),
            "gnss": GnssSettings(
                position_white_m=GNSS_M,
                position_markov_m=0.0,
                vertical_factor=1.0,
                velocity_white_mps=GNSS_MPS,
            ),
            "outage": [],
            "tunnel": [],
            "fault": [],
        }
    )
    wanted_ns = plan.duration_s * NS
    if plain.segment:
        once_ns = SimulatedVehicle(plain, 1).duration_ns
        plain = plain.model_copy(update={"segment": plain.segment * -(-wanted_ns // once_ns)})
        try:
            SimulatedVehicle(plain, 1)
        except ScenarioError:
            raise ScenarioError(
                f"{scenario.path or scenario.name}: lasts {once_ns / NS:g} s, the test {plan.duration_s} s;"
                " to be driven again it must end as it begins, for example at rest: { kind ="
                ' "reach-speed", duration_s = 6.0, to_mps = 0.0 }'
            ) from None
    return plain.model_copy(update={"duration_s": float(plan.duration_s)})


def drift_of(
    scenario: Scenario, plan: Plan, preset: str, seeds: Sequence[int], progress: Progress | None
) -> Drift:
    """Drive along with each of the `seeds`, and measure. Raises ScenarioError."""
    drives = []
    for k, seed in enumerate(seeds):

        def told(done_s: float, all_s: float, k: int = k) -> None:
            if progress is not None:
                progress(k * all_s + done_s, len(seeds) * all_s)

        drives.append(_drive_along(scenario, plan, preset, seed, told))
    tables = np.array(drives)
    return Drift(preset, tuple(seeds), tables[0, :, 0], tables[:, :, 1:7], tables[:, :, 7], plan)


def _drive_along(scenario: Scenario, plan: Plan, preset: str, seed: int, progress: Progress) -> Floats:
    """One drive: rows of time in s, errors (6) and claimed 1 σ."""
    request = Request(
        driven(scenario, plan, preset), seed, Fraction(RATE_HZ), Fraction(1), Convention.INCREMENT
    )
    drive = Drive(request)
    errors = load_preset(preset)
    known = known_of(draw_specimen(errors, seed, IMU), errors)
    windows = plan.windows()
    found: list[list[float]] = []
    tracker: LooseFilter | None = None
    before_ns = 0
    epochs = drive.receiver_epochs()
    next(epochs)
    for block, ends_second in _by_second(drive):
        if tracker is None:
            tracker = _started(known, block.truth[0], seed)
            block, before_ns = _part(block, 1, len(block.times_ns)), int(block.times_ns[0])
        lengths = np.diff(block.times_ns, prepend=before_ns) / NS
        tracker.predict(np.hstack((block.felt[:, 3:6], block.felt[:, :3])), lengths)
        before_ns = int(block.times_ns[-1])
        if not ends_second:
            continue
        claimed = math.sqrt(tracker.covariance[0, 0] + tracker.covariance[1, 1])
        found.append([before_ns / NS, *_errors(tracker.state, block.truth[-1]), claimed])
        time_ns, epoch = next(epochs)
        assert time_ns == before_ns
        if not held(windows, time_ns):
            place = np.array([epoch.latitude, epoch.longitude, epoch.height])
            tracker.update(place, np.array(epoch.velocity_ned), GNSS_M, GNSS_MPS)
        progress(before_ns / NS, plan.duration_s)
    return np.array(found)


def _part(block: Block, first: int, end: int) -> Block:
    return Block(block.times_ns[first:end], block.felt[first:end], block.truth[first:end])


def _by_second(drive: Drive) -> Iterator[tuple[Block, bool]]:
    """The drive's blocks, cut at whole seconds, and whether one ends there."""
    for block in drive.blocks():
        cuts = (np.flatnonzero(block.times_ns % NS == 0) + 1).tolist()
        first = 0
        for cut in [*cuts, len(block.times_ns)]:
            if cut > first:
                yield _part(block, first, cut), cut in cuts
            first = cut


def _started(known: Known, truth: Floats, seed: int) -> LooseFilter:
    """A filter that begins with a wrong attitude, as after an alignment."""
    draws = generator(seed, "outage_test.alignment").standard_normal(3)
    angles = _angles(truth[C_NB : C_NB + 9]) + draws * [START_YAW, START_TILT, START_TILT]
    assert (LATITUDE, LONGITUDE, HEIGHT, VELOCITY) == (0, 1, 2, 3)
    state = np.concatenate((truth[: VELOCITY + 3], quaternions(angles[None])[0]))
    return LooseFilter(known, state, START_TILT, START_YAW)


def _angles(matrix: Floats) -> Floats:
    """Yaw, pitch, roll."""
    return np.array([float(angle[0]) for angle in euler_angles(matrix[None])])


def _errors(state: Floats, truth: Floats) -> list[float]:
    north = (state[0] - truth[LATITUDE]) * EARTH_RADIUS
    east = (state[1] - truth[LONGITUDE]) * EARTH_RADIUS * math.cos(truth[LATITUDE])
    down = truth[HEIGHT] - state[2]
    off = _angles(matrices(state[None, 6:10])[0]) - _angles(truth[C_NB : C_NB + 9])
    yaw, pitch, roll = np.degrees((off + math.pi) % (2.0 * math.pi) - math.pi).tolist()
    return [north, east, down, roll, pitch, yaw]
