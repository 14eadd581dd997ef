"""The simulated vehicle of a scenario: its motion, sensors, receivers and truth."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from host.sim.errors.drawn import draw_specimen
from host.sim.errors.inertial_sensor import InertialSensor
from host.sim.errors.presets import load_preset, with_overrides
from host.sim.gnss.receiver import SecondAntenna, SimulatedReceiver
from host.sim.gnss.schedule import Window, window
from host.sim.gnss.tunnels import with_tunnels
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.motion_matrix import segment_of_row
from host.sim.scenario.schema import Scenario, Sway, Vibration
from host.sim.trajectory.antenna import antenna_states
from host.sim.trajectory.disturbance import Coning, Disturbance, Sinusoid, acceleration_band, angle_band
from host.sim.trajectory.kinematics import C_NB, HEIGHT, LATITUDE, LONGITUDE, VELOCITY
from host.sim.trajectory.motion import Motion
from host.sim.trajectory.segments import MotionState, Segment
from host.sim.truth import TruthBatch, euler_angles, unknown_bias

NS = 1_000_000_000
DEG = math.pi / 180.0
SWAY_SINUSOIDS = 6
VIBRATION_SINUSOIDS = 8
DEFAULT_PRESET = "bmi160"
SHORTEST_BASELINE_M = 0.1
Array = NDArray[np.float64]


class SimulatedVehicle:
    """Everything is a function of the scenario and the seed."""

    looks_ahead = True

    def __init__(self, scenario: Scenario, seed: int) -> None:
        self._scenario = scenario
        self._seed = seed
        self.motion = _motion(scenario, seed)
        wanted_s = scenario.duration_s
        self.duration_ns = self.motion.end_ns if wanted_s is None else round(wanted_s * NS)
        self.outages: tuple[Window, ...] = with_tunnels(
            [window(o.start_s, o.duration_s) for o in scenario.outage],
            [tunnel.polygon for tunnel in scenario.tunnel],
            self._places,
            self.duration_ns,
        )
        self.sensors: dict[str, InertialSensor] = {}
        self._receivers: list[SimulatedReceiver] = []

    def imu(self, name: str, mounting: Array, lever_arm: Array, preset: str | None = None) -> InertialSensor:
        """A sensor; `preset` (the board's) counts when the scenario names none."""
        scenario = self._scenario
        base = load_preset(scenario.imu.preset or preset or DEFAULT_PRESET)
        specimen = draw_specimen(with_overrides(base, scenario.imu), self._seed, name)
        sensor = InertialSensor(self.motion, specimen, self._seed, name, mounting, lever_arm)
        self.sensors[name] = sensor
        return sensor

    def gnss(self, name: str, lever_arm: Array, second_lever_arm: Array | None = None) -> SimulatedReceiver:
        """A receiver with its antenna at `lever_arm`, and a second one, if it has two."""
        scenario = self._scenario
        place = scenario.place
        assert place is not None  # the schema asks for it
        lever = np.asarray(lever_arm, dtype=np.float64)

        def antenna(times_ns: NDArray[np.int64]) -> Array:
            return antenna_states(self.motion, times_ns, lever)[:, :6]

        receiver = SimulatedReceiver(
            name,
            scenario.gnss,
            antenna,
            scenario.start.gps_time_ns,
            scenario.start.leap_seconds,
            place.geoid_separation_m,
            self._seed,
            self.outages,
            None if second_lever_arm is None else self._second_antenna(name, lever, second_lever_arm),
        )
        self._receivers.append(receiver)
        return receiver

    def _second_antenna(self, name: str, first: Array, second: Array) -> SecondAntenna:
        arm = np.asarray(second, dtype=np.float64) - first
        length_m = float(np.linalg.norm(arm))
        if length_m < SHORTEST_BASELINE_M:
            raise ScenarioError(
                f"receiver {name}: its antennas are {length_m:g} m apart; at least {SHORTEST_BASELINE_M:g} m,"
                " for example second_antenna_m = [1.0, 0.0, 0.0]"
            )

        def truth(times_ns: NDArray[np.int64]) -> Array:
            c_nb: Array = self.motion.rows(times_ns)[:, C_NB : C_NB + 9].reshape(-1, 3, 3)
            return c_nb @ arm

        return SecondAntenna(truth, length_m)

    def _places(self, times_ns: NDArray[np.int64]) -> tuple[Array, Array]:
        rows = self.motion.rows(times_ns)
        return rows[:, LATITUDE], rows[:, LONGITUDE]

    def put_down(self, time_ns: int, place: tuple[float, float, float]) -> None:
        """From `time_ns` on a vehicle that stands for the whole scenario stands at `place`: latitude,
        longitude in rad, height in m. Raises ScenarioError for one that moves."""
        scenario = self._scenario
        moves = any(segment.kind != "rest" for segment in scenario.segment)
        if moves or scenario.trajectory.matrix is not None or scenario.initial.speed_mps:
            raise ScenarioError(
                f"scenario {scenario.name}: its vehicle moves; only one that stands can be put elsewhere,"
                " for example in the scenario static"
            )
        self.motion.put_down(time_ns, place)
        for receiver in self._receivers:
            receiver.forget_ahead()

    def truth(self, times_ns: NDArray[np.int64], imu: str | None = None) -> TruthBatch:
        """Truth at the vehicle's origin; biases of the sensor `imu`, else of the first one."""
        rows = self.motion.rows(times_ns)
        name = imu or next(iter(self.sensors), None)
        bias_g = bias_a = unknown_bias(len(times_ns))
        if name is not None:
            slow = self.sensors[name].slow_errors(times_ns)
            bias_g, bias_a = slow[:, 0:3], slow[:, 3:6]
        return _batch(times_ns, rows, bias_g, bias_a)

    def antenna_truth(self, times_ns: NDArray[np.int64], lever_arm: Array) -> TruthBatch:
        """Truth at a point of the body; its attitude is the body's."""
        states = antenna_states(self.motion, times_ns, np.asarray(lever_arm, dtype=np.float64))
        return _batch(times_ns, states, unknown_bias(len(times_ns)), unknown_bias(len(times_ns)))


def _batch(times_ns: NDArray[np.int64], rows: Array, bias_g: Array, bias_a: Array) -> TruthBatch:
    yaw, pitch, roll = euler_angles(rows[:, C_NB : C_NB + 9])
    v_ned = rows[:, VELOCITY : VELOCITY + 3].copy()
    return TruthBatch(
        times_ns,
        rows[:, LATITUDE].copy(),
        rows[:, LONGITUDE].copy(),
        rows[:, HEIGHT].copy(),
        v_ned,
        yaw,
        pitch,
        roll,
        bias_g,
        bias_a,
    )


def _motion(scenario: Scenario, seed: int) -> Motion:
    place, initial = scenario.place, scenario.initial
    assert place is not None  # the schema asks for it
    matrix = scenario.trajectory.matrix
    state = MotionState(
        initial.speed_mps, initial.yaw_deg * DEG, initial.pitch_deg * DEG, initial.roll_deg * DEG
    )
    origin = (place.latitude_deg * DEG, place.longitude_deg * DEG, place.height_m)
    try:
        segments: Sequence[Segment] = (
            scenario.segment if matrix is None else [segment_of_row(row) for row in matrix]
        )
        blend = scenario.trajectory.blend_s if matrix is None else 0.0
        return Motion(segments, state, origin, blend, _disturbance(scenario.sway, scenario.vibration, seed))
    except ValueError as error:
        told = str(error) if matrix is None else str(error).replace("segment[", "trajectory.matrix[", 1)
        raise ScenarioError(f"{scenario.path or scenario.name}: {told}") from None


def _disturbance(sway: Sway, vibration: Vibration, seed: int) -> Disturbance:
    sinusoids: list[Sinusoid] = []
    for target, degrees in (("roll", sway.roll_deg), ("pitch", sway.pitch_deg)):
        if degrees > 0.0:
            band = (sway.low_hz, sway.high_hz, SWAY_SINUSOIDS, seed)
            sinusoids += angle_band(target, degrees * DEG, *band)
    for axis, rms in (("x", vibration.x_mps2), ("y", vibration.y_mps2), ("z", vibration.z_mps2)):
        if rms > 0.0:
            shake = (vibration.low_hz, vibration.high_hz, VIBRATION_SINUSOIDS, seed)
            sinusoids += acceleration_band(f"shift_{axis}", rms, *shake)
    return Disturbance(
        tuple(sinusoids),
        Coning(vibration.coning_deg * DEG, vibration.coning_hz),
        vibration.half_speed_mps,
        vibration.always,
    )
