"""Coefficients beside the truth, errors that are left, and whether the noise of the sensors explains them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins import calibration as store
from firmware.apps.gfsins.accelerations import NOMINAL_SCALE
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.corrections import WORD
from host.calibrate.operator import ALIGNED_AT, Account
from host.calibrate.table_world import TableWorld
from host.calibrate.true_errors import AXES, NineAxes, directions, shown_headings

Array = NDArray[np.float64]
MG = 9.80665e-3
MOST_SIGMAS = 2.5
"""RMS of errors over their own σ: 1 on the average; few degrees of freedom make it scatter."""
MOST_LEFT = 4.0
"""What is left, over what σ of the coefficients says."""
SECOND_ORDER = 0.25
"""Of σ: products of two small elements."""
ROUNDING_MG = 0.15
"""Whole counts and words, 1 σ."""
HEADING_NOISE_DEG = 0.1
"""Of the mean of a dozen headings in tenths of a degree."""
UNOBSERVABLE = 10.0
WORST_HEADING_DEG, WORST_TILT_DEG = 1.0, 0.1
DIRECTIONS = 500


@dataclass(frozen=True, slots=True)
class Coefficient:
    """One of a procedure."""

    name: str
    found: float
    true: float | None
    sigma: float
    unit: str = ""

    @property
    def sigmas(self) -> float | None:
        """Its error in its own σ."""
        return None if self.true is None or self.sigma <= 0.0 else (self.found - self.true) / self.sigma


@dataclass(frozen=True, slots=True)
class Figure:
    """What was measured, and what it may be at most."""

    name: str
    value: float
    limit: float | None
    unit: str = ""
    before: float | None = None
    """The same without calibration."""

    @property
    def ok(self) -> bool:
        """Whether it is met."""
        return self.limit is None or (math.isfinite(self.value) and self.value <= self.limit)


@dataclass
class Judged:
    """One procedure."""

    account: Account
    coefficients: list[Coefficient] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    headings: tuple[Array, Array, Array] | None = None
    """Of a compass: heading, error before and after, rad."""

    @property
    def met(self) -> bool:
        """All of it."""
        return self.account.done and all(figure.ok for figure in self.figures)


def judge_accelerometers(account: Account, found: Calibration, true: NineAxes, gravity: float) -> Judged:
    """Scales and offsets, and forces in all directions before and after."""
    told = np.array(found.values(store.ACCELEROMETERS)[: store.FORCE_PLACE]).reshape(AXES, 6)
    judged = Judged(account)
    for k in range(AXES):
        own, _, _, offset, sigma_own, sigma_offset = told[k].tolist()
        names = f"A{k + 1} scale", f"A{k + 1} offset"
        judged.coefficients.append(Coefficient(names[0], own, float(true.scales[k]), sigma_own))
        true_mg = float(true.offsets[k]) / MG
        judged.coefficients.append(Coefficient(names[1], offset / MG, true_mg, sigma_offset / MG, "mg"))
    forces = gravity * directions(DIRECTIONS)
    reads = true.reads(forces)
    corrected = corrected_reads(reads, found)
    matrix = np.array(found.values(store.ACCELEROMETERS)[store.FORCE_PLACE :]).reshape(3, 3)
    origin = corrected[:, 6:] @ matrix.T
    wanted = np.tile(forces, 3)
    predicted = math.hypot(_rms(told[:, 5]), _rms(told[:, 4]) * gravity / math.sqrt(3.0)) / MG
    limit = MOST_LEFT * math.hypot(predicted, ROUNDING_MG)
    before, after = _rms(reads[:, 6:] - forces) / MG, _rms(origin - forces) / MG
    judged.figures.append(_in_sigmas(judged.coefficients))
    judged.figures.append(Figure("force at the origin, RMS of all directions", after, limit, "mg", before))
    # one axis each: what a force across it adds cannot be taken off
    along = corrected[:, :6] - true.rows[:6].dot(forces.T).T / true.scales[:6]
    arms = _rms((reads - wanted)[:, :6]) / MG
    judged.figures.append(Figure("arms, beside forces across", _rms(along) / MG, limit, "mg", arms))
    return judged


def corrected_reads(reads: Array, found: Calibration) -> Array:
    """As packets have them, and the DSP after it has taken off what whole words leave."""
    scales = found.corrections.scales / NOMINAL_SCALE
    offsets = found.corrections.offsets * WORD
    remainders = np.array(found.offset_remainders())
    return np.asarray(reads * scales - offsets - remainders)


def judge_rates(account: Account, found: Calibration, true: NineAxes) -> Judged:
    """The matrix of the rates beside what the accelerometers' corrected scales leave of it."""
    values = found.values(store.RATES)
    matrix, sigmas = np.array(values[:9]).reshape(3, 3), np.array(values[12:21]).reshape(3, 3)
    left = true.rate_response(NOMINAL_SCALE / found.corrections.scales)
    wanted = np.linalg.inv(left)
    judged = Judged(account)
    for row in range(3):
        for column in range(3):
            name = f"M {'xyz'[row]}{'xyz'[column]}"
            one = Coefficient(
                name, float(matrix[row, column]), float(wanted[row, column]), float(sigmas[row, column])
            )
            judged.coefficients.append(one)
    used = np.array(found.rate_matrix()).reshape(3, 3)
    turns = directions(DIRECTIONS)
    after = 100.0 * _rms(turns @ (used @ left - np.eye(3)).T) * math.sqrt(3.0)
    before = 100.0 * _rms(turns @ (left - np.eye(3)).T) * math.sqrt(3.0)
    # what was changed may be off by its own uncertainty; what was not is off by what it was
    allowed = np.where(used == np.eye(3), left - np.eye(3), MOST_LEFT * sigmas)
    limit = 100.0 * _rms(np.hypot(allowed, SECOND_ORDER * sigmas)) * math.sqrt(3.0)
    judged.figures.append(_in_sigmas(judged.coefficients))
    judged.figures.append(Figure("rate, RMS of all axes", after, limit, "%", before))
    return judged


def judge_earth_rate(account: Account) -> Judged:
    """It must have been told that it cannot be had."""
    sigma = next(float(line.split()[3]) for line in account.lines if line.startswith("scale"))
    told = "not observable" in account.lines
    judged = Judged(account)
    judged.figures.append(Figure("1 / sigma of the scales", 1.0 / sigma, 1.0 / UNOBSERVABLE))
    judged.figures.append(Figure("kept from the operator", float(not told), 0.0))
    return judged


def judge_compass(account: Account, found: Calibration, world: TableWorld) -> Judged:
    """Deviation on 360 headings before and after."""
    values = found.values(store.DEVIATION)
    coefficients, sigmas = np.array(values[:5]), np.array(values[5:10])
    true, shown = shown_headings(world)
    before = _wrapped(shown - true)
    after = _wrapped(before - _harmonics(shown) @ coefficients)
    best, *_ = np.linalg.lstsq(_harmonics(shown), before, rcond=None)
    unavoidable = _rms(before - _harmonics(shown) @ best)
    judged = Judged(account, headings=(true, before, after))
    for k, letter in enumerate("ABCDE"):
        told = [math.degrees(x) for x in (coefficients[k], best[k], sigmas[k])]
        judged.coefficients.append(Coefficient(letter, told[0], told[1], told[2], "°"))
    noise = math.hypot(math.degrees(_rms(sigmas)) * math.sqrt(3.0), HEADING_NOISE_DEG / math.sqrt(24.0 / 5.0))
    limit = math.hypot(math.degrees(unavoidable), MOST_LEFT * noise)
    residual = math.degrees(_rms(after))
    judged.figures.append(
        Figure("heading, RMS of all headings", residual, limit, "°", math.degrees(_rms(before)))
    )
    return judged


def judge_alignment(account: Account, found: Calibration, is_calibrated: bool) -> Judged:
    """Attitude on the level; tilt is the accelerometers' own, which must be calibrated for it."""
    yaw, pitch, roll = found.values(store.ALIGNMENT)[:3]
    heading = abs(math.degrees(math.remainder(yaw - ALIGNED_AT, 2.0 * math.pi)))
    tilt = math.degrees(max(abs(pitch), abs(roll)))
    judged = Judged(account)
    judged.figures.append(Figure("heading", heading, WORST_HEADING_DEG if is_calibrated else None, "°"))
    judged.figures.append(Figure("tilt", tilt, WORST_TILT_DEG if is_calibrated else None, "°"))
    return judged


def _harmonics(shown: Array) -> Array:
    columns = np.ones(len(shown)), np.sin(shown), np.cos(shown), np.sin(2.0 * shown), np.cos(2.0 * shown)
    return np.column_stack(columns)


def _in_sigmas(coefficients: Sequence[Coefficient]) -> Figure:
    told = [one.sigmas for one in coefficients if one.sigmas is not None]
    return Figure("errors over their sigma, RMS", _rms(np.array(told)), MOST_SIGMAS)


def _wrapped(angle: Array) -> Array:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
