"""Normalised estimation error squared (NEES): is the filter's covariance honest?

ε = eᵀ P⁻¹ e with e = [δr, δv, φ] (9) has mean 9 when errors are drawn from P (Bar-Shalom, Li, Kirubarajan,
*Estimation with Applications to Tracking and Navigation*, section 5.4). A mean well above 9 says that the
filter is too sure of itself, well below that it is too modest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

DIMENSION = 9


def nees(errors: NDArray[np.float64], covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """ε of each error row (n, 9) with its covariance (n, 9, 9); NaN where it is not positive definite."""
    found = np.full(len(errors), np.nan)
    for row, (error, covariance) in enumerate(zip(errors, covariances, strict=True)):
        if not (np.all(np.isfinite(error)) and np.all(np.isfinite(covariance))):
            continue
        scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        if np.any(scale == 0):
            continue
        try:
            factor = np.linalg.cholesky(covariance / np.outer(scale, scale))
        except np.linalg.LinAlgError:
            continue
        whitened = np.linalg.solve(factor, error / scale)
        found[row] = whitened @ whitened
    return found


def departure(mean: float | None) -> float | None:
    """By which factor a mean NEES is off its expectation 9, whichever way: at least 1."""
    if mean is None or mean <= 0:
        return None
    return max(mean / DIMENSION, DIMENSION / mean)


def from_upper_triangle(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The symmetric 9 × 9 matrix of its 45 upper-triangle elements, row by row."""
    matrix = np.empty((DIMENSION, DIMENSION))
    rows, columns = np.triu_indices(DIMENSION)
    matrix[rows, columns] = values
    matrix[columns, rows] = values
    return matrix
