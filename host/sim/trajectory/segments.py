"""From motion segments to the pieces of speed, yaw, pitch and roll.

Each segment tells its acceleration and turn rate; they are integrated one after the other, so that speed and
angles are continuous to rounding whatever the segments do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from host.sim.trajectory.piece import Piece, constant, smooth_step

NS = 1_000_000_000
CHANNELS = ("speed", "yaw", "pitch", "roll")
STANDSTILL_MPS = 1e-6
STEEPEST = 0.5 * math.pi + 1e-9
FASTEST_MPS = 3000.0
STRONGEST_MPS2 = 200_000.0
"""Along the path: what a shell bears in its barrel."""
QUICKEST_DPS = 100_000.0
"""Of each angle: a shell's spin."""
LOOKS = 32
"""Instants of each piece at which a value is looked at."""
CLEARLY = 0.999
"""So much below a limit, no rounding reaches it."""


@dataclass(frozen=True)
class SegmentRates:
    """What one segment does: acceleration in m/s² and turn rate in rad/s (empty: zero), angle targets in rad
    (None: stays)."""

    acceleration: list[Piece] = field(default_factory=list)
    turn_rate: list[Piece] = field(default_factory=list)
    end_speed: float | None = None
    """Set when the end speed is given and not only the integral of the acceleration, m/s."""
    end_pitch: float | None = None
    end_roll: float | None = None
    pitch_course: list[Piece] = field(default_factory=list)
    """Instead of `end_pitch`: the pitch against that of the beginning, rad, over the whole segment."""
    roll_course: list[Piece] = field(default_factory=list)


class Segment(Protocol):
    """A stretch of motion; `blend_s` 0 asks for the document's exact profiles, with steps at the joints."""

    @property
    def duration_s(self) -> float:
        """Length in time, s."""
        ...

    def rates(self, speed: float, blend_s: float) -> SegmentRates:
        """What it does when it starts at `speed` m/s. ValueError when it cannot."""
        ...


@dataclass
class MotionState:
    """Where a segment starts: m/s and rad."""

    speed: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0


@dataclass
class ChannelPieces:
    """The pieces of one channel with their start times in ns."""

    starts_ns: list[int] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)

    def integrate(self, start_ns: int, rates: list[Piece], value: float, duration_s: float) -> float:
        """Append the integral of `rates` from `value` on and return the value that it ends with."""
        pieces = [] if rates else [constant(duration_s, value)]
        for rate in rates:
            piece = rate.integral(value)
            value = piece.value(piece.duration_s)
            pieces.append(piece)
        self._append(start_ns, pieces)
        return value

    def lead(self, start_ns: int, target: float | None, value: float, duration_s: float) -> float:
        """Append the smooth way to `target`, if there is one, and return the value that it ends with."""
        if target is None:
            self._append(start_ns, [constant(duration_s, value)])
            return value
        self._append(start_ns, [smooth_step(duration_s, value, target)])
        return target

    def follow(self, start_ns: int, course: list[Piece], value: float) -> float:
        """Append a course that is given against `value` and return the value that it ends with."""
        pieces = [piece.plus((value,)) for piece in course]
        self._append(start_ns, pieces)
        return pieces[-1].value(pieces[-1].duration_s)

    def _append(self, start_ns: int, pieces: list[Piece]) -> None:
        elapsed_s = 0.0
        for piece in pieces:
            self.starts_ns.append(start_ns + round(elapsed_s * NS))
            self.pieces.append(piece)
            elapsed_s += piece.duration_s


def build_channels(
    segments: Sequence[Segment], initial: MotionState, blend_s: float
) -> tuple[dict[str, ChannelPieces], int]:
    """Pieces of all channels and the end of the last segment in ns; the motion then goes on unchanged."""
    channels = {name: ChannelPieces() for name in CHANNELS}
    state = initial
    start_ns = 0
    for number, segment in enumerate(segments, start=1):
        try:
            state = _append_segment(channels, segment, state, start_ns, blend_s)
        except ValueError as error:
            raise ValueError(f"segment[{number}]: {error}") from None
        start_ns += round(segment.duration_s * NS)
    for name in CHANNELS:
        channels[name].lead(start_ns, None, getattr(state, name), 1.0)
    return channels, start_ns


def _append_segment(
    channels: dict[str, ChannelPieces], segment: Segment, state: MotionState, start_ns: int, blend_s: float
) -> MotionState:
    rates = segment.rates(state.speed, blend_s)
    duration = segment.duration_s
    before = {name: len(channels[name].pieces) for name in CHANNELS}
    speed = channels["speed"].integrate(start_ns, rates.acceleration, state.speed, duration)
    if state.speed >= 0.0 and getattr(segment, "forwards_only", False):
        _refuse_backwards(channels["speed"].pieces[before["speed"] :])
    _refuse_too_fast(channels["speed"].pieces[before["speed"] :])
    after = MotionState(
        speed=speed if rates.end_speed is None else rates.end_speed,
        yaw=channels["yaw"].integrate(start_ns, rates.turn_rate, state.yaw, duration),
        pitch=_angle(channels["pitch"], start_ns, rates.pitch_course, rates.end_pitch, state.pitch, duration),
        roll=_angle(channels["roll"], start_ns, rates.roll_course, rates.end_roll, state.roll, duration),
    )
    if max(abs(state.speed), abs(after.speed)) > STANDSTILL_MPS and abs(after.pitch) > STEEPEST:
        raise ValueError(
            f"brings the pitch to {math.degrees(after.pitch):.4g}°; what moves keeps within ±90°, for example"
            f" pitch_rate_dps = {math.degrees(math.copysign(1.0, after.pitch) - state.pitch) / duration:.3g}"
        )
    for name in CHANNELS:
        _refuse_too_sudden(name, channels[name].pieces[before[name] :], duration)
    return after


def _refuse_backwards(pieces: list[Piece]) -> None:
    """ValueError when the speed falls below zero."""
    lowest = min(_looks(pieces))
    if lowest < -STANDSTILL_MPS:
        raise ValueError(
            f"brings the speed down to {lowest:.4g} m/s; a vehicle stops at 0, for example by"
            ' { kind = "reach-speed", duration_s = 8.0, to_mps = 0.0 }, and backs with to_mps = -2.0'
        )


def _refuse_too_fast(pieces: list[Piece]) -> None:
    """ValueError when the speed grows beyond what is simulated."""
    if _stay_within(pieces, FASTEST_MPS):
        return
    largest = max(map(abs, _looks(pieces)))
    if largest > FASTEST_MPS:
        raise ValueError(
            f"brings the speed to {largest:,.0f} m/s; at most {FASTEST_MPS:,.0f}, for example by"
            ' { kind = "reach-speed", duration_s = 60.0, to_mps = 250.0 }'
        )


def _refuse_too_sudden(name: str, pieces: list[Piece], duration_s: float) -> None:
    """ValueError when the speed or an angle changes faster than anything that flies."""
    changes = [piece.derivative() for piece in pieces]
    most, unit = (STRONGEST_MPS2, "m/s²") if name == "speed" else (QUICKEST_DPS, "°/s")
    if _stay_within(changes, most if name == "speed" else math.radians(most)):
        return
    largest = max(map(abs, _looks(changes)))
    reached = largest if name == "speed" else math.degrees(largest)
    if reached > most:
        raise ValueError(
            f"changes the {name} by {reached:,.0f} {unit}; at most {most:,.0f}: give it more time than"
            f" {duration_s:g} s, for example duration_s = 5.0"
        )


def _stay_within(pieces: list[Piece], most: float) -> bool:
    """Whether that is certain without a look at every piece, which takes a hundred times as long; a bound
    that is not a number is not certain."""
    return all(piece.bound() <= CLEARLY * most for piece in pieces)


def _looks(pieces: list[Piece]) -> Iterator[float]:
    return (piece.value(piece.duration_s * k / LOOKS) for piece in pieces for k in range(LOOKS + 1))


def _angle(
    channel: ChannelPieces,
    start_ns: int,
    course: list[Piece],
    target: float | None,
    value: float,
    duration_s: float,
) -> float:
    """Append what a segment does to pitch or roll and return the angle that it ends with."""
    if course:
        return channel.follow(start_ns, course, value)
    return channel.lead(start_ns, target, value, duration_s)
