"""Configuration of the attitude reference: which vector, how good, and when it is not believed.

Default errors are those of a two-antenna receiver with a baseline of 2 m.
"""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.nav import layout as at
from firmware.nav import reference_layout as ref

DEG = math.pi / 180.0
Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class AttitudeReference:
    """What measures attitude from outside. Angles in rad, times in s, noise as 1 σ."""

    baseline: Vector = (1.0, 0.0, 0.0)
    """From the main antenna to the second one, body axes, m. Its direction is what heading and pitch belong
    to; its length is what a measured one is compared with."""
    reports_body: bool = False
    """The angles are those of the body: who reports them has taken the direction of the baseline off."""
    length_tolerance: float = 0.05
    """A measured length further from the true one tells a wrong vector."""
    heading_noise: float = 0.08 * DEG
    """White."""
    heading_error_sigma: float = 0.06 * DEG
    """Correlated (first-order Gauss-Markov) …"""
    error_time: float = 60.0
    """… with this correlation time, that of pitch and roll too."""
    tilt_noise: float = 0.136 * DEG
    """White, of pitch and roll."""
    tilt_error_sigma: float = 0.102 * DEG
    first_epochs: int = 3
    """So many headings in a row that agree begin navigation."""
    compass_time: float = 300.0
    """Without a heading for so long at rest, the gyros' own one begins navigation; 0: never."""
    compass_least_time: float = 60.0
    """When the vehicle drives off before, so much of it is enough."""
    rejoin_after: float = 30.0
    """Headings refused in a row for so long may be believed in the end (reference_trust)."""
    small_refusal: float = 2.0 * DEG
    """Refused headings that are off by no more need no witness after ten times as long."""
    lost_after: float = 5.0
    """Without a usable heading for so long, the reference is lost."""


_MAY_BE_ZERO = {"heading_error_sigma", "tilt_error_sigma", "compass_time", "compass_least_time"}


def configure_reference(f: NDArray[Any], i: NDArray[np.int64], reference: AttitudeReference) -> None:
    """Write it behind navigation's arrays. ValueError tells the field, its value and why."""
    _check(reference)
    if len(f) < ref.F_END or len(i) < ref.I_END:
        raise ValueError(
            f"arrays of {len(f)} and {len(i)} places are too short for an attitude reference; "
            f"they need reference_layout.F_END = {ref.F_END} and I_END = {ref.I_END}"
        )
    i[ref.LAST_USED : ref.LAST_USED + ref.ANGLES] = at.NEVER
    i[[ref.REFUSED_SINCE, ref.TIME]] = at.NEVER
    for place, value in _floats(reference).items():
        f[place : place + np.size(value)] = value
    i[ref.FIRST_EPOCHS] = reference.first_epochs
    i[ref.REJOIN_NS] = round(reference.rejoin_after * 1e9)
    i[ref.LOST_NS] = round(reference.lost_after * 1e9)


def _floats(r: AttitudeReference) -> dict[int, Any]:
    return {
        ref.C_B_A: np.eye(3).ravel() if r.reports_body else axes_along(r.baseline).ravel(),
        ref.LENGTH: math.hypot(*r.baseline),
        ref.LENGTH_TOLERANCE: r.length_tolerance,
        ref.WHITE_VARIANCE: (r.heading_noise**2, r.tilt_noise**2, r.tilt_noise**2),
        ref.ERROR_VARIANCE: (r.heading_error_sigma**2, r.tilt_error_sigma**2, r.tilt_error_sigma**2),
        ref.ERROR_MEMORY: 2.0 * r.error_time,
        ref.COMPASS_TIME: r.compass_time,
        ref.COMPASS_LEAST_TIME: r.compass_least_time,
        ref.SMALL_REFUSAL: r.small_refusal,
    }


def axes_along(baseline: Vector) -> NDArray[np.float64]:
    """(3, 3) C_b_a of axes whose x is along the baseline and whose y is level when the body is."""
    x, y, z = np.asarray(baseline) / math.hypot(*baseline)
    level = math.hypot(x, y)
    return np.array([[x, -y / level, -z * x / level], [y, x / level, -z * y / level], [z, 0.0, level]])


def _check(reference: AttitudeReference) -> None:
    for field in fields(reference):
        value = getattr(reference, field.name)
        lowest = 0.0 if field.name in _MAY_BE_ZERO else 1e-12
        if isinstance(value, int | float) and not lowest <= value < math.inf and not isinstance(value, bool):
            raise ValueError(
                f"AttitudeReference.{field.name} = {value} must be finite and "
                f"{'not negative' if not lowest else 'positive'}, like the default {field.default}"
            )
    baseline = reference.baseline
    if len(baseline) != 3 or not all(map(math.isfinite, baseline)) or not math.hypot(*baseline[:2]) > 0.1:
        raise ValueError(
            f"AttitudeReference.baseline = {baseline} must be three finite lengths in m, "
            "at least 0.1 m of it level; a valid one is (2.0, 0.0, 0.0)"
        )
