"""A drive of chapter 5 as packets of the acquisition: ADXL345 noise and counts, compass, GPS."""

import math

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as gnss
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.geometry import DIRECTIONS
from firmware.nav.gyro_free.packet import put_number
from host.sim.seeding import generator
from host.tables.chapter5 import COMPASS_EVERY, GPS_EVERY, PERIOD_NS, Feed
from host.tables.rate_motion import COUNT, NOISE

WORD = 0.5e-3 * 9.80665


def accelerometer_words(feed: Feed, seed: int, offsets: NDArray[np.float64]) -> NDArray[np.int64]:
    """(n, 9) counts of 0.5 mg: a vehicle that does not turn, chips with noise and `offsets` (m/s²)."""
    count = len(feed.inertial)
    force = np.median(feed.inertial[:, 3:], axis=0)
    read = np.empty((count, 9))
    for place in range(9):
        noise = NOISE[place] * generator(seed, f"A{place + 1}").standard_normal(count)
        read[:, place] = np.round((force[DIRECTIONS[place]] + offsets[place] + noise) / COUNT) * COUNT
    return np.round(read / WORD).astype(np.int64) & 0xFFFF


def packet_words(feed: Feed, sample: int, accelerations: NDArray[np.int64]) -> NDArray[np.int64]:
    """Words of the packet of sample `sample`."""
    words = np.zeros(pk.WORDS, np.int64)
    words[pk.SEQUENCE] = sample & 0xFFFF
    put_number(words, pk.TIME, (sample + 1) * PERIOD_NS // 1000, 3)
    words[pk.ACCELERATIONS : pk.ACCELERATIONS + 9] = accelerations[sample]
    if (sample + 1) % COMPASS_EVERY == 0:
        words[pk.FLAGS] |= pk.HAS_COMPASS
        words[pk.HEADING : pk.ROLL + 1] = feed.compass[(sample + 1) // COMPASS_EVERY - 1] & 0xFFFF
    if (sample + 1) % GPS_EVERY == 0:
        epoch = feed.epochs[(sample + 1) // GPS_EVERY - 1]
        north, east = int(epoch[gnss.VEL_N_MMPS]), int(epoch[gnss.VEL_E_MMPS])
        words[pk.FLAGS] |= pk.HAS_GPS | pk.HAS_HEIGHT | pk.HAS_COURSE
        put_number(words, pk.LATITUDE, int(epoch[gnss.LAT_NANODEG]), 4)
        put_number(words, pk.LONGITUDE, int(epoch[gnss.LON_NANODEG]), 4)
        put_number(words, pk.HEIGHT, int(epoch[gnss.HEIGHT_MM]), 2)
        put_number(words, pk.SPEED, round(math.hypot(north, east)), 2)
        put_number(words, pk.COURSE, round(math.degrees(math.atan2(east, north)) % 360.0 * 1e5), 2)
    return words
