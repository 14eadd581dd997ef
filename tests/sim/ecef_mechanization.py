"""Independent forward mechanization: fourth-order Runge–Kutta in the Earth frame, float64.

    ṙ = v,   v̇ = C_e_b f_b − 2 ω_ie × v + g_e(r),   q̇_eb = ½ q_eb ⊗ (ω_ib − C_b_e ω_ie)

It shares nothing with the simulator, which works with north-east-down velocities and analytic attitude.
"""

import math

import numba
import numpy as np

A, F, W = 6378137.0, 1.0 / 298.257223563, 7.292115e-5
E2 = F * (2.0 - F)
B = A * (1.0 - F)
M_RATIO = W * W * A * A * B / 3.986004418e14


@numba.njit(cache=True)
def geodetic(x, y, z):
    p = math.hypot(x, y)
    lat = math.atan2(z, p * (1.0 - E2))
    n = A
    for _ in range(6):
        s = math.sin(lat)
        n = A / math.sqrt(1.0 - E2 * s * s)
        lat = math.atan2(z + E2 * n * s, p)
    s = math.sin(lat)
    n = A / math.sqrt(1.0 - E2 * s * s)
    return lat, math.atan2(y, x), p * math.cos(lat) + (z + E2 * n * s) * s - n


@numba.njit(cache=True)
def derivative(s, f, w, out):
    x, y, z, vx, vy, vz, q0, q1, q2, q3 = s
    lat, lon, h = geodetic(x, y, z)
    sp2 = math.sin(lat) ** 2
    g0 = (
        9.7803253359 * (1.0 + (B * 9.8321849378 / (A * 9.7803253359) - 1.0) * sp2) / math.sqrt(1.0 - E2 * sp2)
    )
    g = g0 * (1.0 - 2.0 / A * (1.0 + F + M_RATIO - 2.0 * F * sp2) * h + 3.0 * h * h / (A * A))
    r = (
        (1 - 2 * (q2 * q2 + q3 * q3), 2 * (q1 * q2 - q0 * q3), 2 * (q1 * q3 + q0 * q2)),
        (2 * (q1 * q2 + q0 * q3), 1 - 2 * (q1 * q1 + q3 * q3), 2 * (q2 * q3 - q0 * q1)),
        (2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1), 1 - 2 * (q1 * q1 + q2 * q2)),
    )
    up = (math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat))
    cor = (2 * W * vy, -2 * W * vx, 0.0)
    out[0], out[1], out[2] = vx, vy, vz
    for i in range(3):
        out[3 + i] = r[i][0] * f[0] + r[i][1] * f[1] + r[i][2] * f[2] + cor[i] - g * up[i]
    wx = w[0] - r[2][0] * W
    wy = w[1] - r[2][1] * W
    wz = w[2] - r[2][2] * W
    out[6] = 0.5 * (-q1 * wx - q2 * wy - q3 * wz)
    out[7] = 0.5 * (q0 * wx + q2 * wz - q3 * wy)
    out[8] = 0.5 * (q0 * wy + q3 * wx - q1 * wz)
    out[9] = 0.5 * (q0 * wz + q1 * wy - q2 * wx)


@numba.njit(cache=True)
def integrate(state, force, rate, step):
    """State (10,): r_e, v_e, q_eb. Force and rate (2n + 1, 3) at half steps. The state after n steps."""
    s = state.copy()
    k = np.empty((4, 10))
    for i in range((force.shape[0] - 1) // 2):
        derivative(s, force[2 * i], rate[2 * i], k[0])
        derivative(s + 0.5 * step * k[0], force[2 * i + 1], rate[2 * i + 1], k[1])
        derivative(s + 0.5 * step * k[1], force[2 * i + 1], rate[2 * i + 1], k[2])
        derivative(s + step * k[2], force[2 * i + 2], rate[2 * i + 2], k[3])
        s += step / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3])
        s[6:] /= math.sqrt((s[6:] * s[6:]).sum())
    return s


def rotation_ned_to_ecef(lat, lon):
    sp, cp, sl, cl = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    return np.array([[-sp * cl, -sl, -cp * cl], [-sp * sl, cl, -cp * sl], [cp, 0.0, -sp]])


def ecef(lat, lon, h):
    n = A / math.sqrt(1.0 - E2 * math.sin(lat) ** 2)
    r = (n + h) * math.cos(lat)
    return np.array([r * math.cos(lon), r * math.sin(lon), (n * (1.0 - E2) + h) * math.sin(lat)])
