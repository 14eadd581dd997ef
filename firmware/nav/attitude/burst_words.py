"""The 14 words of an ADIS16407 burst, as integers: fields, and what is noticed about them.

SUPPLY_OUT, gyro, accelerometer and magnetometer x, y, z, BARO_OUT, BARO_OUTL, TEMP_OUT, AUX_ADC. Bit 15 (ND)
says new data, bit 14 (EA) an error or alarm, the value stands below them (fact sheet sections 2 to 4).
"""

import numpy as np

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.numerics.dialect import kernel

WORDS = 14
GYRO = 1
ACCEL = 4
MAGN = 7
BARO = 10

# 2.418 mV a count: 4.75 V … 5.25 V are allowed; beyond 4 V … 6 V it is no supply at all.
LOWEST_SUPPLY = 1965
HIGHEST_SUPPLY = 2171
LEAST_SUPPLY = 1654
MOST_SUPPLY = 2481
# 0.08 mbar a count: 200 mbar … 1200 mbar; 0 is a part without barometer.
LEAST_BARO = 2500
MOST_BARO = 15000


@kernel
def signed_14(word):
    """Two's complement of the lowest 14 bits."""
    return ((word & 0x3FFF) ^ 0x2000) - 0x2000


@kernel
def look_at(i, words):
    """What there is to notice about the burst: STALE … SLIPPED."""
    same = True
    first = words[0] & 0xFFFF
    error = np.int64(0)
    for k in range(np.int32(WORDS)):
        same = same and (words[k] & 0xFFFF) == first
        error |= words[k] & 0x4000
    if same and (first == 0 or first == 0xFFFF):
        return np.int64(fl.NO_ANSWER)
    new = np.int64(0x8000)
    found = np.int64(0)
    for k in range(np.int32(GYRO), np.int32(MAGN)):
        new &= words[k]
    for k in range(np.int32(GYRO), np.int32(ACCEL)):
        if abs(signed_14(words[k])) >= i[at.GYRO_LIMIT]:
            found |= fl.GYRO_SATURATED
    if new == 0:
        found |= fl.STALE
    if error != 0:
        found |= fl.CHIP_ERROR
    supply = first & 0xFFF
    if supply < LOWEST_SUPPLY or supply > HIGHEST_SUPPLY:
        found |= fl.SUPPLY
    baro = words[BARO] & 0x3FFF
    if supply < LEAST_SUPPLY or supply > MOST_SUPPLY:
        found |= fl.SLIPPED
    if baro != 0 and (baro < LEAST_BARO or baro > MOST_BARO):
        found |= fl.SLIPPED
    return found


@kernel
def note(i, found):
    """Remember what was noticed about the newest sample, and count it."""
    i[at.NOTICED] = found
    i[at.NOTICED_SINCE] |= found
    i[at.SAMPLES] += 1
    rest = found
    for k in range(np.int32(16)):
        i[at.NOTICES + k] += rest & 1
        rest >>= 1


@kernel
def bridge_over(i, found):
    """`found` with what bridging this sample adds: BRIDGED, and RATES_LOST when it has lasted too long."""
    i[at.BRIDGED_IN_A_ROW] += 1
    found |= fl.BRIDGED
    if i[at.BRIDGED_IN_A_ROW] > i[at.LONGEST_BRIDGE]:
        found |= fl.RATES_LOST
    return found


@kernel
def place_in_ring(i, found):
    """A sample more waits for the next iteration; OVERRUN when three waited already."""
    if i[at.IN_RING] == 3:
        return found | fl.OVERRUN
    i[at.IN_RING] += 1
    return found
