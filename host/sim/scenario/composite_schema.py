"""Composite motions as a scenario file writes them, each one segment.

| kind | motion |
| --- | --- |
| s-curve | a turn by `angle_deg` and one back |
| l-shape | straight on, a turn by `angle_deg` (90), straight on |
| cross | out and back on four arms at right angles |
| figure-eight | a loop to the right, a loop to the left (`first = "left"`: the other way round) |
| rotary-table | standing; through `positions_deg` (yaw, pitch, roll against the beginning) |
| coning | standing or driving; roll and pitch swing a quarter of a period apart |
| sculling | the speed swings, and the pitch with it |
| banked-turn | a turn with the bank at which an aircraft does not slip, tan φ = v ω / g |
| aircraft | from rest: take-off run, climb, cruise, banked turn, cruise, descent, landing run |
| ship | swinging in roll, pitch and yaw |
| shell | from rest: aim, launch, free flight to the height where it began, impact |
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from host.sim.scenario.segment_table import SegmentTable
from host.sim.schema import NotNegative, Positive
from host.sim.trajectory.ballistic import GRAVITY, flight, flight_time
from host.sim.trajectory.course import Course, swinging
from host.sim.trajectory.piece import constant, fall_window, rise_window, wave
from host.sim.trajectory.rates import blended, document_turn
from host.sim.trajectory.segments import SegmentRates

DEG = math.pi / 180.0
STANDSTILL_MPS = 1e-6
ONSET_S = 2.0
"""At most so long does a swinging take to reach its size, and to cease."""

RELEASE_S = 0.2

Turned = Annotated[float, Field(ge=-36_000.0, le=36_000.0)]
Attitude = Annotated[list[Annotated[float, Field(ge=-180.0, le=180.0)]], Field(min_length=3, max_length=3)]

SIX_FACES = [
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 90.0],
    [0.0, 0.0, 180.0],
    [0.0, 0.0, -90.0],
    [0.0, 90.0, 0.0],
    [0.0, -90.0, 0.0],
]


class _Composite(SegmentTable):
    duration_s: Positive = Field(le=1e6, examples=[60.0])


def _must_stand(kind: str, speed: float) -> None:
    if abs(speed) > STANDSTILL_MPS:
        raise ValueError(
            f"kind '{kind}' begins at {speed:.3g} m/s; stop first, for example with "
            '{ kind = "reach-speed", duration_s = 6.0, to_mps = 0.0 }'
        )


class SCurve(_Composite):
    """Two turns."""

    kind: Literal["s-curve"]
    angle_deg: Turned = Field(examples=[60.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """One there, one back."""
        half = 0.5 * self.duration_s
        angle = self.angle_deg * DEG
        return SegmentRates(turn_rate=[*document_turn(half, angle), *document_turn(half, -angle)])


class LShape(_Composite):
    """A corner."""

    kind: Literal["l-shape"]
    angle_deg: Turned = Field(default=90.0, examples=[90.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A third of the time each."""
        third = self.duration_s / 3.0
        straight = constant(third, 0.0)
        return SegmentRates(turn_rate=[straight, *document_turn(third, self.angle_deg * DEG), straight])


class Cross(_Composite):
    """Four arms."""

    kind: Literal["cross"]

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """On each arm: out, about, back, and in the middle a quarter turn to the next one."""
        arm = 0.25 * self.duration_s
        straight, about = constant(0.3 * arm, 0.0), document_turn(0.2 * arm, math.pi)
        quarter = document_turn(0.2 * arm, -0.5 * math.pi)
        return SegmentRates(turn_rate=[straight, *about, straight, *quarter] * 4)


class FigureEight(_Composite):
    """Two loops."""

    kind: Literal["figure-eight"]
    first: Literal["right", "left"] = "right"

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A whole turn each way."""
        half = 0.5 * self.duration_s
        rate = 2.0 * math.pi / half * (1.0 if self.first == "right" else -1.0)
        there, back = (blended(constant(half, sign * rate), blend_s) for sign in (1.0, -1.0))
        return SegmentRates(turn_rate=[*there, *back])


class RotaryTable(SegmentTable):
    """Positions of a rate table."""

    kind: Literal["rotary-table"]
    positions_deg: Annotated[list[Attitude], Field(min_length=1, max_length=1000)] = Field(
        default=SIX_FACES, examples=[[[0.0, 0.0, 0.0], [0.0, 90.0, 0.0]]]
    )
    dwell_s: Positive = Field(default=20.0, le=1e5, examples=[20.0])
    move_s: Positive = Field(default=5.0, le=1e5, examples=[5.0])

    @property
    def duration_s(self) -> float:
        """Of all positions; the table moves into each of them first."""
        return len(self.positions_deg) * (self.move_s + self.dwell_s)

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """ValueError when the vehicle arrives at speed."""
        _must_stand(self.kind, speed)
        course = Course()
        before = [0.0, 0.0, 0.0]
        for position in self.positions_deg:
            yaw, pitch, roll = ((to - at) * DEG for to, at in zip(position, before, strict=True))
            turn = document_turn(self.move_s, yaw)
            course.add(self.move_s, turn_rate=turn, pitch_by=pitch, roll_by=roll)
            course.add(self.dwell_s)
            before = position
        return course.rates(end_speed=0.0)


class ConingSegment(_Composite):
    """Roll and pitch a quarter of a period apart: the axis z goes round a cone, for small angles."""

    kind: Literal["coning"]
    half_angle_deg: float = Field(gt=0.0, le=30.0, examples=[1.0])
    frequency_hz: float = Field(gt=0.0, le=20.0, examples=[2.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Angles that rise to their size smoothly."""
        size = (self.duration_s, self.half_angle_deg * DEG, 1.0 / self.frequency_hz)
        course = Course()
        course.add(
            self.duration_s,
            roll=swinging(*size, 0.0, ONSET_S),
            pitch=swinging(*size, 0.5 * math.pi, ONSET_S),
        )
        return course.rates()


class ScullingSegment(_Composite):
    """Acceleration along x and turning about y in phase: what rectifies into a velocity error."""

    kind: Literal["sculling"]
    amplitude_mps2: float = Field(gt=0.0, le=200.0, examples=[5.0])
    angle_deg: float = Field(gt=0.0, le=30.0, examples=[1.0])
    frequency_hz: float = Field(gt=0.0, le=20.0, examples=[2.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Both as cosines."""
        period = 1.0 / self.frequency_hz
        along = wave(self.duration_s, self.amplitude_mps2, period, 0.5 * math.pi)
        course = Course()
        course.add(
            self.duration_s,
            acceleration=blended(along, max(blend_s, 0.1)),
            pitch=swinging(self.duration_s, self.angle_deg * DEG, period, 0.5 * math.pi, ONSET_S),
        )
        return course.rates()


class BankedTurn(_Composite):
    """A turn of an aircraft."""

    kind: Literal["banked-turn"]
    angle_deg: Turned = Field(examples=[90.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """The bank comes and goes with the turn rate. ValueError for a bank beyond 80°."""
        course = Course()
        add_banked_turn(course, self.duration_s, self.angle_deg * DEG, speed)
        return course.rates()


def add_banked_turn(course: Course, duration_s: float, angle: float, speed: float) -> None:
    """A turn whose rate and bank rise over a quarter of its time and fall over another."""
    flank = 0.25 * duration_s
    rate = angle / (duration_s - flank)
    bank = math.atan(speed * rate / GRAVITY)
    if abs(bank) > 80.0 * DEG:
        raise ValueError(
            f"kind 'banked-turn' at {speed:.3g} m/s needs a bank of {bank / DEG:.0f}°, at most 80; turn"
            f" slower, for example with duration_s = {math.ceil(abs(speed * angle / 0.75 / GRAVITY))}.0"
        )
    plateau = constant(flank, rate)
    rising, falling = plateau.times(rise_window(flank)), plateau.times(fall_window(flank))
    course.add(flank, turn_rate=[rising], roll_by=bank)
    course.add(duration_s - 2.0 * flank, turn_rate=[constant(duration_s - 2.0 * flank, rate)])
    course.add(flank, turn_rate=[falling], roll_by=-bank)


class Aircraft(_Composite):
    """A whole flight."""

    kind: Literal["aircraft"]
    speed_mps: float = Field(default=70.0, gt=1.0, le=300.0, examples=[70.0])
    climb_deg: float = Field(default=6.0, gt=0.0, le=45.0, examples=[6.0])
    turn_deg: Turned = Field(default=180.0, examples=[180.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Shares of the time: run 10 %, climb 20, cruise 10, turn 20, cruise 10, descent 20, run 10."""
        _must_stand(self.kind, speed)
        unit, slope = 0.1 * self.duration_s, self.climb_deg * DEG
        course = Course()

        def run(sign: float) -> None:
            change = constant(unit, sign * self.speed_mps / unit)
            course.add(unit, acceleration=blended(change, max(blend_s, 0.1)))

        def slope_of(sign: float) -> None:
            course.add(0.4 * unit, pitch_by=sign * slope)
            course.add(1.2 * unit)
            course.add(0.4 * unit, pitch_by=-sign * slope)

        run(1.0)
        slope_of(1.0)
        course.add(unit)
        add_banked_turn(course, 2.0 * unit, self.turn_deg * DEG, self.speed_mps)
        course.add(unit)
        slope_of(-1.0)
        run(-1.0)
        return course.rates(end_speed=0.0)


class Ship(_Composite):
    """A ship in a swell. Its path swings with it: it heaves by what the pitch makes of its speed."""

    kind: Literal["ship"]
    roll_deg: NotNegative = Field(default=8.0, le=45.0, examples=[8.0])
    roll_period_s: Positive = Field(default=10.0, le=1e4, examples=[10.0])
    pitch_deg: NotNegative = Field(default=3.0, le=45.0, examples=[3.0])
    pitch_period_s: Positive = Field(default=7.0, le=1e4, examples=[7.0])
    yaw_deg: NotNegative = Field(default=2.0, le=45.0, examples=[2.0])
    yaw_period_s: Positive = Field(default=15.0, le=1e4, examples=[15.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Three swings, which take their time to set in."""
        course, onset = Course(), 2.0 * max(self.roll_period_s, self.pitch_period_s)
        yaw = swinging(self.duration_s, self.yaw_deg * DEG, self.yaw_period_s, 0.0, onset)
        course.add(
            self.duration_s,
            turn_rate=[piece.derivative() for piece in yaw],
            roll=swinging(self.duration_s, self.roll_deg * DEG, self.roll_period_s, 0.0, onset),
            pitch=swinging(self.duration_s, self.pitch_deg * DEG, self.pitch_period_s, 0.0, onset),
        )
        return course.rates()


class Shell(SegmentTable):
    """An artillery shell."""

    kind: Literal["shell"]
    speed_mps: float = Field(default=100.0, ge=10.0, le=1000.0, examples=[100.0])
    elevation_deg: float = Field(default=30.0, ge=1.0, le=85.0, examples=[30.0])
    aim_s: Positive = Field(default=5.0, le=1e4, examples=[5.0])
    launch_s: Positive = Field(default=1.0, le=100.0, examples=[1.0])
    stop_s: Positive = Field(default=1.0, le=100.0, examples=[1.0])
    spin_turns: float = Field(default=0.0, ge=-1000.0, le=1000.0, examples=[10.0])

    @property
    def duration_s(self) -> float:
        """Of all four parts."""
        return self.aim_s + self.launch_s + self._flight_s + self.stop_s + 2.0 * RELEASE_S

    @property
    def _flight_s(self) -> float:
        return flight_time(self.speed_mps, self.elevation_deg * DEG)

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """The barrel is the path. What it bears goes to nothing, and comes back, within RELEASE_S."""
        _must_stand(self.kind, speed)
        elevation, g = self.elevation_deg * DEG, GRAVITY
        falling = -g * math.sin(elevation)
        bending = -g * math.cos(elevation) / self.speed_mps
        muzzle = self.speed_mps - 0.5 * RELEASE_S * falling
        course = Course()
        course.add(self.aim_s, pitch_by=elevation - 0.5 * RELEASE_S * bending)
        push = constant(self.launch_s, muzzle / self.launch_s)
        course.add(self.launch_s, acceleration=blended(push, 0.5 * self.launch_s))
        rise, fall = rise_window(RELEASE_S), fall_window(RELEASE_S)
        bend = constant(RELEASE_S, bending)
        course.add(
            RELEASE_S,
            acceleration=[constant(RELEASE_S, falling).times(rise)],
            pitch=[bend.times(rise).integral(0.0)],
        )
        along, pitch = flight(self.speed_mps, elevation, self._flight_s)
        course.add(self._flight_s, acceleration=along, pitch=pitch, roll_by=2.0 * math.pi * self.spin_turns)
        course.add(
            RELEASE_S,
            acceleration=[constant(RELEASE_S, -falling).times(fall)],
            pitch=[bend.times(fall).integral(0.0)],
        )
        impact = self.speed_mps - 0.5 * RELEASE_S * falling
        course.add(
            self.stop_s,
            acceleration=blended(constant(self.stop_s, -impact / self.stop_s), 0.5 * self.stop_s),
        )
        return course.rates(end_speed=0.0)


CompositeModel = (
    SCurve
    | LShape
    | Cross
    | FigureEight
    | RotaryTable
    | ConingSegment
    | ScullingSegment
    | BankedTurn
    | Aircraft
    | Ship
    | Shell
)
