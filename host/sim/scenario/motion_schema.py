"""Motion segments as a scenario file writes them; one model per kind (source 002, table 3-1).

| kind | code | motion |
| --- | --- | --- |
| rest, cruise | 1 | standing; straight on at the present speed |
| speed-change | 2 | change the speed by `by_mps` |
| reach-speed | 3 | reach the speed `to_mps` |
| accelerate | 4 | constant acceleration `acceleration_mps2` |
| surge | 5 | sinusoidal acceleration, `amplitude_mps2`, `period_s` |
| acceleration-ramp | 6 | acceleration from `from_mps2` to `to_mps2` on a line |
| turn | 7 | turn by `angle_deg`, right positive |
| circle | 8 | turn at the constant rate `rate_dps` |
| weave | 9 | sinusoidal turn rate, `amplitude_dps`, `period_s` |
| weave-cosine | 91 | the same as a cosine |
| turn-rate-ramp | 10 | turn rate from `from_dps` to `to_dps` on a line |

Every kind takes `duration_s`, and `pitch_to_deg` and `roll_to_deg`: new angles, reached smoothly at the
segment's end; or `pitch_rate_dps` and `roll_rate_dps`: how fast they change, by rate · duration in all.
Turning kinds take `speed_to_mps`: a new speed, reached likewise. Composites: `composite_schema`.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from host.sim.scenario.composite_schema import CompositeModel
from host.sim.scenario.segment_table import SegmentTable
from host.sim.schema import NotNegative, Positive
from host.sim.trajectory.piece import Piece, constant, ramp, wave
from host.sim.trajectory.rates import blended, document_turn, trapezoid
from host.sim.trajectory.segments import SegmentRates

DEG = math.pi / 180.0
STANDSTILL_MPS = 1e-6

ANGLE_BLEND_S = 0.5

Angle = Annotated[float, Field(ge=-89.0, le=89.0)]
AngleRate = Annotated[float, Field(ge=-2000.0, le=2000.0)]


class _Segment(SegmentTable):
    forwards_only: ClassVar[bool] = True
    """Whether a speed that falls below zero on its way is a mistake: a stop that was missed."""

    duration_s: Positive = Field(le=1e6, examples=[20.0])
    pitch_to_deg: Angle | None = Field(default=None, examples=[4.0])
    roll_to_deg: Angle | None = Field(default=None, examples=[2.0])
    pitch_rate_dps: AngleRate | None = Field(default=None, examples=[0.5])
    roll_rate_dps: AngleRate | None = Field(default=None, examples=[-1.0])

    @model_validator(mode="after")
    def _one_way_to_an_angle(self) -> Self:
        for name in ("pitch", "roll"):
            if getattr(self, f"{name}_to_deg") is not None and getattr(self, f"{name}_rate_dps") is not None:
                raise ValueError(f"{name}_to_deg and {name}_rate_dps exclude each other; keep one")
        return self

    def _rates(
        self,
        acceleration: list[Piece] | None = None,
        turn_rate: list[Piece] | None = None,
        end_speed: float | None = None,
    ) -> SegmentRates:
        return SegmentRates(
            acceleration or [],
            turn_rate or [],
            end_speed,
            None if self.pitch_to_deg is None else self.pitch_to_deg * DEG,
            None if self.roll_to_deg is None else self.roll_to_deg * DEG,
            self._at_rate(self.pitch_rate_dps),
            self._at_rate(self.roll_rate_dps),
        )

    def _at_rate(self, rate_dps: float | None) -> list[Piece]:
        """The course of an angle that changes by rate · duration, its rate rising and falling smoothly."""
        if not rate_dps:
            return []
        course, value = [], 0.0
        for part in blended(constant(self.duration_s, rate_dps * DEG), ANGLE_BLEND_S):
            course.append(part.integral(value))
            value = course[-1].value(part.duration_s)
        return course

    def _speed_change(self, change: float, blend_s: float) -> list[Piece]:
        if blend_s > 0.0:
            return blended(constant(self.duration_s, change / self.duration_s), blend_s)
        return trapezoid(self.duration_s, change)


class Rest(_Segment):
    """Standing still."""

    kind: Literal["rest"]

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Nothing moves. ValueError when the vehicle arrives at speed."""
        if abs(speed) > STANDSTILL_MPS:
            raise ValueError(
                f"kind 'rest' begins at {speed:.3g} m/s; stop first, for example with "
                '{ kind = "reach-speed", duration_s = 6.0, to_mps = 0.0 }, or use kind "cruise"'
            )
        return self._rates(end_speed=0.0)


class Cruise(_Segment):
    """Straight on at the present speed."""

    kind: Literal["cruise"]

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Nothing changes."""
        return self._rates()


class SpeedChange(_Segment):
    """Change the speed by an amount."""

    kind: Literal["speed-change"]
    by_mps: float = Field(ge=-1000.0, le=1000.0, examples=[5.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Trapezoidal acceleration."""
        return self._rates(self._speed_change(self.by_mps, blend_s))


class ReachSpeed(_Segment):
    """Reach a speed at the segment's end; a negative one backs."""

    forwards_only: ClassVar[bool] = False  # the speed is named
    kind: Literal["reach-speed"]
    to_mps: float = Field(ge=-1000.0, le=1000.0, examples=[12.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Trapezoidal acceleration."""
        return self._rates(self._speed_change(self.to_mps - speed, blend_s), end_speed=self.to_mps)


class Accelerate(_Segment):
    """Constant acceleration."""

    kind: Literal["accelerate"]
    acceleration_mps2: float = Field(ge=-200.0, le=200.0, examples=[1.5])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A plateau."""
        return self._rates(blended(constant(self.duration_s, self.acceleration_mps2), blend_s))


class Surge(_Segment):
    """Sinusoidal acceleration."""

    forwards_only: ClassVar[bool] = False  # it swings, about standing too
    kind: Literal["surge"]
    amplitude_mps2: float = Field(ge=-200.0, le=200.0, examples=[1.0])
    period_s: Positive = Field(le=1e6, examples=[8.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A sine from zero on."""
        return self._rates(blended(wave(self.duration_s, self.amplitude_mps2, self.period_s, 0.0), blend_s))


class AccelerationRamp(_Segment):
    """Acceleration that changes on a line."""

    kind: Literal["acceleration-ramp"]
    from_mps2: float = Field(ge=-200.0, le=200.0, examples=[0.0])
    to_mps2: float = Field(ge=-200.0, le=200.0, examples=[2.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A ramp."""
        return self._rates(blended(ramp(self.duration_s, self.from_mps2, self.to_mps2), blend_s))


class _Turning(_Segment):
    speed_to_mps: NotNegative | None = Field(default=None, le=1000.0, examples=[5.0])

    def _turning(self, turn_rate: list[Piece], speed: float, blend_s: float) -> SegmentRates:
        if self.speed_to_mps is None:
            return self._rates(turn_rate=turn_rate)
        change = self._speed_change(self.speed_to_mps - speed, blend_s)
        return self._rates(change, turn_rate, self.speed_to_mps)


class Turn(_Turning):
    """Turn by an angle, right positive."""

    kind: Literal["turn"]
    angle_deg: float = Field(ge=-36_000.0, le=36_000.0, examples=[90.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """Five parabolas, smooth in themselves."""
        return self._turning(document_turn(self.duration_s, self.angle_deg * DEG), speed, blend_s)


class Circle(_Turning):
    """Turn at a constant rate."""

    kind: Literal["circle"]
    rate_dps: float = Field(ge=-2000.0, le=2000.0, examples=[10.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A plateau."""
        return self._turning(blended(constant(self.duration_s, self.rate_dps * DEG), blend_s), speed, blend_s)


class Weave(_Turning):
    """Sinusoidal turn rate."""

    kind: Literal["weave", "weave-cosine"]
    amplitude_dps: float = Field(ge=-2000.0, le=2000.0, examples=[10.0])
    period_s: Positive = Field(le=1e6, examples=[6.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A sine or cosine."""
        phase = 0.0 if self.kind == "weave" else 0.5 * math.pi
        profile = wave(self.duration_s, self.amplitude_dps * DEG, self.period_s, phase)
        return self._turning(blended(profile, blend_s), speed, blend_s)


class TurnRateRamp(_Turning):
    """Turn rate that changes on a line."""

    kind: Literal["turn-rate-ramp"]
    from_dps: float = Field(ge=-2000.0, le=2000.0, examples=[0.0])
    to_dps: float = Field(ge=-2000.0, le=2000.0, examples=[15.0])

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """A ramp."""
        profile = ramp(self.duration_s, self.from_dps * DEG, self.to_dps * DEG)
        return self._turning(blended(profile, blend_s), speed, blend_s)


SegmentModel = (
    Rest
    | Cruise
    | SpeedChange
    | ReachSpeed
    | Accelerate
    | Surge
    | AccelerationRamp
    | Turn
    | Circle
    | Weave
    | TurnRateRamp
)
AnySegment = Annotated[SegmentModel | CompositeModel, Field(discriminator="kind")]
