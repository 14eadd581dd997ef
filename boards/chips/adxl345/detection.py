"""What the acceleration does: taps, activity, inactivity, free-fall, and the flags they leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from boards.chips.adxl345 import detection_kernel as kernel
from boards.chips.adxl345.detection_kernel import detect
from boards.chips.adxl345.register_map import (
    ACT_INACT_CTL,
    ACTIVITY,
    AUTO_SLEEP,
    DETECTED,
    DOUBLE_TAP,
    DUR,
    FREE_FALL,
    INACTIVITY,
    INT_ENABLE,
    LATENT,
    LINK,
    MEASURE,
    POWER_CTL,
    SINGLE_TAP,
    TAP_AXES,
    THRESH_ACT,
    THRESH_FF,
    THRESH_INACT,
    THRESH_TAP,
    TIME_FF,
    TIME_INACT,
    WINDOW,
)
from boards.chips.adxl345.sampler import Sampler

UNDECIMATED = SINGLE_TAP | DOUBLE_TAP | ACTIVITY | FREE_FALL
"""Look at every tick rather than at output samples."""

_G_PER_COUNT = 1.0 / 16.0
"""All thresholds: 62.5 mg."""
_DUR_TICKS, _LATENT_TICKS, _FF_TICKS, _INACT_TICKS = 2, 4, 16, 3200
"""One count of the times: 625 µs, 1.25 ms, 5 ms, 1 s."""

_TAP = frozenset((THRESH_TAP, DUR, LATENT, WINDOW, TAP_AXES))
_FALL = frozenset((THRESH_FF, TIME_FF))
_MOTION = frozenset((THRESH_ACT, THRESH_INACT, TIME_INACT, ACT_INACT_CTL, POWER_CTL))
REGISTERS = _TAP | _FALL | _MOTION | {INT_ENABLE}
"""A write to one of these sets the functions behind it up anew."""


class Detection:
    """The functions as INT_ENABLE and their registers set them up, and how far each has come."""

    def __init__(self, registers: Sequence[int]) -> None:
        self._registers = registers
        self._setup = np.zeros(kernel.SETUP_SIZE, np.int64)
        self._thresholds = np.zeros(4)
        self._state = np.full(kernel.STATE_SIZE, kernel.NEVER, np.int64)
        self._references = np.zeros((2, 3))
        self.enabled = 0
        """The functions at work, as bits of INT_ENABLE."""
        self.reset()

    def reset(self) -> None:
        """As after power-on."""
        self._state[:] = kernel.NEVER
        for index in (kernel.FLAGS, kernel.SOURCES, kernel.TURN, kernel.TAP_PHASE):
            self._state[index] = 0
        self.configure(asleep=False)

    @property
    def flags(self) -> int:
        """The latched bits of INT_SOURCE."""
        return int(self._state[kernel.FLAGS])

    @property
    def sources(self) -> int:
        """The source bits of ACT_TAP_STATUS."""
        return int(self._state[kernel.SOURCES])

    @property
    def rests(self) -> bool:
        """A linked pair has seen inactivity and waits for activity."""
        return bool(self._setup[kernel.LINKED]) and self._state[kernel.TURN] == kernel.ACTIVITY_NEXT

    def clear(self) -> None:
        """INT_SOURCE was read."""
        self._state[kernel.FLAGS] = 0

    # -- set-up ------------------------------------------------------------------------------------

    def configure(self, *, asleep: bool) -> None:
        """Follow the registers. In sleep only activity works."""
        r, setup = self._registers, self._setup
        enabled = r[INT_ENABLE] & DETECTED & (ACTIVITY if asleep else DETECTED)
        if not r[DUR]:
            enabled &= ~(SINGLE_TAP | DOUBLE_TAP)
        power, control = r[POWER_CTL], r[ACT_INACT_CTL]
        if not control & 0x70:
            enabled &= ~ACTIVITY
        if not control & 0x07:
            enabled &= ~INACTIVITY
        self.enabled = enabled
        both = r[INT_ENABLE] & ACTIVITY and r[INT_ENABLE] & INACTIVITY
        sleeps = bool(power & AUTO_SLEEP and r[INT_ENABLE] & INACTIVITY)
        setup[kernel.ENABLED] = enabled
        setup[kernel.LINKED] = bool(power & LINK) and bool(both or sleeps)
        setup[kernel.STOP_AT_TURNS] = sleeps
        setup[kernel.TAP_AXES_AT] = r[TAP_AXES] & 0x07
        setup[kernel.SUPPRESS] = r[TAP_AXES] & 0x08
        setup[kernel.DUR_TICKS] = r[DUR] * _DUR_TICKS
        setup[kernel.LATENT_TICKS] = r[LATENT] * _LATENT_TICKS
        setup[kernel.WINDOW_TICKS] = r[WINDOW] * _LATENT_TICKS
        setup[kernel.ACT_AC], setup[kernel.ACT_AXES] = control & 0x80, control >> 4 & 0x07
        setup[kernel.INACT_AC], setup[kernel.INACT_AXES] = control & 0x08, control & 0x07
        setup[kernel.INACT_TICKS] = r[TIME_INACT] * _INACT_TICKS
        setup[kernel.FF_TICKS] = r[TIME_FF] * _FF_TICKS
        levels = (r[THRESH_TAP], r[THRESH_ACT], r[THRESH_INACT], r[THRESH_FF])
        self._thresholds[:] = np.array(levels) * _G_PER_COUNT
        if not setup[kernel.LINKED]:
            self._state[kernel.TURN] = kernel.ANY
        elif self._state[kernel.TURN] == kernel.ANY:
            self._state[kernel.TURN] = kernel.INACTIVITY_FIRST

    def written(self, register: int, old: int, new: int, *, asleep: bool) -> None:
        """One of `REGISTERS` was written: its functions begin anew; one switched off loses its flag."""
        changed = 0
        if register == INT_ENABLE:
            changed = old ^ new
            self._state[kernel.FLAGS] &= new
        if register in _TAP or changed & (SINGLE_TAP | DOUBLE_TAP):
            self._state[kernel.TAP_PHASE] = kernel.QUIET
        if register in _FALL or changed & FREE_FALL:
            self._state[kernel.FF_SINCE] = kernel.NEVER
        if register == POWER_CTL:
            changed = ACTIVITY | INACTIVITY if (old ^ new) & (LINK | MEASURE) else 0
        elif register in _MOTION:
            changed |= ACTIVITY | INACTIVITY
        if changed & (ACTIVITY | INACTIVITY):
            self._state[kernel.TURN] = kernel.ANY
            self._forget_motion()
        self.configure(asleep=asleep)

    def restart(self, *, asleep: bool) -> None:
        """The ticks begin anew: whatever was under way is forgotten; flags, sources and the turn of a linked
        pair stay."""
        self._state[kernel.TAP_PHASE] = kernel.QUIET
        self._state[kernel.FF_SINCE] = kernel.NEVER
        self._forget_motion()
        self.configure(asleep=asleep)

    def _forget_motion(self) -> None:
        for index in (kernel.INACT_SINCE, kernel.ACT_REFERENCE, kernel.INACT_REFERENCE):
            self._state[index] = kernel.NEVER

    # -- at work -----------------------------------------------------------------------------------

    def run(self, sampler: Sampler, after: int, upto: int) -> int:
        """Work the values in (after, upto] off; returns the tick of the first that changes something, or
        `upto`."""
        return self._run(sampler, after, upto, self._state, self._references)

    def foresee(self, sampler: Sampler, after: int) -> int:
        """Like `run` to the end of the sampler's block, but nothing has happened yet."""
        sampler.cover(after + 1)
        return self._run(sampler, after, sampler.end_tick - 1, self._state.copy(), self._references.copy())

    def _run(
        self,
        sampler: Sampler,
        after: int,
        upto: int,
        state: NDArray[np.int64],
        references: NDArray[np.float64],
    ) -> int:
        plan = sampler.plan
        assert plan is not None
        grid = plan.grid
        while after < upto:
            sampler.cover(after + 1)
            first = max(0, (after - sampler.first_tick) // grid + 1)
            end = min((upto - sampler.first_tick) // grid + 1, len(sampler.g))
            start = sampler.first_tick + first * grid
            rows = np.array((first, max(first, end), start, grid, plan.period), np.int64)
            args = (self._setup, self._thresholds, state, references)
            stop = detect(sampler.g, sampler.filtered, rows, *args)
            if stop < end:
                return sampler.first_tick + int(stop) * grid
            after = min(upto, sampler.end_tick - 1)
        return upto
