"""One packet of the acquisition processor through everything: the navigation processor's only door in flight.

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
from firmware.nav.gyro_free.steps import compass_step, fusion_step, gps_step, inertial_step
from firmware.nav.history import seconds_between
from firmware.numerics.dialect import kernel

NAN = np.float32(np.nan)
ZERO = np.float32(0.0)
SECOND = np.int64(1_000_000_000)
AGE_NS = np.int64(100_000)
NINE = np.int32(9)
DONE_RATE = 1
DONE_COMPASS = 2
DONE_GPS = 4
DONE_FUSION = 8


@kernel(
    "int64(float32[::1], int64[::1], int64[::1], int64[::1], float32[::1], float32[::1], int64[::1],"
    " float32[::1], int64[::1], float32[::1], int64[::1])"
)
def packet_step(g, n, words, e, felt, f1, i1, f2, i2, fm, im):
    """The words of a good packet (packet) to the filters; `e` is room for an epoch record. Returns what was
    done: 1 a sample was used, 2 a compass reading believed, 4 a GPS epoch believed, 8 fused."""
    t = tick_time(words)
    before = n[gl.TICK]
    if t <= before:
        return np.int64(0)
    n[gl.TICK] = t
    done = _inertial(g, n, words, felt, f1, i1, f2, i2, fm, im, t, seconds_between(before, t))
    flags = words[pk.FLAGS]
    if flags & pk.HAS_COMPASS:
        valid = t - words[pk.COMPASS_AGE] * AGE_NS
        heading, pitch, roll = words[pk.HEADING], signed(words[pk.PITCH]), signed(words[pk.ROLL])
        if compass_step(g, n, f1, i1, heading, pitch, roll, valid):
            done |= DONE_COMPASS
    if flags & pk.HAS_GPS:
        epoch_of_packet(words, e, t)
        if gps_step(g, n, f2, i2, e):
            done |= DONE_GPS
    if t >= n[gl.FUSION_DUE]:
        n[gl.FUSION_DUE] = t + SECOND - (n[gl.TICK_NS] >> 1)
        if fusion_step(g, n, f1, i1, f2, i2, fm, im):
            done |= DONE_FUSION
    return done


@kernel
def _inertial(g, n, words, felt, f1, i1, f2, i2, fm, im, t, dt):
    for k in range(NINE):
        count = np.float32(np.int32(signed(words[pk.ACCELERATIONS + k])))
        g[gl.ACCELERATION + k] = count * g[gl.SCALE + k] - g[gl.OFFSET + k]
    whole = words[pk.FAULTS] == 0
    solved = whole and rate_step(g, n, dt)
    if felt[0] != ZERO:
        inertial_step(f1, i1, f2, i2, fm, im, t, dt, felt[1], felt[2], felt[3], felt[4], felt[5], felt[6])
        return np.int64(DONE_RATE)
    if not solved:
        inertial_step(f1, i1, f2, i2, fm, im, t, dt, NAN, NAN, NAN, NAN, NAN, NAN)
        return np.int64(0)
    o = gl.OMEGA
    a = gl.FORCE
    inertial_step(f1, i1, f2, i2, fm, im, t, dt, g[o], g[o + 1], g[o + 2], g[a], g[a + 1], g[a + 2])
    return np.int64(DONE_RATE)


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
