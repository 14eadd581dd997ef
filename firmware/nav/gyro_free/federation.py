"""Three filters beside one another: compass, GPS, and the master that fuses them.

Each is an instance of the navigation core with a state of its own, corrected by its own measurements. At a
fusion the master takes the state and covariance of one (the base) and absorbs the others (information):

    P_f = (Σ P_i⁻¹)⁻¹,   x_f = P_f Σ P_i⁻¹ x_i        (Carlson; the document's 3.31)

Then the filters are reset, so that no information counts twice; the process noise is shared likewise, Q/β:

    mode               β master, each sub-filter     sub-filters after the fusion
    no reset           0      1/2                    as they were
    fusion-feedback    0      1/2                    x_f and P_f / β
    zero reset         1      0                      x_f and no information; the master keeps all
    proportional       1/3    1/3                    x_f and P_f / β, the master too

In a zero reset the noise within the second is shared 1/2 : 1/4 : 1/4. A sub-filter that is isolated takes
x_f and P_f at every fusion and gives nothing; the shares of the others grow.
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.covariance import clear
from firmware.nav.feedback import clear_correction, correction_is_sound, feed_back
from firmware.nav.flags import NAVIGATING
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.information import (
    absorb_estimate,
    bound_compass_error,
    copy_covariance,
    drop_private,
    factor_estimate,
    keep_share,
    largest_difference,
)
from firmware.nav.gyro_free.states import ALL, COMMON, COMPASS_ERROR, X_COMPASS_ERROR
from firmware.nav.prediction import predict_with_parameters
from firmware.numerics.dialect import kernel
from firmware.numerics.fixed_position import metres_east, metres_north
from firmware.numerics.quaternion import quaternion_product

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
THIRD = np.float32(1.0 / 3.0)
THREE_F = np.float32(3.0)
FOUR = np.float32(4.0)
THREE = np.int32(3)
SIX = np.int32(6)
MASTER = 2


@kernel
def differ(g, f, i, fm, im):
    """State of `f` less that of `fm` to layout.DIFFERENCE, as an error of `fm`."""
    d = gl.DIFFERENCE
    g[d] = metres_north(i[at.LATITUDE], im[at.LATITUDE], fm[at.MERIDIAN_RADIUS])
    g[d + 1] = metres_east(i[at.LONGITUDE], im[at.LONGITUDE], fm[at.PARALLEL_RADIUS])
    g[d + 2] = (fm[at.HEIGHT] - f[at.HEIGHT]) + (fm[at.HEIGHT_REST] - f[at.HEIGHT_REST])
    for k in range(THREE):
        g[d + at.X_VELOCITY + k] = f[at.VELOCITY + k] - fm[at.VELOCITY + k]
        g[d + X_COMPASS_ERROR + k] = f[COMPASS_ERROR + k] - fm[COMPASS_ERROR + k]
    q = at.QUATERNION
    w, x, y, z = quaternion_product(
        f[q], f[q + 1], f[q + 2], f[q + 3], fm[q], -fm[q + 1], -fm[q + 2], -fm[q + 3]
    )
    twice = TWO if w >= ZERO else -TWO
    g[d + at.X_ATTITUDE] = twice * x
    g[d + at.X_ATTITUDE + 1] = twice * y
    g[d + at.X_ATTITUDE + 2] = twice * z
    for k in range(SIX):
        g[d + at.X_GYRO_BIAS + k] = f[at.GYRO_BIAS + k] - fm[at.GYRO_BIAS + k]


@kernel
def take_state(g, f, i, fm, im):
    """`f` takes the state of `fm`; its history learns it as a correction."""
    differ(g, fm, im, f, i)
    clear_correction(f)
    for j in range(np.int32(ALL)):
        f[at.CORRECTION + j] = g[gl.DIFFERENCE + j]
    feed_back(f, i)
    i[at.MODE] = NAVIGATING


@kernel
def share_noise(g, f, which, share):
    """Process noise of filter `which` becomes `share` times what was configured."""
    ratio = share / g[gl.NOISE_SHARE + which]
    g[gl.NOISE_SHARE + which] = share
    f[cfg.ANGLE_WALK_VARIANCE] *= ratio
    f[cfg.VELOCITY_WALK_VARIANCE] *= ratio
    f[cfg.POSITION_WALK_VARIANCE] *= ratio
    f[cfg.GYRO_BIAS_WALK_VARIANCE] *= ratio
    f[cfg.ACCEL_BIAS_WALK_VARIANCE] *= ratio


@kernel
def measure_differences(g, n, f1, i1, f2, i2, fm, im):
    """How far each sub-filter is from the master, before they are fused: layout.WORST. After a zero reset the
    compass filter knows attitude only together with the error of the compass, which the master holds then."""
    states = ALL if n[gl.MODE] == gl.ZERO_RESET else COMMON
    differ(g, f1, i1, fm, im)
    factor_estimate(g, f1, states)
    g[gl.WORST] = largest_difference(g, fm, states)
    differ(g, f2, i2, fm, im)
    factor_estimate(g, f2, COMMON)
    g[gl.WORST + 1] = largest_difference(g, fm, COMMON)


@kernel
def fuse_filters(g, n, f1, i1, f2, i2, fm, im):
    """The master becomes the fusion of what is trusted; False when there is nothing, or no numbers."""
    compass = n[gl.STATUS + gl.COMPASS] == gl.TRUSTED
    gps = n[gl.STATUS + gl.GPS] == gl.TRUSTED
    if n[gl.MODE] == gl.ZERO_RESET:
        clear_correction(fm)
        if compass:
            _absorb(g, f1, i1, fm, im, ALL)
        if gps:
            _absorb(g, f2, i2, fm, im, COMMON)
        return _correct(fm, im)
    if not compass and not gps:
        return False
    if n[gl.MODE] == gl.PROPORTIONAL:
        return _fuse_onto_master(g, f1, i1, f2, i2, fm, im, compass, gps)
    if compass:
        take_state(g, fm, im, f1, i1)
        copy_covariance(f1, fm)
        clear_correction(fm)
        if gps:
            _absorb(g, f2, i2, fm, im, COMMON)
        return _correct(fm, im)
    take_state(g, fm, im, f2, i2)
    copy_covariance(f2, fm)
    return True


@kernel
def _fuse_onto_master(g, f1, i1, f2, i2, fm, im, compass, gps):
    """The master holds information of its own on the common states; that is absorbed as well."""
    if not compass:
        clear_correction(fm)
        _absorb(g, f2, i2, fm, im, COMMON)
        return _correct(fm, im)
    differ(g, fm, im, f1, i1)
    factor_estimate(g, fm, COMMON)
    copy_covariance(f1, fm)
    clear_correction(fm)
    absorb_estimate(g, fm, COMMON)
    # counted from the state of f1 so far; the master's own is DIFFERENCE away from it
    for j in range(np.int32(ALL)):
        fm[at.CORRECTION + j] -= g[gl.DIFFERENCE + j]
    if gps:
        _absorb(g, f2, i2, fm, im, COMMON)
    return _correct(fm, im)


@kernel
def _absorb(g, f, i, fm, im, states):
    differ(g, f, i, fm, im)
    factor_estimate(g, f, states)
    absorb_estimate(g, fm, states)


@kernel
def _correct(fm, im):
    if not correction_is_sound(fm):
        return False
    feed_back(fm, im)
    return True


@kernel
def reset_filters(g, n, f1, i1, f2, i2, fm, im, recovered):
    """After a fusion: share the information as the mode has it. Once a filter has `recovered`, all begin anew
    from the global estimate, even without resets."""
    trusted = ZERO
    if n[gl.STATUS + gl.COMPASS] == gl.TRUSTED:
        trusted += ONE
    if n[gl.STATUS + gl.GPS] == gl.TRUSTED:
        trusted += ONE
    share = ONE
    if n[gl.MODE] == gl.PROPORTIONAL:
        share = ONE / (trusted + ONE)
    elif trusted > ONE:
        share = HALF
    stay = n[gl.MODE] == gl.NO_RESET and not recovered
    _reset(g, n, f1, i1, fm, im, gl.COMPASS, share, stay)
    _reset(g, n, f2, i2, fm, im, gl.GPS, share, stay)
    if n[gl.MODE] == gl.ZERO_RESET:
        share_noise(g, fm, MASTER, TWO)
    elif n[gl.MODE] == gl.PROPORTIONAL:
        drop_private(g, fm)
        keep_share(g, fm, share)
        share_noise(g, fm, MASTER, ONE / share)


@kernel
def _reset(g, n, f, i, fm, im, which, share, stay):
    trusted = n[gl.STATUS + which] == gl.TRUSTED
    if trusted and stay:
        return
    private = f[cfg.POSITION_ERROR_VARIANCE_H] > ZERO
    take_state(g, f, i, fm, im)
    if trusted and n[gl.MODE] == gl.ZERO_RESET:
        know_nothing(g, f, private)
        share_noise(g, f, which, FOUR)
        return
    copy_covariance(fm, f)
    if not private:
        drop_private(g, f)
    elif not trusted:
        drop_private(g, f)
        forget_compass(g, f)
    if trusted:
        keep_share(g, f, share)
        share_noise(g, f, which, ONE / share)
        if private:
            bound_compass_error(g, f, i)


@kernel
def know_nothing(g, f, private):
    """No information on any state."""
    clear(f)
    v = gl.NO_INFORMATION
    for k in range(THREE):
        f[at.D + at.X_POSITION + k] = g[v]
        f[at.D + at.X_VELOCITY + k] = g[v + 1]
        f[at.D + at.X_ATTITUDE + k] = g[v + 2]
        f[at.D + at.X_GYRO_BIAS + k] = g[v + 3]
        f[at.D + at.X_ACCEL_BIAS + k] = g[v + 4]
        if private:
            f[at.D + X_COMPASS_ERROR + k] = g[v + 5]


@kernel
def forget_compass(g, f):
    """The error of the compass is unknown again, within what it may be."""
    for k in range(THREE):
        f[COMPASS_ERROR + k] = ZERO
        f[at.D + X_COMPASS_ERROR + k] = g[gl.COMPASS_ERROR_VARIANCE + (1 if k == 2 else 0)]


@kernel
def predict_all(f1, f2, fm):
    """Bring all covariances to now, that of the biases too: noise that one filter has by a fusion and the
    other gets behind it would be lost between them."""
    predict_with_parameters(f1)
    predict_with_parameters(f2)
    predict_with_parameters(fm)
