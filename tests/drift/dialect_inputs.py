"""Inputs of the drift compensation for the dialect gate: states met while a hand turns it."""

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude import layout as loop
from firmware.nav.attitude.config import AttitudeConfig, configure
from firmware.nav.attitude.loop import iterate, take_rates
from firmware.nav.attitude.profiles import load_loop
from firmware.nav.drift.correction import correct
from firmware.nav.drift.fixed.correction import correct as fixed_correct
from firmware.nav.drift.fixed.fusion import step as fixed_step
from firmware.nav.drift.fixed.settings import new_state as fixed_state
from firmware.nav.drift.fixed.settings import samples as fixed_samples
from firmware.nav.drift.fusion import step
from firmware.nav.drift.settings import DriftSettings, new_state

STEPS = 3000
DT = 0.01


def samples() -> NDArray[np.float32]:
    """30 s: rest, turns about all axes, saturation at 5 rad/s, a magnet, things that are no numbers."""
    rng = np.random.default_rng(5)
    t = np.arange(STEPS) * DT
    moves = (t > 4.0)[:, None]
    rates = moves * 4.0 * np.sin(np.outer(t, [1.3, 2.1, 0.7])) + rng.normal(0, 0.003, (STEPS, 3))
    force = rng.normal(0, 1, (STEPS, 3)) * moves + np.array([0.0, 0.0, -9.81])
    field = rng.normal(0, 0.5, (STEPS, 3)) + np.array([17.0, 0.0, 41.0])
    field[2000:2400] += 20.0
    rows = np.column_stack((np.full(STEPS, DT), rates, force, field))
    rows[500:505, 1] = math.nan
    rows[900, 4:] = math.nan
    rows[1500, 0] = 0.2
    rows[1600, 0] = math.nan
    return rows.astype(np.float32)


@functools.cache
def fed() -> tuple[tuple[Any, ...], ...]:
    """(d, k, sample) every so often, each before its step."""
    d, k = new_state(DriftSettings(rate_range=3.8))
    found = []
    for number, sample in enumerate(samples()):
        if number % 25 == 0 or 498 < number < 508 or number in (900, 1500, 1501, 1600):
            found.append((d.copy(), k.copy(), sample))
        step(d, k, sample)
    return tuple(found)


@functools.cache
def corrected() -> tuple[tuple[Any, ...], ...]:
    """(s, i, d, k) every so often, each before its correction."""
    s, i = np.zeros(loop.S_SIZE, np.float32), np.zeros(loop.I_SIZE, np.int64)
    configure(s, i, AttitudeConfig(latitude=0.9, alignment_time=0.5))
    d, k = new_state(DriftSettings(rate_range=3.8))
    found = []
    rows = np.nan_to_num(samples()[:, 1:])
    rows[:, 6:] *= np.float32(1e-6)
    for number, row in enumerate(np.ascontiguousarray(rows)):
        take_rates(s, i, row)
        if iterate(s, i):
            if number % 24 < 2:
                found.append((s.copy(), i.copy(), d.copy(), k.copy()))
            correct(s, i, d, k)
    return tuple(found)


@functools.cache
def fed_integers() -> tuple[tuple[Any, ...], ...]:
    """(d, k, sample) of the fixed-point filter."""
    d, k = fixed_state(DT, DriftSettings(rate_range=3.8))
    rows = samples()[:, 1:].astype(np.float64)
    rows[:, 6:] *= 1e-6
    found = []
    for number, sample in enumerate(fixed_samples(rows)):
        if number % 25 == 0 or 498 < number < 508 or number in (900, 1500, 1501):
            found.append((d.copy(), k.copy(), sample))
        fixed_step(d, k, sample)
    return tuple(found)


@functools.cache
def corrected_integers() -> tuple[tuple[Any, ...], ...]:
    """(s, i, d, k) of the fixed-point loop and filter."""
    loop_32 = load_loop("fixed")
    s, i, _ = loop_32.new_state(AttitudeConfig(latitude=0.9, alignment_time=0.5))
    d, k = fixed_state(2 * DT * 0.4, DriftSettings(rate_range=3.8))
    rows = np.nan_to_num(samples()[:, 1:].astype(np.float64))
    rows[:, 6:] *= 1e-6
    found = []
    for number, row in enumerate(loop_32.samples(rows)):
        loop_32.take_rates(s, i, row)
        if loop_32.iterate(s, i):
            if number % 24 < 2:
                found.append((s.copy(), i.copy(), d.copy(), k.copy()))
            fixed_correct(s, i, d, k)
    return tuple(found)


def for_fixed_step(rng: np.random.Generator) -> tuple[Any, ...]:
    return fed_integers()[rng.integers(0, len(fed_integers()))]


def for_fixed_correct(rng: np.random.Generator) -> tuple[Any, ...]:
    return corrected_integers()[rng.integers(0, len(corrected_integers()))]


def for_step(rng: np.random.Generator) -> tuple[Any, ...]:
    return fed()[rng.integers(0, len(fed()))]


def for_correct(rng: np.random.Generator) -> tuple[Any, ...]:
    return corrected()[rng.integers(0, len(corrected()))]


INPUTS = {
    "firmware.nav.drift.fusion.step": for_step,
    "firmware.nav.drift.correction.correct": for_correct,
    "firmware.nav.drift.fixed.fusion.step": for_fixed_step,
    "firmware.nav.drift.fixed.correction.correct": for_fixed_correct,
}
