"""Satellites in view (GSV) and used (GSA) for people's displays; navigation does not read them.

Both lists live in the stream's state and carry the number of the epoch that brought them: the first GSV
of a system in an epoch drops what that system listed before, the first GSA of an epoch drops all used
satellites. A satellite is packed as system << 16 | number. Numbers keep the receiver's numbering
(fact sheet section 2); the system comes from the talker, or from the number under talker GN.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.receiver_state import (
    EPOCHS,
    FIELD_COUNT,
    GOT,
    LIST,
    LIST_LENGTH,
    SERIES_LENGTH,
    SERIES_NUMBER,
    USED,
    USED_COUNT,
    USED_LIMIT,
    USED_STAMP,
    VIEW,
    VIEW_COUNT,
    VIEW_LIMIT,
    VIEW_ROW,
)
from firmware.numerics.dialect import kernel

OTHER: Final = 0
GPS: Final = 1
GLONASS: Final = 2
GALILEO: Final = 3
BEIDOU: Final = 4
QZSS: Final = 5
SBAS: Final = 6
SYSTEM_NAMES: Final = ("other", "GPS", "GLONASS", "Galileo", "BeiDou", "QZSS", "SBAS")

STALE_EPOCHS: Final = 10
"""A system that has not been listed for so many epochs is no longer shown."""


class SatelliteInView(NamedTuple):
    """One row for people; None where the receiver left the field empty (`cn0_dbhz` None: not tracked)."""

    system: str
    number: int
    elevation_deg: int | None
    azimuth_deg: int | None
    cn0_dbhz: int | None
    used: bool


@kernel
def system_of(talker, number):
    """System of a satellite `number` listed by the talker whose second letter is `talker`."""
    if talker == ord("L"):
        return GLONASS
    if talker == ord("A"):
        return GALILEO
    if talker == ord("B") or talker == ord("D"):
        return BEIDOU
    if talker == ord("Q"):
        return QZSS
    if number >= 65 and number <= 96:
        return GLONASS
    if number >= 33 and number <= 64:
        return SBAS
    if number >= 193 and number <= 202:
        return QZSS
    if number >= 401 and number <= 437:
        return BEIDOU
    return GPS if number <= 32 else OTHER


@kernel
def drop_system(s, talker):
    """Forget what this talker listed in earlier epochs, keeping the order of the rest."""
    kept = np.int64(0)
    for i in range(np.int32(s[VIEW_COUNT])):
        row = VIEW + i * VIEW_ROW
        old = (s[row + 4] & 0xFF) == talker and (s[row + 4] >> 8) != s[EPOCHS]
        if not old:
            for k in range(np.int32(VIEW_ROW)):
                s[VIEW + kept * VIEW_ROW + k] = s[row + k]
            kept += 1
    s[VIEW_COUNT] = kept


@kernel
def store_view(s, packed, slot, stamp):
    """Add the satellite whose elevation, azimuth and C/N0 follow `slot`.

    When the same epoch has listed it already (another signal of it), the larger C/N0 stays.
    """
    at = np.int64(0)
    while at < s[VIEW_COUNT] and s[VIEW + at * VIEW_ROW] != packed:
        at += 1
    if at >= VIEW_LIMIT:
        return
    row = VIEW + at * VIEW_ROW
    cn0 = s[slot + 3]
    if at == s[VIEW_COUNT]:
        s[VIEW_COUNT] += 1
    elif s[row + 4] == stamp:
        cn0 = max(cn0, s[row + 3])
    s[row] = packed
    s[row + 1] = s[slot + 1]
    s[row + 2] = s[slot + 2]
    s[row + 3] = cn0
    s[row + 4] = stamp


@kernel
def series_is_good(s):
    """Whether the GSV whose fields have been read is number 1 … n of n."""
    number = s[SERIES_NUMBER]
    told = s[GOT + SERIES_LENGTH] != 0 and s[GOT + SERIES_NUMBER] != 0
    return told and number >= 1 and number <= s[SERIES_LENGTH]


@kernel
def satellites_in_view(s, talker):
    """Store the satellites of the GSV whose fields have been read."""
    if s[SERIES_NUMBER] == 1:
        drop_system(s, talker)
    stamp = s[EPOCHS] << 8 | talker
    for group in range(np.int32(LIST_LENGTH // 4)):
        at = LIST + 4 * group
        for k in range(np.int32(4)):
            if s[GOT + at + k] == 0:
                s[at + k] = -1
        # the last group of a GSV may be cut short, and its fourth number be the signal (NMEA 4.1)
        if s[at] >= 0 and 4 * group + 7 < s[FIELD_COUNT]:
            packed = system_of(talker, s[at]) << 16 | s[at]
            store_view(s, packed, at, stamp)


@kernel
def satellites_used(s, talker):
    """Add the satellites of the GSA whose fields have been read."""
    if s[USED_STAMP] != s[EPOCHS]:
        s[USED_STAMP] = s[EPOCHS]
        s[USED_COUNT] = 0
    for i in range(np.int32(12)):
        if s[GOT + LIST + i] != 0 and s[USED_COUNT] < USED_LIMIT:
            s[USED + s[USED_COUNT]] = system_of(talker, s[LIST + i]) << 16 | s[LIST + i]
            s[USED_COUNT] += 1


def satellites(state: NDArray[np.int64]) -> list[SatelliteInView]:
    """The satellites in view as the receiver listed them last (plain Python, for displays and the link)."""
    epochs = int(state[EPOCHS])
    used = set(state[USED : USED + int(state[USED_COUNT])].tolist())
    if epochs - int(state[USED_STAMP]) > STALE_EPOCHS:
        used = set()
    rows = state[VIEW : VIEW + int(state[VIEW_COUNT]) * VIEW_ROW].reshape(-1, VIEW_ROW).tolist()
    return [
        SatelliteInView(
            SYSTEM_NAMES[packed >> 16],
            packed & 0xFFFF,
            elevation if elevation >= 0 else None,
            azimuth if azimuth >= 0 else None,
            cn0 if cn0 >= 0 else None,
            packed in used,
        )
        for packed, elevation, azimuth, cn0, stamp in rows
        if epochs - (stamp >> 8) <= STALE_EPOCHS
    ]
