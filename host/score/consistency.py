"""Normalised estimation error squared (NEES): is the filter's covariance honest?

ε = eᵀ P⁻¹ e with e = [δr, δv, φ] (9) has mean 9 when errors are drawn from P (Bar-Shalom, Li, Kirubarajan,
*Estimation with Applications to Tracking and Navigation*, section 5.4). A mean well above 9 says that the
filter is too sure of itself, well below that it is too modest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DIMENSION = 9


def nees(errors: Floats, covariances: Floats) -> Floats:
    """ε of each error row (n, 9) with its covariance (n, 9, 9); NaN where it is not positive definite."""
    found = np.full(len(errors), np.nan)
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    usable = np.isfinite(errors).all(axis=1) & np.isfinite(covariances).all(axis=(1, 2))
    usable &= (variances > 0).all(axis=1)
    scale = np.sqrt(variances[usable])
    found[usable] = _whitened(
        errors[usable] / scale, covariances[usable] / (scale[:, :, None] * scale[:, None])
    )
    return found


def _whitened(errors: Floats, correlations: Floats) -> Floats:
    """ε with correlation matrices, all at once, or one by one where one of them is not positive definite."""
    try:
        factors = np.linalg.cholesky(correlations)
    except np.linalg.LinAlgError:
        if len(errors) == 1:
            return np.array([np.nan])
        pairs = zip(errors[:, None], correlations[:, None], strict=True)
        return np.concatenate([_whitened(error, correlation) for error, correlation in pairs])
    white: Floats = np.linalg.solve(factors, errors[:, :, None])[:, :, 0]
    return np.asarray(np.sum(white * white, axis=1))


def departure(mean: float | None) -> float | None:
    """By which factor a mean NEES is off its expectation 9, whichever way: at least 1."""
    if mean is None or mean <= 0:
        return None
    return max(mean / DIMENSION, DIMENSION / mean)


def from_upper_triangle(values: Floats) -> Floats:
    """The symmetric 9 × 9 matrix of its 45 upper-triangle elements, row by row."""
    matrix = np.empty((DIMENSION, DIMENSION))
    rows, columns = np.triu_indices(DIMENSION)
    matrix[rows, columns] = values
    matrix[columns, rows] = values
    return matrix
