"""One packet of the acquisition processor: its nine accelerations to the filters, and what else is in it.

`felt` chooses the feed. felt[0] = 0: `adxl345`, rate and force from the nine accelerometers of the packet.
felt[0] = 1: `equivalent`, ω and f_b from felt[1:7] (rad/s, m/s²); the accelerometers are still resolved, so
that the work is the same, and not used. A chip that is missing or stuck makes the sample none: nine axes have
no redundancy.
"""

import numpy as np

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.packet import signed, signed_32, signed_64, tick_time
from firmware.nav.gyro_free.rates import rate_step
from firmware.nav.history import seconds_between
from firmware.nav.imu import imu_step
from firmware.numerics.dialect import kernel

NAN = np.float32(np.nan)
ZERO = np.float32(0.0)
AGE_NS = np.int64(100_000)
NINE = np.int32(9)
USED = 1
COMPASS_DUE = 2
GPS_DUE = 4
FUSION_DUE = 8


@kernel(
    "int64(float32[::1], int64[::1], int64[::1], float32[::1], float32[::1], int64[::1],"
    " float32[::1], int64[::1], float32[::1], int64[::1])"
)
def packet_step(g, n, words, felt, f1, i1, f2, i2, fm, im):
    """The sample in the words of a good packet to all filters. Returns 1 when it was used, plus what is due
    now: 2 its compass reading, 4 its GPS epoch, 8 a fusion. 0 for a packet from the past."""
    t = tick_time(words) + n[gl.TICK_OFFSET]
    before = n[gl.TICK]
    if t <= before:
        return np.int64(0)
    n[gl.TICK] = t
    done = np.int64(0)
    if _resolve(g, n, words, seconds_between(before, t)):
        done |= USED
    wx = g[gl.OMEGA]
    wy = g[gl.OMEGA + 1]
    wz = g[gl.OMEGA + 2]
    ax = g[gl.FORCE]
    ay = g[gl.FORCE + 1]
    az = g[gl.FORCE + 2]
    n[gl.RATE_IS_OWN] = 1 if felt[0] == ZERO else 0
    if felt[0] != ZERO:
        done |= USED
        wx, wy, wz, ax, ay, az = felt[1], felt[2], felt[3], felt[4], felt[5], felt[6]
    elif done == 0:
        wx = NAN
    dt = seconds_between(before, t)
    imu_step(f1, i1, t, dt, wx, wy, wz, ax, ay, az)
    imu_step(f2, i2, t, dt, wx, wy, wz, ax, ay, az)
    imu_step(fm, im, t, dt, wx, wy, wz, ax, ay, az)
    if words[pk.FLAGS] & pk.HAS_COMPASS:
        done |= COMPASS_DUE
    if words[pk.FLAGS] & pk.HAS_GPS:
        done |= GPS_DUE
    if t >= n[gl.FUSION_DUE]:
        n[gl.FUSION_DUE] = t + n[gl.FUSION_NS] - (n[gl.TICK_NS] >> 1)
        done |= FUSION_DUE
    return done


@kernel
def _resolve(g, n, words, dt):
    for k in range(NINE):
        count = np.float32(np.int32(signed(words[pk.ACCELERATIONS + k])))
        g[gl.ACCELERATION + k] = count * g[gl.SCALE + k] - g[gl.OFFSET + k]
    return words[pk.FAULTS] == 0 and rate_step(g, n, dt)


@kernel("void(int64[::1], int64[::1], int64)")
def epoch_of_packet(words, e, t):
    """The GPS part of a packet of time `t` (ns) as an epoch record."""
    for k in range(np.int32(gnss.RECORD_SIZE)):
        e[k] = 0
    flags = np.int64(gnss.HAS_TIME | gnss.HAS_DATE | gnss.HAS_POSITION)
    if words[pk.FLAGS] & pk.HAS_HEIGHT:
        flags |= gnss.HAS_HEIGHT
    if words[pk.FLAGS] & pk.HAS_COURSE:
        flags |= gnss.HAS_SPEED | gnss.HAS_COURSE
    e[gnss.FLAGS] = flags
    e[gnss.TIME_OF_DAY_MS] = signed_32(words, pk.TIME_OF_DAY)
    e[gnss.DATE_DAYS] = words[pk.DATE]
    e[gnss.LAT_NANODEG] = signed_64(words, pk.LATITUDE)
    e[gnss.LON_NANODEG] = signed_64(words, pk.LONGITUDE)
    e[gnss.HEIGHT_MM] = signed_32(words, pk.HEIGHT)
    e[gnss.SPEED_MMPS] = signed_32(words, pk.SPEED)
    e[gnss.COURSE_E5DEG] = signed_32(words, pk.COURSE)
    e[gnss.FIX_QUALITY] = words[pk.QUALITY]
    e[gnss.SATELLITES] = words[pk.SATELLITES]
    e[gnss.HDOP_CENTI] = words[pk.HDOP]
    e[gnss.VALID_NS] = t - words[pk.GPS_AGE] * AGE_NS
