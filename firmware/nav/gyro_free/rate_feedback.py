"""What the filters have found of the rate's error goes back into where the rate is integrated.

The integral of ω̇ drifts without bounds, and the methods that use products take their signs, their fallbacks
and their gates from it. The bias of the master, d, is taken off the integral, and off the biases of all
filters, whichever they are:

    rate ← rate − d        ω = M rate − b        b_i ← b_i − M d

No ω of any filter changes by it. The fused rate is then as uncertain as the master takes its bias for.
"""

from firmware.nav import layout as at
from firmware.nav.covariance import element
from firmware.nav.gyro_free import layout as gl
from firmware.numerics.dialect import kernel


@kernel
def feed_rate_back(g, f1, f2, fm):
    """After a fusion."""
    x = fm[at.GYRO_BIAS]
    y = fm[at.GYRO_BIAS + 1]
    z = fm[at.GYRO_BIAS + 2]
    _take_off(g, gl.INTEGRAL, x, y, z)
    _take_off(g, gl.METHOD_RATE, x, y, z)
    _take_off(g, gl.FUSED, x, y, z)
    m = gl.RATE_MATRIX
    turned_x = g[m] * x + g[m + 1] * y + g[m + 2] * z
    turned_y = g[m + 3] * x + g[m + 4] * y + g[m + 5] * z
    turned_z = g[m + 6] * x + g[m + 7] * y + g[m + 8] * z
    _take_off(g, gl.OMEGA, turned_x, turned_y, turned_z)
    _take_off(f1, at.GYRO_BIAS, turned_x, turned_y, turned_z)
    _take_off(f2, at.GYRO_BIAS, turned_x, turned_y, turned_z)
    _take_off(fm, at.GYRO_BIAS, turned_x, turned_y, turned_z)
    _spread(g, fm, 0, 0)
    _spread(g, fm, 1, 1)
    _spread(g, fm, 2, 2)
    _spread(g, fm, 0, 1)
    _spread(g, fm, 0, 2)
    _spread(g, fm, 1, 2)


@kernel
def _take_off(a, place, x, y, z):
    a[place] -= x
    a[place + 1] -= y
    a[place + 2] -= z


@kernel
def _spread(g, fm, j, k):
    p = element(fm, at.X_GYRO_BIAS + j, at.X_GYRO_BIAS + k)
    g[gl.FUSED_COVARIANCE + 3 * j + k] = p
    g[gl.FUSED_COVARIANCE + 3 * k + j] = p
