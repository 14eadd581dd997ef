"""From the fields of one message to the epoch at hand.

First the fields are made into quantities of the record (`complete`): a date of its parts, a height of
altitude and geoid separation, a velocity of speed and course. Then the message is entered into its epoch,
and every field it gave is written unless a finer message gave that field before.

Only the modes A (autonomous), D (differential), P (precise), R and F (RTK) are a valid fix; dead
reckoning, manual input and simulators are no measurements of this receiver. One message that says
"no fix" is enough for the whole epoch to have no position.

    v_n = v·cos χ,  v_e = v·sin χ     PUBX,00 gives speed, course and vertical velocity
"""

from typing import Final

import numpy as np

from firmware.drivers.epoch_grouping import enter, leave
from firmware.drivers.gnss_epoch import (
    BASELINE_MM,
    COURSE_E5DEG,
    DATE_DAYS,
    FIX_QUALITY,
    FIX_TYPE,
    FLAGS,
    H_ACC_MM,
    HDOP_CENTI,
    HEADING_E5DEG,
    HEIGHT_MM,
    HEIGHT_MSL_MM,
    LAT_NANODEG,
    LON_NANODEG,
    PDOP_CENTI,
    RECORD_SIZE,
    S_ACC_MMPS,
    SPEED_MMPS,
    TIME_OF_DAY_MS,
    V_ACC_MM,
    VDOP_CENTI,
    VEL_D_MMPS,
    VEL_E_MMPS,
    VEL_N_MMPS,
)
from firmware.drivers.integer_math import along, hypotenuse
from firmware.drivers.message_fields import days_since_1980
from firmware.drivers.receiver_state import (
    ATTITUDE_QUALITY,
    COURSE_SIGMA,
    DAY,
    EAST_SIGMA,
    FIX_BITS,
    FLAG_OF,
    GGA,
    GLL,
    GNS,
    GOT,
    GSA,
    GST,
    GSV,
    HDT,
    HOUR,
    MESSAGE_ROW,
    MESSAGES,
    MINUTE,
    MODE_QUALITY,
    MONTH,
    NANO,
    NAV_PVT,
    NORTH_SIGMA,
    PASHR,
    PASHR_HPR,
    PSAT_HPR,
    PTNL_AVR,
    PUBX_00,
    RANK,
    REFUSED,
    RMC,
    SECOND,
    SEPARATION,
    SERIES_LENGTH,
    SERIES_NUMBER,
    STATUS,
    THS,
    VALID_BITS,
    VTG,
    WORK,
    YEAR,
)
from firmware.numerics.dialect import kernel

FULL_TURN_E5DEG: Final = 36_000_000
LARGEST_DILUTION: Final = 9_999
"""99.99; larger values are printed by some receivers and mean the same: none."""
COURSE_IS_GOOD_E5DEG: Final = 4_500_000
"""A course whose own sigma is larger (the vehicle hardly moves) is not passed on."""
DAY_MS: Final = 86_400_000
MILLIONTH: Final = 4_503_599_628
"""⌊x/15625⌋ = x·⌈2⁴⁶/15625⌉ >> 46 for 0 ≤ x < 2²⁶; 10⁶ = 64·15625."""
EAST_E5DEG: Final = 9_000_000

BY_STATUS: Final = 1 << RMC | 1 << GLL
BY_LETTERS: Final = 1 << RMC | 1 << GLL | 1 << VTG | 1 << GNS | 1 << HDT | 1 << THS
MALFORMED_MESSAGE: Final = -1
NO_FIX: Final = 0
FIX: Final = 1

RK: Final = ord("R") << 8 | ord("K")
DR: Final = ord("D") << 8 | ord("R")
NF: Final = ord("N") << 8 | ord("F")
TT: Final = ord("T") << 8 | ord("T")


@kernel
def give(s, slot, value):
    """Set a slot as if the message had given it."""
    s[slot] = value
    s[GOT + slot] = 1


@kernel
def from_letters(s, message):
    """What RMC, GLL, VTG, GNS, HDT and THS say by their letters."""
    status = s[STATUS] if s[GOT + STATUS] != 0 else np.int64(0)
    moded = s[GOT + MODE_QUALITY] != 0
    quality = s[MODE_QUALITY] if moded else np.int64(1)
    if message == GNS:
        quality = quality if moded else np.int64(0)
    elif (BY_STATUS >> message) & 1 == 1:
        if status != ord("A") and status != ord("V"):
            return MALFORMED_MESSAGE
        quality = quality if status == ord("A") else np.int64(0)
    elif message == VTG:
        if s[GOT + COURSE_E5DEG] != 0 and status != ord("T"):
            return MALFORMED_MESSAGE
    elif message == HDT:
        return MALFORMED_MESSAGE if s[GOT + HEADING_E5DEG] != 0 and status != ord("T") else FIX
    else:
        # THS: only A (autonomous) is a measurement
        s[GOT + HEADING_E5DEG] &= 1 if status == ord("A") else 0
        return FIX if status != 0 else MALFORMED_MESSAGE
    if message != VTG:
        give(s, FIX_QUALITY, quality)
    return FIX if quality > 0 else NO_FIX


@kernel
def attitude_is_measured(s, message):
    """Whether an attitude sentence says that its angles are a measurement of the two antennas.

    PASHR: a quality from 1 to 5, or none told; PASHR,HPR: ambiguities fixed (0); PSAT,HPR: N, not the gyro;
    HPR: fixed (4); PTNL,AVR: fixed (3).
    """
    quality = s[ATTITUDE_QUALITY] if s[GOT + ATTITUDE_QUALITY] != 0 else np.int64(-1)
    if message == PASHR:
        return quality == -1 or (quality >= 1 and quality <= 5)
    if message == PSAT_HPR:
        return s[GOT + STATUS] != 0 and s[STATUS] == ord("N")
    if message == PTNL_AVR:
        return quality == 3
    return quality == (0 if message == PASHR_HPR else 4)


@kernel
def from_attitude(s, message):
    """An attitude sentence: its angles or nothing; it says nothing about the position."""
    if message == PASHR and s[GOT + STATUS] != 0 and s[STATUS] != ord("T"):
        return MALFORMED_MESSAGE
    if not attitude_is_measured(s, message):
        for field in range(np.int32(BASELINE_MM - HEADING_E5DEG + 1)):
            s[GOT + HEADING_E5DEG + field] = 0
    return FIX


@kernel
def nav_stat(letters):
    """PUBX,00's two letters as (fix quality, fix type), the quality −1 when they are unknown."""
    dimensions = (letters & 0xFF) - ord("0")
    known = letters >> 8 == ord("G") or letters >> 8 == ord("D")
    if known and dimensions >= 2 and dimensions <= 3:
        return np.int64(1 if letters >> 8 == ord("G") else 2), dimensions
    # GNSS combined with dead reckoning
    if letters == RK:
        return np.int64(1), np.int64(3)
    if letters == DR:
        return np.int64(6), np.int64(1)
    if letters == NF:
        return np.int64(0), np.int64(1)
    return np.int64(0 if letters == TT else -1), np.int64(1)


@kernel
def from_nav_stat(s):
    """PUBX,00: fix quality and type from its two letters, the velocity from speed and course."""
    quality, fix_type = nav_stat(s[STATUS])
    if s[GOT + STATUS] == 0 or quality < 0:
        return MALFORMED_MESSAGE
    give(s, FIX_TYPE, fix_type)
    give(s, FIX_QUALITY, quality)
    give(s, S_ACC_MMPS, np.int64(0))
    if s[GOT + SPEED_MMPS] != 0 and s[GOT + COURSE_E5DEG] != 0 and s[GOT + VEL_D_MMPS] != 0:
        give(s, VEL_N_MMPS, along(s[SPEED_MMPS], s[COURSE_E5DEG]))
        give(s, VEL_E_MMPS, along(s[SPEED_MMPS], s[COURSE_E5DEG] - EAST_E5DEG))
    else:
        s[GOT + VEL_D_MMPS] = 0
    return FIX if quality == 1 or quality == 2 else NO_FIX


@kernel
def pvt_time(s):
    """NAV-PVT: ms of the day from whole seconds and ± nanoseconds, which may mean the day before."""
    if s[VALID_BITS] & 1 == 0:
        s[GOT + YEAR] = 0
    if s[VALID_BITS] & 2 == 0:
        s[GOT + YEAR] = 0
        return
    # ⌊nano/10⁶ + 1/2⌋ for |nano| ≤ 10⁹
    ms = ((((s[NANO] + 2_000_500_000) >> 6) * MILLIONTH) >> 46) - 2000
    ms += ((s[HOUR] * 60 + s[MINUTE]) * 60 + s[SECOND]) * 1000
    give(s, TIME_OF_DAY_MS, ms)


@kernel
def from_pvt(s):
    """NAV-PVT: fix quality and type from its bits, time and course."""
    pvt_time(s)
    bits = s[FIX_BITS]
    kind = s[FIX_TYPE]
    carrier = bits >> 6
    fix = bits & 1 != 0 and kind >= 2 and kind <= 4
    quality = 1 + ((bits >> 1) & 1)
    if carrier == 2:
        quality = np.int64(4)
    elif carrier == 1:
        quality = np.int64(5)
    give(s, FIX_QUALITY, quality if fix else (6 if kind == 1 else 0))
    give(s, FIX_TYPE, min(kind, np.int64(3)) if fix else np.int64(1))
    if s[COURSE_E5DEG] < 0:
        s[COURSE_E5DEG] += FULL_TURN_E5DEG
    if s[COURSE_SIGMA] > COURSE_IS_GOOD_E5DEG:
        s[GOT + COURSE_E5DEG] = 0
    s[SPEED_MMPS] = abs(s[SPEED_MMPS])
    return FIX if fix else NO_FIX


@kernel
def interpret(s, message):
    """What the message says about the fix, by its own words."""
    if message == GGA:
        quality = s[FIX_QUALITY]
        return FIX if s[GOT + FIX_QUALITY] != 0 and quality >= 1 and quality <= 5 else NO_FIX
    if message == PUBX_00:
        return from_nav_stat(s)
    if message == NAV_PVT:
        return from_pvt(s)
    if message >= PASHR:
        return from_attitude(s, message)
    if (BY_LETTERS >> message) & 1 == 1:
        return from_letters(s, message)
    if message == GST and s[GOT + NORTH_SIGMA] != 0 and s[GOT + EAST_SIGMA] != 0:
        give(s, H_ACC_MM, hypotenuse(s[NORTH_SIGMA], s[EAST_SIGMA]))
    return FIX


@kernel
def date_of_parts(s):
    """Make a date of year, month and day; False when there is no such day. A date alone tells nothing."""
    s[GOT + DATE_DAYS] = 0
    if s[GOT + YEAR] == 0 or s[GOT + MONTH] == 0 or s[GOT + DAY] == 0:
        return True
    days = days_since_1980(s[YEAR], s[MONTH], s[DAY])
    if days < 0:
        return False
    if s[GOT + TIME_OF_DAY_MS] == 0:
        return True
    if s[TIME_OF_DAY_MS] < 0 and days > 0:
        days -= 1
    give(s, DATE_DAYS, days)
    return True


@kernel
def complete(s):
    """Quantities of the record that several fields make together, or that need a limit."""
    if s[TIME_OF_DAY_MS] < 0:
        s[TIME_OF_DAY_MS] += DAY_MS
    if s[GOT + HEIGHT_MSL_MM] != 0 and s[GOT + SEPARATION] != 0:
        give(s, HEIGHT_MM, s[HEIGHT_MSL_MM] + s[SEPARATION])
    if s[GOT + LAT_NANODEG] == 0 or s[GOT + LON_NANODEG] == 0:
        s[GOT + LAT_NANODEG] = 0
        s[GOT + LON_NANODEG] = 0
    if s[GOT + H_ACC_MM] == 0 or s[GOT + V_ACC_MM] == 0:
        s[GOT + H_ACC_MM] = 0
        s[GOT + V_ACC_MM] = 0
    if s[COURSE_E5DEG] >= FULL_TURN_E5DEG:
        s[COURSE_E5DEG] -= FULL_TURN_E5DEG
    if s[HEADING_E5DEG] >= FULL_TURN_E5DEG:
        s[HEADING_E5DEG] -= FULL_TURN_E5DEG
    s[HDOP_CENTI] = min(s[HDOP_CENTI], np.int64(LARGEST_DILUTION))
    s[VDOP_CENTI] = min(s[VDOP_CENTI], np.int64(LARGEST_DILUTION))
    s[PDOP_CENTI] = min(s[PDOP_CENTI], np.int64(LARGEST_DILUTION))


@kernel
def depends_on_fix(field):
    """Whether a field of the record means something only with a valid fix."""
    return (field >= LAT_NANODEG and field <= VEL_D_MMPS) or (field >= H_ACC_MM and field <= S_ACC_MMPS)


@kernel
def write(s, message, fix):
    """Write what the message gave into the epoch at hand, but not over what a finer message gave."""
    rank = s[MESSAGES + message * MESSAGE_ROW + 3]
    if message == GSA:
        # a GSA may speak of one system only: the best fix type stays
        s[FIX_TYPE] = max(s[FIX_TYPE], s[WORK + FIX_TYPE])
    for i in range(np.int32(RECORD_SIZE - DATE_DAYS)):
        field = i + DATE_DAYS
        given = s[GOT + field] != 0 and (fix == FIX or not depends_on_fix(field))
        if given and rank >= s[RANK + field]:
            s[RANK + field] = rank
            s[WORK + field] = s[field]
            s[WORK + FLAGS] |= s[FLAG_OF + field]
    if fix == NO_FIX:
        s[REFUSED] = 1


@kernel
def update_epoch(s, epoch, message):
    """Apply the fields of `message` that have been read; False when they contradict its rules."""
    fix = interpret(s, message)
    if fix == MALFORMED_MESSAGE or not date_of_parts(s):
        return False
    complete(s)
    time_ms = s[TIME_OF_DAY_MS] if s[GOT + TIME_OF_DAY_MS] != 0 else np.int64(-1)
    if enter(s, epoch, message, time_ms):
        write(s, message, fix)
        if message != GSV or s[SERIES_NUMBER] == s[SERIES_LENGTH]:
            leave(s, epoch, message)
    return True
