"""The packet that the acquisition processor sends each tick of 200 Hz: 48 words of 16 bits, high byte first.

    word   what
    0      sync 0xA55A                       18-20  compass: heading 0…3599, pitch, roll, tenths of a degree
    1      kind and version 0x4701           21     its age at the tick, 0.1 ms
    2      sequence number                   22-25  GPS: latitude, nanodegree (64 bits, high word first)
    3-5    time of the tick, µs (48 bits)    26-29  longitude, nanodegree
    6-14   A1 … A9, signed, 0.5 mg each      30-31  height above the ellipsoid, mm
    15     bit k: chip k + 1 gave a sample   32-33  speed over ground, mm/s
    16     bit k: chip k + 1 is missing,     34-35  course, 1e-5 degree
           stuck or misread                  36-37  UTC time of day, ms      38  date, days since 1980-01-06
    17     flags: 1 compass, 2 GPS,          39     fix quality   40  satellites   41  HDOP, 0.01
           4 height, 8 course                42     age of the epoch at the tick, 0.1 ms
                                             43-46  a coefficient of the calibration, or 0
                                             47     CRC-16/CCITT-FALSE of the 94 bytes before

Numbers below zero are two's complement. A slip by a word or a byte shows in sync word, kind and CRC.
"""

from struct import Struct
from typing import Final

import numpy as np

from firmware.link.crc import crc16
from firmware.numerics.dialect import kernel

WORDS: Final = 48
BYTES: Final = 96
SYNC, KIND, SEQUENCE, TIME = 0, 1, 2, 3
ACCELERATIONS: Final = 6
CHIPS, FAULTS = 15, 16
FLAGS: Final = 17
HEADING, PITCH, ROLL, COMPASS_AGE = 18, 19, 20, 21
LATITUDE, LONGITUDE, HEIGHT, SPEED, COURSE = 22, 26, 30, 32, 34
TIME_OF_DAY, DATE, QUALITY, SATELLITES, HDOP, GPS_AGE = 36, 38, 39, 40, 41, 42
CRC = 47
SYNC_WORD = np.int64(0xA55A)
KIND_WORD = np.int64(0x4701)
HAS_COMPASS: Final = 1
HAS_GPS: Final = 2
HAS_HEIGHT, HAS_COURSE = 4, 8

HEADER: Final = Struct("4q")
HEADER_AT: Final = 16
STAMP: Final = Struct("3q")
STAMP_AT: Final = 24
"""Sequence number and time, and time alone, in the memory of an array of words: a third of the time of an
assignment to a slice."""

GOOD: Final = 0
NO_SYNC = 1
WRONG_KIND: Final = 2
WRONG_CRC = 3
RESULT_NAMES = ("good", "no sync word", "wrong kind", "wrong checksum")

LOW = np.int64(0xFFFF)
BYTE = np.int64(0xFF)
SIGN = np.int64(0x8000)
SIGN_32 = np.int64(0x80000000)


@kernel("void(int64[::1], uint8[::1])")
def seal_packet(words, data):
    """Bytes to be sent of 48 words; sync, kind and checksum are filled in."""
    words[SYNC] = SYNC_WORD
    words[KIND] = KIND_WORD
    for k in range(np.int32(CRC)):
        data[2 * k] = np.uint8((words[k] >> 8) & BYTE)
        data[2 * k + 1] = np.uint8(words[k] & BYTE)
    words[CRC] = np.int64(crc16(data, np.int32(0), np.int32(2 * CRC)))
    data[2 * CRC] = np.uint8((words[CRC] >> 8) & BYTE)
    data[2 * CRC + 1] = np.uint8(words[CRC] & BYTE)


@kernel("int64(uint8[::1], int64[::1])")
def open_packet(data, words):
    """The 48 words of 96 bytes received; GOOD, or what is wrong with them."""
    return open_packet_at(data, np.int32(0), words)


@kernel("int64(uint8[::1], int32, int64[::1])")
def open_packet_at(data, begin, words):
    """The same of the bytes from `begin` on."""
    for k in range(np.int32(WORDS)):
        words[k] = (np.int64(data[begin + 2 * k]) << 8) | np.int64(data[begin + 2 * k + 1])
    if words[SYNC] != SYNC_WORD:
        return np.int64(NO_SYNC)
    if words[KIND] != KIND_WORD:
        return np.int64(WRONG_KIND)
    if words[CRC] != np.int64(crc16(data, begin, np.int32(begin + 2 * CRC))):
        return np.int64(WRONG_CRC)
    return np.int64(GOOD)


@kernel
def signed(word):
    """A word as two's complement."""
    return ((word & LOW) ^ SIGN) - SIGN


@kernel
def signed_32(words, place):
    """Two words, high one first, as two's complement."""
    return (((words[place] << 16) | words[place + 1]) ^ SIGN_32) - SIGN_32


@kernel
def signed_64(words, place):
    """Four words, high one first."""
    return (
        (signed(words[place]) << 48) | (words[place + 1] << 32) | (words[place + 2] << 16) | words[place + 3]
    )


@kernel
def tick_time(words):
    """Of the tick, ns."""
    return ((words[TIME] << 32) | (words[TIME + 1] << 16) | words[TIME + 2]) * np.int64(1000)


@kernel("void(int64[::1], int64, int64, int64)")
def put_number(words, place, value, count):
    """A number into `count` words, high one first."""
    for k in range(np.int32(count)):
        shift = 16 * (count - 1 - k)
        words[place + k] = (value >> shift) & LOW
