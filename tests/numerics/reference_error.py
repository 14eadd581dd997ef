"""Error of float32 results in units in the last place of the exact result; kernels run over whole arrays."""

import numba
import numpy as np


def ulp_error(got, exact):
    """|got − exact| in ulp of float32 at the exact value (subnormal numbers share the smallest ulp)."""
    exact = np.asarray(exact, np.longdouble)
    exponent = np.floor(np.log2(np.maximum(np.abs(exact), np.longdouble(2.0) ** -126)))
    return np.abs(np.asarray(got, np.longdouble) - exact) / np.longdouble(2.0) ** (exponent - 23)


@numba.njit
def map_one(function, x):
    """function(x[i]) for all i."""
    out = np.empty_like(x)
    for i in range(x.size):
        out[i] = function(x[i])
    return out


@numba.njit
def map_two(function, x, y):
    """function(x[i], y[i]) for all i."""
    out = np.empty_like(x)
    for i in range(x.size):
        out[i] = function(x[i], y[i])
    return out
