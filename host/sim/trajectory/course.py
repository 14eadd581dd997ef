"""Motion of a composite, put together stretch by stretch in the order of time.

course = Course()
course.add(10.0)                                                   # as it is
course.add(8.0, turn_rate=document_turn(8.0, angle), roll_by=0.2)  # a turn; 0.2 rad more roll at its end
return course.rates()
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from host.sim.trajectory.piece import Piece, constant, fall_window, rise_window, smooth_step, wave
from host.sim.trajectory.segments import SegmentRates


class Course:
    """Acceleration and turn rate; pitch and roll against those of the beginning (rad)."""

    def __init__(self) -> None:
        self._acceleration: list[Piece] = []
        self._turn_rate: list[Piece] = []
        self._pitch: list[Piece] = []
        self._roll: list[Piece] = []
        self._at = [0.0, 0.0]

    def add(
        self,
        duration_s: float,
        *,
        acceleration: Sequence[Piece] = (),
        turn_rate: Sequence[Piece] = (),
        pitch_by: float = 0.0,
        roll_by: float = 0.0,
        pitch: Sequence[Piece] = (),
        roll: Sequence[Piece] = (),
    ) -> None:
        """A stretch. `pitch` and `roll` are courses of their own against the angle at its beginning."""
        still = [constant(duration_s, 0.0)]
        self._acceleration += acceleration or still
        self._turn_rate += turn_rate or still
        self._lead(0, self._pitch, pitch or [smooth_step(duration_s, 0.0, pitch_by)])
        self._lead(1, self._roll, roll or [smooth_step(duration_s, 0.0, roll_by)])

    def _lead(self, channel: int, pieces: list[Piece], more: Sequence[Piece]) -> None:
        start = self._at[channel]
        pieces += [piece.plus((start,)) for piece in more]
        self._at[channel] = pieces[-1].value(pieces[-1].duration_s)

    def rates(self, end_speed: float | None = None) -> SegmentRates:
        """All of it."""
        return SegmentRates(
            self._acceleration, self._turn_rate, end_speed, pitch_course=self._pitch, roll_course=self._roll
        )


def swinging(
    duration_s: float, amplitude: float, period_s: float, phase: float, onset_s: float
) -> list[Piece]:
    """An angle that swings: amplitude · sin(2π τ / period + phase), which rises and falls smoothly."""
    onset = min(onset_s, 0.5 * duration_s)
    turn = 2.0 * math.pi / period_s
    parts = [
        wave(onset, amplitude, period_s, phase).times(rise_window(onset)),
        wave(duration_s - 2.0 * onset, amplitude, period_s, phase + turn * onset),
        wave(onset, amplitude, period_s, phase + turn * (duration_s - onset)).times(fall_window(onset)),
    ]
    return [part for part in parts if part.duration_s > 0.0]
