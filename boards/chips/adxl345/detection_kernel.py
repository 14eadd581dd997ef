"""Tap, activity, inactivity and free-fall on the values of a block, compiled (fact sheet section 4).

`detect` works values off one by one and stops after the first that changes what the rest of the chip must
know of: a flag of INT_SOURCE, or, with auto-sleep, a turn between activity and inactivity. All times are
ticks of 312.5 µs. It runs also interpreted (NUMBA_DISABLE_JIT=1) with the same results.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Set-up, int64.
ENABLED, STOP_AT_TURNS, LINKED = 0, 1, 2
TAP_AXES_AT, DUR_TICKS, LATENT_TICKS, WINDOW_TICKS, SUPPRESS = 3, 4, 5, 6, 7
ACT_AXES, ACT_AC, INACT_AXES, INACT_AC, INACT_TICKS, FF_TICKS = 8, 9, 10, 11, 12, 13
SETUP_SIZE = 14
"""ENABLED and FLAGS in the bits of INT_SOURCE; axes: bit 2 X, bit 1 Y, bit 0 Z."""

# Thresholds, float64, g.
TAP_G, ACT_G, INACT_G, FF_G = 0, 1, 2, 3

# State, int64; NEVER where nothing runs.
FLAGS, SOURCES, TURN = 0, 1, 2
TAP_PHASE, TAP_SINCE, TAP_SEEN = 3, 4, 5
INACT_SINCE, FF_SINCE, ACT_REFERENCE, INACT_REFERENCE = 6, 7, 8, 9
STATE_SIZE = 10
NEVER = -1

# TURN: what a linked pair waits for.
ANY, INACTIVITY_FIRST, ACTIVITY_NEXT = 0, 1, 2

# TAP_PHASE.
QUIET, FIRST, LATENCY, SECOND_WINDOW, SECOND, TOO_LONG = 0, 1, 2, 3, 4, 5

_SINGLE, _DOUBLE, _ACTIVITY, _INACTIVITY, _FREE_FALL = 0x40, 0x20, 0x10, 0x08, 0x04


@njit(cache=True, error_model="numpy")
def _above(value: NDArray[np.float64], row: int, axes: int, threshold: float) -> int:
    """Which of the axes are above a threshold, either way."""
    seen = 0
    for axis in range(3):
        bit = 4 >> axis
        if axes & bit and abs(value[row, axis]) > threshold:
            seen |= bit
    return seen


@njit(cache=True, error_model="numpy")
def _differ(
    value: NDArray[np.float64], row: int, axes: int, threshold: float, reference: NDArray[np.float64]
) -> int:
    """Which of the axes differ from a reference by more than a threshold."""
    seen = 0
    for axis in range(3):
        bit = 4 >> axis
        if axes & bit and abs(value[row, axis] - reference[axis]) > threshold:
            seen |= bit
    return seen


@njit(cache=True, error_model="numpy")
def _refer(value: NDArray[np.float64], row: int, reference: NDArray[np.float64]) -> None:
    for axis in range(3):
        reference[axis] = value[row, axis]


@njit(cache=True, error_model="numpy")
def _tap_times(state: NDArray[np.int64], setup: NDArray[np.int64], tick: int, seen: int) -> int:
    """Latency and window of a double tap end; returns what is reported then."""
    phase, passed = state[TAP_PHASE], tick - state[TAP_SINCE]
    if phase == LATENCY and passed >= setup[LATENT_TICKS]:
        if seen:  # already above as the window opens
            state[TAP_PHASE] = TOO_LONG
            return _SINGLE
        state[TAP_PHASE] = SECOND_WINDOW
    elif phase == SECOND_WINDOW and passed >= setup[LATENT_TICKS] + setup[WINDOW_TICKS]:
        state[TAP_PHASE] = FIRST if seen else QUIET
        if seen:
            state[TAP_SINCE], state[TAP_SEEN] = tick, seen
        return _SINGLE
    return 0


@njit(cache=True, error_model="numpy")
def _tap_above(state: NDArray[np.int64], setup: NDArray[np.int64], tick: int, seen: int) -> int:
    """One value above the threshold; returns what is reported with it."""
    phase = state[TAP_PHASE]
    if phase == QUIET:
        state[TAP_PHASE], state[TAP_SINCE], state[TAP_SEEN] = FIRST, tick, seen
    elif phase == SECOND_WINDOW:
        state[TAP_PHASE], state[TAP_SINCE] = SECOND, tick
        state[TAP_SEEN] |= seen
    elif phase == LATENCY:
        if setup[SUPPRESS]:
            state[TAP_PHASE] = TOO_LONG
            return _SINGLE
    elif phase != TOO_LONG:
        state[TAP_SEEN] |= seen
        if tick - state[TAP_SINCE] >= setup[DUR_TICKS]:
            state[TAP_PHASE] = TOO_LONG
            return _SINGLE if phase == SECOND else 0
    return 0


@njit(cache=True, error_model="numpy")
def _tap_below(state: NDArray[np.int64], setup: NDArray[np.int64], tick: int) -> int:
    """One value below the threshold; returns what is reported with it."""
    phase = state[TAP_PHASE]
    if phase not in (FIRST, SECOND, TOO_LONG):
        return 0
    state[TAP_PHASE] = QUIET
    short = phase != TOO_LONG and tick - state[TAP_SINCE] < setup[DUR_TICKS]
    if phase == SECOND:
        return _SINGLE | _DOUBLE if short else _SINGLE
    if not short:
        return 0
    if setup[ENABLED] & _DOUBLE and setup[LATENT_TICKS] and setup[WINDOW_TICKS]:
        state[TAP_PHASE], state[TAP_SINCE] = LATENCY, tick
        return 0
    return _SINGLE


@njit(cache=True, error_model="numpy")
def _tap(state: NDArray[np.int64], setup: NDArray[np.int64], tick: int, seen: int) -> int:
    """One step of the tap machine; returns the flags of what it reports."""
    reported = _tap_times(state, setup, tick, seen)
    if reported:
        return reported
    return _tap_above(state, setup, tick, seen) if seen else _tap_below(state, setup, tick)


@njit(cache=True, error_model="numpy")
def _beyond(
    value: NDArray[np.float64],
    row: int,
    tick: int,
    state: NDArray[np.int64],
    coupling: tuple[int, int, int],
    threshold: float,
    reference: NDArray[np.float64],
) -> int:
    """Which of the axes are beyond a threshold, of activity or inactivity. `coupling`: axes, whether they are
    AC-coupled (then the first value is the reference), where the state tells since when there is one."""
    axes, ac, referred = coupling
    if not ac:
        return _above(value, row, axes, threshold)
    if state[referred] == NEVER:
        _refer(value, row, reference)
        state[referred] = tick
    return _differ(value, row, axes, threshold, reference)


@njit(cache=True, error_model="numpy")
def _still(
    value: NDArray[np.float64],
    row: int,
    tick: int,
    state: NDArray[np.int64],
    setup: NDArray[np.int64],
    threshold: float,
    reference: NDArray[np.float64],
) -> int:
    """One output sample for inactivity: all axes below the threshold for the whole time."""
    coupling = (setup[INACT_AXES], setup[INACT_AC], INACT_REFERENCE)
    if _beyond(value, row, tick, state, coupling, threshold, reference):
        if setup[INACT_AC]:
            _refer(value, row, reference)
        state[INACT_SINCE] = NEVER
        return 0
    if state[INACT_SINCE] == NEVER:
        state[INACT_SINCE] = tick
    if tick - state[INACT_SINCE] < setup[INACT_TICKS]:
        return 0
    state[INACT_SINCE] = NEVER
    return _INACTIVITY


@njit(cache=True, error_model="numpy")
def _moving(
    value: NDArray[np.float64],
    row: int,
    tick: int,
    state: NDArray[np.int64],
    setup: NDArray[np.int64],
    threshold: float,
    reference: NDArray[np.float64],
) -> int:
    """One value for activity: any axis above the threshold. Notes which."""
    coupling = (setup[ACT_AXES], setup[ACT_AC], ACT_REFERENCE)
    moves = _beyond(value, row, tick, state, coupling, threshold, reference)
    if not moves:
        return 0
    state[SOURCES] = (state[SOURCES] & 0x0F) | moves << 4
    return _ACTIVITY


@njit(cache=True, error_model="numpy")
def _falls(
    value: NDArray[np.float64],
    row: int,
    tick: int,
    state: NDArray[np.int64],
    setup: NDArray[np.int64],
    threshold: float,
) -> int:
    """One value for free-fall: all three axes below the threshold for the whole time."""
    for axis in range(3):
        if abs(value[row, axis]) >= threshold:
            state[FF_SINCE] = NEVER
            return 0
    if state[FF_SINCE] == NEVER:
        state[FF_SINCE] = tick
    if tick - state[FF_SINCE] < setup[FF_TICKS]:
        return 0
    state[FF_SINCE] = NEVER
    return _FREE_FALL


@njit(cache=True, error_model="numpy")
def _turns(state: NDArray[np.int64], found: int) -> int:
    """A linked pair goes on to the other one of it, which begins anew."""
    if found & _ACTIVITY and state[TURN] == ACTIVITY_NEXT:
        state[TURN] = INACTIVITY_FIRST
        state[INACT_SINCE] = state[INACT_REFERENCE] = NEVER
        return 1
    if found & _INACTIVITY and state[TURN] == INACTIVITY_FIRST:
        state[TURN] = ACTIVITY_NEXT
        state[ACT_REFERENCE] = NEVER
        return 1
    return 0


@njit(cache=True, error_model="numpy")
def detect(
    g: NDArray[np.float64],
    filtered: NDArray[np.float64],
    rows: NDArray[np.int64],
    setup: NDArray[np.int64],
    thresholds: NDArray[np.float64],
    state: NDArray[np.int64],
    references: NDArray[np.float64],
) -> int:
    """Work values off; returns the row after which to stop, or the end.

    rows: first row, end row, tick of the first row, ticks between rows, ticks between output samples.
    references (2, 3): of activity and inactivity.
    """
    first, end, tick, grid, period = rows[0], rows[1], rows[2], rows[3], rows[4]
    enabled = setup[ENABLED]
    for row in range(first, end):
        found = 0
        if enabled & (_SINGLE | _DOUBLE):
            taps = _tap(state, setup, tick, _above(g, row, setup[TAP_AXES_AT], thresholds[TAP_G]))
            if taps:
                state[SOURCES] = (state[SOURCES] & 0x78) | state[TAP_SEEN]
            found |= taps
        turn = state[TURN]
        if enabled & _ACTIVITY and turn != INACTIVITY_FIRST:
            found |= _moving(g, row, tick, state, setup, thresholds[ACT_G], references[0])
        if enabled & _INACTIVITY and turn != ACTIVITY_NEXT and tick % period == 0:
            found |= _still(filtered, row, tick, state, setup, thresholds[INACT_G], references[1])
        if enabled & _FREE_FALL:
            found |= _falls(g, row, tick, state, setup, thresholds[FF_G])
        tick += grid
        if found:
            fresh = found & enabled & ~state[FLAGS]
            state[FLAGS] |= fresh
            turned = _turns(state, found) if setup[LINKED] else 0
            if fresh or (turned and setup[STOP_AT_TURNS]):
                return row
    return end
