"""What wheels do not do: the non-holonomic constraint of a vehicle, twice a second.

At a point that does not slip (rear axle), the velocity in the vehicle's axes v has no side and no vertical
part. C_v_b is turned from body axes by the mounting yaw α and then pitch β, both states of the filter:

    v_v = C_v_b (C_n_bᵀ v_n + ω × l)        0 = v_v,y + noise        0 = v_v,z + noise

with m the row of C_v_b:  ∂/∂δv = m' C_n_bᵀ,  ∂/∂φ = m' C_n_bᵀ [v×],  ∂/∂α, ∂/∂β from C_v_b. The body velocity
is averaged since the last constraint, so that vibration does not enter. Tyres slip in turns: the noise grows
with the centripetal acceleration. See Dissanayake et al., IEEE Trans. Robotics and Automation 17 (2001).
"""

import numpy as np

from firmware.nav import layout as at
from firmware.nav import tuning as cfg
from firmware.nav.feedback import clear_correction, correction_is_sound, feed_back
from firmware.nav.flags import CONSTRAINED, report
from firmware.nav.measurement import absorb_if_plausible, clear_rows
from firmware.nav.prediction import predict
from firmware.numerics.dialect import kernel
from firmware.numerics.trigonometry import sine_cosine

ZERO = np.float32(0.0)
ONE = np.float32(1.0)


@kernel
def gather_side_speed(f):
    """Add the present velocity in body axes, at the point that does not slip, to its mean."""
    c = at.C_N_B
    vn = f[at.VELOCITY]
    ve = f[at.VELOCITY + 1]
    vd = f[at.VELOCITY + 2]
    wx = f[at.OMEGA_B]
    wy = f[at.OMEGA_B + 1]
    wz = f[at.OMEGA_B + 2]
    lx = f[cfg.AXLE]
    ly = f[cfg.AXLE + 1]
    lz = f[cfg.AXLE + 2]
    f[at.SIDE_SPEED] += f[c] * vn + f[c + 3] * ve + f[c + 6] * vd + wy * lz - wz * ly
    f[at.SIDE_SPEED + 1] += f[c + 1] * vn + f[c + 4] * ve + f[c + 7] * vd + wz * lx - wx * lz
    f[at.SIDE_SPEED + 2] += f[c + 2] * vn + f[c + 5] * ve + f[c + 8] * vd + wx * ly - wy * lx
    f[at.SIDE_SPEED + 3] += ONE


@kernel
def constrain(f, i):
    """Apply the constraint, if the vehicle moves; each of the two rows passes its own gate."""
    count = f[at.SIDE_SPEED + 3]
    per_count = ONE / count if count > ZERO else ZERO
    ux = f[at.SIDE_SPEED] * per_count
    uy = f[at.SIDE_SPEED + 1] * per_count
    uz = f[at.SIDE_SPEED + 2] * per_count
    for k in range(np.int32(4)):
        f[at.SIDE_SPEED + k] = ZERO
    if not abs(ux) > f[cfg.CONSTRAINT_MIN_SPEED]:
        return
    predict(f)
    clear_correction(f)
    clear_rows(f)
    sa, ca = sine_cosine(f[at.MOUNTING])
    sb, cb = sine_cosine(f[at.MOUNTING + 1])
    forward = ca * ux + sa * uy
    slip = f[cfg.CONSTRAINT_TURN] * abs(f[at.OMEGA_B + 2] * ux)
    variance = (f[cfg.CONSTRAINT_NOISE] + slip) * (f[cfg.CONSTRAINT_NOISE] + slip)
    _row(f, 0, -sa, ca, ZERO)
    f[at.ROWS + at.X_MOUNTING] = -forward
    f[at.RESIDUAL] = -(ca * uy - sa * ux)
    f[at.VARIANCE] = variance
    _row(f, 1, sb * ca, sb * sa, cb)
    f[at.ROWS + at.STATES + at.X_MOUNTING] = sb * (ca * uy - sa * ux)
    f[at.ROWS + at.STATES + at.X_MOUNTING + 1] = cb * forward - sb * uz
    f[at.RESIDUAL + 1] = -(sb * forward + cb * uz)
    f[at.VARIANCE + 1] = variance
    side = absorb_if_plausible(f, 0, f[cfg.GATE_1])
    vertical = absorb_if_plausible(f, 1, f[cfg.GATE_1])
    if (side or vertical) and correction_is_sound(f):
        feed_back(f, i)
        report(i, CONSTRAINED)


@kernel
def _row(f, row, mx, my, mz):
    """∂(m' v_b)/∂δv and /∂φ for a row m of C_v_b."""
    c = at.C_N_B
    hx = f[c] * mx + f[c + 1] * my + f[c + 2] * mz
    hy = f[c + 3] * mx + f[c + 4] * my + f[c + 5] * mz
    hz = f[c + 6] * mx + f[c + 7] * my + f[c + 8] * mz
    vn = f[at.VELOCITY]
    ve = f[at.VELOCITY + 1]
    vd = f[at.VELOCITY + 2]
    h = at.ROWS + row * at.STATES
    f[h + at.X_VELOCITY] = hx
    f[h + at.X_VELOCITY + 1] = hy
    f[h + at.X_VELOCITY + 2] = hz
    # m'C'(δv − φ × v) = hδv − φ·(v × h)
    f[h + at.X_ATTITUDE] = hy * vd - hz * ve
    f[h + at.X_ATTITUDE + 1] = hz * vn - hx * vd
    f[h + at.X_ATTITUDE + 2] = hx * ve - hy * vn
