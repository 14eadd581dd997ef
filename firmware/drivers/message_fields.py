"""Fields of a message, read where DMA put them, in integers only.

A field of a sentence is a span of stream positions [begin, end) between two commas, a field of a frame an
offset into its payload. Which fields a message has, what they mean and what they may hold is a table
(`message_table`); one loop reads them all. An empty field is no error; one field that holds what it must
not, and the whole message is left aside.

The target has no 64-bit division, so divisions go by multiplication and shift, exact in the range told:
    ⌊x/60⌋  = x·⌈2³⁷/60⌉ >> 37,   ⌊x/900⌋ = x·⌈2⁴¹/900⌉ >> 41   for 0 ≤ x < 2³¹
    ⌊x/100⌋ = x·⌈2³²/100⌉ >> 32   for 0 ≤ x < 2³⁰
"""

from typing import Final

import numpy as np

from firmware.drivers.receiver_state import (
    DAY,
    FIELD,
    FIELD_COUNT,
    GOT,
    LAYOUT,
    LAYOUT_ROW,
    MONTH,
    RING_MASK,
    SLOTS,
    START,
    YEAR,
)
from firmware.numerics.dialect import kernel

# Columns of a layout row.
PLACE: Final = 0
"""Field number behind the address, or offset into the payload."""
KIND: Final = 1
SLOT: Final = 2
DECIMALS: Final = 3
"""NUMBER: the unit is 10^−decimals. LATITUDE, LONGITUDE: digits of the degrees."""
LOWEST: Final = 4
HIGHEST: Final = 5
PER_900: Final = 6
"""NUMBER: 900 of the field's units are so many of the slot's, 0 for equal. Binary: factor."""

# Kinds of field.
NUMBER: Final = 0
ANGLE: Final = 1
"""ddmm.mmm or dddmm.mmm, the hemisphere in the next field; nanodegrees, south and west negative."""
TIME: Final = 2
"""hhmmss.sss; ms of the day."""
DATE: Final = 3
"""ddmmyy, 1980 … 2079."""
LETTERS: Final = 4
MODES: Final = 5
BINARY: Final = 8
"""From here on: BINARY + bytes, little endian, of a frame; + SIGNED for two's complement."""
SIGNED: Final = 16

EMPTY: Final = 0
GOOD: Final = 1
WRONG: Final = -(1 << 62)
"""The value of a field that is not what it should be; no range includes it."""

MOST_DIGITS: Final = 9
"""Digits before the decimal point; more of them are not a measurement."""
BILLION: Final = 1_000_000_000
SIXTIETH: Final = 0x8888_8889
NINE_HUNDREDTH: Final = 2_443_359_173
HUNDREDTH: Final = 42_949_673
FIFTH: Final = 52_429
"""⌊x/5⌋ = x·⌈2¹⁸/5⌉ >> 18 for 0 ≤ x < 2¹⁶."""
DAY_OF_1980_03_01: Final = 55
UBX_HEADER: Final = 6

DOT: Final = ord(".")
COMMA: Final = ord(",")
MINUS: Final = ord("-")
"""Plus, comma and minus follow each other in ASCII."""


@kernel
def scan(ring, mask, begin, end, decimals):
    """Digits, a point, digits: (digits before the point, −1 when it is no number; their value; the value
    of what follows in 10^−decimals; 10^decimals; the first digit beyond)."""
    whole = np.int64(0)
    part = np.int64(0)
    unit = np.int64(1)
    beyond = np.int64(-1)
    before = np.int64(-1)
    length = np.int64(0)
    for i in range(np.int32(end - begin)):
        digit = np.int64(ring[(begin + i) & mask]) - 48
        if digit == DOT - 48 and before < 0:
            before = length
        elif digit < 0 or digit > 9 or length >= MOST_DIGITS + MOST_DIGITS:
            return np.int64(-1), whole, part, unit, beyond
        else:
            length += 1
            if before < 0:
                whole = whole * 10 + digit
            elif length - before <= decimals:
                part = part * 10 + digit
                unit *= 10
            elif beyond < 0:
                beyond = digit
    if before < 0:
        before = length
    for _ in range(np.int32(max(decimals - (length - before), np.int64(0)))):
        part *= 10
        unit *= 10
    if length == 0 or before > MOST_DIGITS:
        before = np.int64(-1)
    return before, whole, part, unit, beyond


@kernel
def angle(ring, mask, end, degree_digits, whole, part):
    """Nanodegrees of (d)ddmm and `part` nanominutes, the hemisphere at `end` + 1; WRONG when impossible."""
    degrees = (whole * HUNDREDTH) >> 32
    minutes = whole - degrees * 100
    side = np.int64(ring[(end + 1) & mask])
    north_east = side == (ord("N") if degree_digits == 2 else ord("E"))
    south_west = side == (ord("S") if degree_digits == 2 else ord("W"))
    if minutes > 59 or not (north_east or south_west):
        return np.int64(WRONG)
    # a minute is 16 666 666 + 40/60 nanodegrees
    value = degrees * BILLION + minutes * 16_666_666 + (((minutes * 40 + part + 30) * SIXTIETH) >> 37)
    return value if north_east else -value


@kernel
def time_of_day(whole, ms):
    """Milliseconds of hhmmss and `ms`; WRONG when there is no such time. Second 60 only as a leap second."""
    hours_minutes = (whole * HUNDREDTH) >> 32
    seconds = whole - hours_minutes * 100
    hours = (hours_minutes * HUNDREDTH) >> 32
    minutes = hours_minutes - hours * 100
    if hours > 23 or minutes > 59 or seconds > (60 if hours_minutes == 2359 else 59):
        return np.int64(WRONG)
    return ((hours * 60 + minutes) * 60 + seconds) * 1000 + min(ms, np.int64(999))


@kernel
def store_date(s, whole):
    """Day, month and year of ddmmyy into their slots."""
    days_months = (whole * HUNDREDTH) >> 32
    days = (days_months * HUNDREDTH) >> 32
    year = whole - days_months * 100
    s[DAY] = days
    s[MONTH] = days_months - days * 100
    s[YEAR] = year + 1900 if year >= 80 else year + 2000
    s[GOT + DAY] = GOOD
    s[GOT + MONTH] = GOOD
    s[GOT + YEAR] = GOOD


@kernel
def printed(s, ring, row, begin, end):
    """The number, angle, time or date in a span, or WRONG."""
    mask = s[RING_MASK]
    kind = s[row + KIND]
    first = np.int64(ring[begin & mask])
    signed = abs(first - COMMA) == 1
    decimals = np.int64(9) if kind == ANGLE else s[row + DECIMALS]
    digits, whole, part, unit, beyond = scan(ring, mask, begin + 1 if signed else begin, end, decimals)
    if digits < 0 or (signed and kind != NUMBER):
        return np.int64(WRONG)
    if kind == ANGLE:
        side = s[row + PLACE] + 1
        if digits != s[row + DECIMALS] + 2 or side >= s[FIELD_COUNT] or s[FIELD + side + 1] != end + 3:
            return np.int64(WRONG)
        return angle(ring, mask, end, s[row + DECIMALS], whole, part)
    rounded = part + 1 if beyond >= 5 else part
    if kind == TIME:
        return time_of_day(whole, rounded) if digits == 6 else np.int64(WRONG)
    if kind == DATE:
        store_date(s, whole)
        return np.int64(0) if digits == 6 and end - begin == 6 else np.int64(WRONG)
    value = whole * unit + rounded
    if s[row + PER_900] > 0 and value <= s[row + HIGHEST]:
        value = ((value * s[row + PER_900] + 450) * NINE_HUNDREDTH) >> 41
    return -value if first == MINUS else value


@kernel
def letters(ring, mask, begin, end):
    """The characters of a span as one number, the last one in the lowest byte; WRONG when more than four."""
    value = np.int64(0)
    if end - begin > 4:
        return np.int64(WRONG)
    for i in range(np.int32(end - begin)):
        value = value << 8 | np.int64(ring[(begin + i) & mask])
    return value


@kernel
def best_mode(ring, mask, begin, end):
    """The best fix quality (as in GGA) that the mode letters of a span stand for, 0 when none is a valid fix.

    A autonomous 1, D differential and P precise 2, R RTK fixed 4, F RTK float 5; 4 is better than 5.
    """
    best = np.int64(0)
    for i in range(np.int32(end - begin)):
        letter = np.int64(ring[(begin + i) & mask])
        quality = np.int64(0)
        if letter == ord("A"):
            quality = np.int64(1)
        elif letter == ord("D") or letter == ord("P"):
            quality = np.int64(2)
        elif letter == ord("R"):
            quality = np.int64(4)
        elif letter == ord("F"):
            quality = np.int64(5)
        if best != 4 and (quality > best or quality == 4):
            best = quality
    return best


@kernel
def binary(s, ring, row):
    """A little-endian number in the payload of the frame at hand, times the row's factor."""
    mask = s[RING_MASK]
    begin = s[START] + UBX_HEADER + s[row + PLACE]
    kind = s[row + KIND]
    count = kind & 7
    value = np.int64(0)
    for i in range(np.int32(count)):
        value = value << 8 | np.int64(ring[(begin + (count - 1) - i) & mask])
    if kind & SIGNED != 0:
        sign = np.int64(1) << (8 * count - 1)
        value = (value ^ sign) - sign
    return value * s[row + PER_900]


@kernel
def read_fields(s, ring, first, last):
    """Read all fields of the layout rows `first` … `last` − 1 into READ and GOT; False when one is BAD."""
    mask = s[RING_MASK]
    for slot in range(np.int32(SLOTS)):
        s[GOT + slot] = EMPTY
    for i in range(np.int32(last - first)):
        row = LAYOUT + (first + i) * LAYOUT_ROW
        kind = s[row + KIND]
        place = s[row + PLACE]
        slot = s[row + SLOT]
        begin = np.int64(0)
        end = np.int64(0)
        if kind >= BINARY:
            end = np.int64(1)
        elif place < s[FIELD_COUNT]:
            begin = s[FIELD + place]
            end = s[FIELD + place + 1] - 1
        if end > begin:
            if kind >= BINARY:
                value = binary(s, ring, row)
            elif kind == LETTERS:
                value = letters(ring, mask, begin, end)
            elif kind == MODES:
                value = best_mode(ring, mask, begin, end)
            else:
                value = printed(s, ring, row, begin, end)
            if value < s[row + LOWEST] or value > s[row + HIGHEST]:
                return False
            s[slot] = value
            s[GOT + slot] = GOOD
    return True


@kernel
def days_since_1980(year, month, day):
    """Days since 1980-01-06 of a date in 1980 … 2099, or −1 when there is no such date.

    January and February count as months 10 and 11 of the year before; (153·m + 2)/5 days lie before month
    m of a year that starts in March, and every fourth year is a leap year (2000 is one, 2100 excluded).
    """
    if year < 1980 or year > 2099 or month < 1 or month > 12 or day < 1:
        return np.int64(-1)
    short = month == 4 or month == 6 or month == 9 or month == 11
    february = 29 if (year & 3) == 0 else 28
    if day > (february if month == 2 else (30 if short else 31)):
        return np.int64(-1)
    y = year - 1980 if month > 2 else year - 1981
    m = month - 3 if month > 2 else month + 9
    before = ((153 * m + 2) * FIFTH) >> 18
    return y * 365 + (y >> 2) + before + day + (DAY_OF_1980_03_01 - 1)
