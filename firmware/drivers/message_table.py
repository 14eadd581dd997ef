"""What stands where in the messages that are understood: plain data, written into the stream's state.

Sentences: fact sheet sections 2, 3 and 6. Frames: section 4; NAV-TIMEGPS is UBX 01 20 with the leap seconds
in byte 10 and their validity in bit 2 of byte 11. Ranges are those that the quantity can have at all.
Every row is (place, kind, slot, decimals, lowest, highest, factor), see `message_fields`.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers import gnss_epoch as ge
from firmware.drivers import message_fields as mf
from firmware.drivers import receiver_state as st

Row = tuple[int, int, int, int, int, int, int]

U1: Final = mf.BINARY + 1
U2: Final = mf.BINARY + 2
U4: Final = mf.BINARY + 4
I1: Final = mf.BINARY + 1 + mf.SIGNED
I4: Final = mf.BINARY + 4 + mf.SIGNED
ANY_U4: Final = 0xFFFF_FFFF
ANY_I4: Final = 0x7FFF_FFFF


def _number(place: int, slot: int, decimals: int, lowest: int, highest: int, per_900: int = 0) -> Row:
    return (place, mf.NUMBER, slot, decimals, lowest, highest, per_900)


def _position(place: int) -> tuple[Row, Row]:
    quarter = 90_000_000_000
    return (
        (place, mf.ANGLE, ge.LAT_NANODEG, 2, -quarter, quarter, 0),
        (place + 2, mf.ANGLE, ge.LON_NANODEG, 3, -2 * quarter, 2 * quarter, 0),
    )


def _time(place: int) -> Row:
    return (place, mf.TIME, ge.TIME_OF_DAY_MS, 3, 0, 2 * 86_400_000, 0)


def _letters(place: int) -> Row:
    return (place, mf.LETTERS, st.STATUS, 0, 0, ANY_U4, 0)


def _modes(place: int) -> Row:
    return (place, mf.MODES, st.MODE_QUALITY, 0, 0, 9, 0)


def _knots(place: int) -> Row:
    return _number(place, ge.SPEED_MMPS, 3, 0, 4_000_000, 463)


def _kilometres_per_hour(place: int) -> Row:
    return _number(place, ge.SPEED_MMPS, 3, 0, 8_000_000, 250)


def _course(place: int, slot: int = ge.COURSE_E5DEG) -> Row:
    return _number(place, slot, 5, 0, 36_000_000)


def _dilution(place: int, slot: int) -> Row:
    return _number(place, slot, 2, 0, 99_999_999)


def _height(place: int, slot: int) -> Row:
    return _number(place, slot, 3, -10_000_000, 100_000_000)


def _separation(place: int) -> Row:
    return _number(place, st.SEPARATION, 3, -1_000_000, 1_000_000)


def _sigma(place: int, slot: int) -> Row:
    return _number(place, slot, 3, 0, 1_000_000_000)


def _whole(place: int, slot: int, highest: int) -> Row:
    return _number(place, slot, 0, 0, highest)


def _binary(offset: int, kind: int, slot: int, highest: int, factor: int = 1) -> Row:
    return (offset, kind, slot, 0, -highest if kind & mf.SIGNED else 0, highest, factor)


def _list(first_place: int, count: int) -> tuple[Row, ...]:
    return tuple(_whole(first_place + i, st.LIST + i, 999) for i in range(count))


def _heading(place: int) -> Row:
    return _course(place, ge.HEADING_E5DEG)


def _angle(place: int, slot: int, highest_deg: int) -> Row:
    return _number(place, slot, 5, -highest_deg * 100_000, highest_deg * 100_000)


def _angle_sigma(place: int, slot: int) -> Row:
    return _number(place, slot, 5, 0, 36_000_000)


def _heading_pitch_roll(time_place: int) -> tuple[Row, ...]:
    return (
        _time(time_place),
        _heading(time_place + 1),
        _angle(time_place + 2, ge.PITCH_E5DEG, 90),
        _angle(time_place + 3, ge.ROLL_E5DEG, 180),
    )


def _quality(place: int) -> Row:
    return _whole(place, st.ATTITUDE_QUALITY, 99)


NAV_PVT_ROWS: Final = (
    _binary(4, U2, st.YEAR, 0xFFFF),
    _binary(6, U1, st.MONTH, 0xFF),
    _binary(7, U1, st.DAY, 0xFF),
    _binary(8, U1, st.HOUR, 23),
    _binary(9, U1, st.MINUTE, 59),
    _binary(10, U1, st.SECOND, 60),
    _binary(11, U1, st.VALID_BITS, 0xFF),
    _binary(16, I4, st.NANO, 1_000_000_000),
    _binary(20, U1, ge.FIX_TYPE, 5),
    _binary(21, U1, st.FIX_BITS, 0xFF),
    _binary(23, U1, ge.SATELLITES, 0xFF),
    _binary(24, I4, ge.LON_NANODEG, 180_000_000_000, 100),
    _binary(28, I4, ge.LAT_NANODEG, 90_000_000_000, 100),
    _binary(32, I4, ge.HEIGHT_MM, ANY_I4),
    _binary(36, I4, ge.HEIGHT_MSL_MM, ANY_I4),
    _binary(40, U4, ge.H_ACC_MM, ANY_U4),
    _binary(44, U4, ge.V_ACC_MM, ANY_U4),
    _binary(48, I4, ge.VEL_N_MMPS, ANY_I4),
    _binary(52, I4, ge.VEL_E_MMPS, ANY_I4),
    _binary(56, I4, ge.VEL_D_MMPS, ANY_I4),
    _binary(60, I4, ge.SPEED_MMPS, ANY_I4),
    _binary(64, I4, ge.COURSE_E5DEG, 36_000_000),
    _binary(68, U4, ge.S_ACC_MMPS, ANY_U4),
    _binary(72, U4, st.COURSE_SIGMA, ANY_U4),
    _binary(76, U2, ge.PDOP_CENTI, 0xFFFF),
)

PUBX_00_ROWS: Final = (
    _time(2),
    *_position(3),
    _height(7, ge.HEIGHT_MM),
    _letters(8),
    _sigma(9, ge.H_ACC_MM),
    _sigma(10, ge.V_ACC_MM),
    _kilometres_per_hour(11),
    _course(12),
    _number(13, ge.VEL_D_MMPS, 3, -1_000_000, 1_000_000),
    _dilution(15, ge.HDOP_CENTI),
    _dilution(16, ge.VDOP_CENTI),
    _whole(18, ge.SATELLITES, 999),
)

SENTENCES: Final[dict[int, tuple[str, int, tuple[Row, ...]]]] = {
    # message: (type, rank, rows); a field told by several messages stays with the finest
    st.GGA: (
        "GGA",
        2,
        (
            _time(1),
            *_position(2),
            _whole(6, ge.FIX_QUALITY, 9),
            _whole(7, ge.SATELLITES, 999),
            _dilution(8, ge.HDOP_CENTI),
            _height(9, ge.HEIGHT_MSL_MM),
            _separation(11),
        ),
    ),
    st.RMC: (
        "RMC",
        1,
        (
            _time(1),
            _letters(2),
            *_position(3),
            _knots(7),
            _course(8),
            (9, mf.DATE, ge.DATE_DAYS, 0, 0, 0, 0),
            _modes(12),
        ),
    ),
    st.GSA: (
        "GSA",
        1,
        (
            _whole(2, ge.FIX_TYPE, 3),
            *_list(3, 12),
            _dilution(15, ge.PDOP_CENTI),
            _dilution(16, ge.HDOP_CENTI),
            _dilution(17, ge.VDOP_CENTI),
        ),
    ),
    st.GSV: ("GSV", 1, (_whole(1, st.SERIES_LENGTH, 99), _whole(2, st.SERIES_NUMBER, 99), *_list(4, 16))),
    st.GLL: ("GLL", 1, (*_position(1), _time(5), _letters(6), _modes(7))),
    st.VTG: ("VTG", 1, (_course(1), _letters(2), _kilometres_per_hour(7), _knots(5), _modes(9))),
    st.ZDA: ("ZDA", 1, (_time(1), _whole(2, st.DAY, 99), _whole(3, st.MONTH, 99), _whole(4, st.YEAR, 9999))),
    st.GNS: (
        "GNS",
        1,
        (
            _time(1),
            *_position(2),
            _modes(6),
            _whole(7, ge.SATELLITES, 999),
            _dilution(8, ge.HDOP_CENTI),
            _height(9, ge.HEIGHT_MSL_MM),
            _separation(10),
        ),
    ),
    st.GST: (
        "GST",
        1,
        (_time(1), _sigma(6, st.NORTH_SIGMA), _sigma(7, st.EAST_SIGMA), _sigma(8, ge.V_ACC_MM)),
    ),
    st.PUBX_00: ("00", 3, PUBX_00_ROWS),
    st.HDT: ("HDT", 1, (_heading(1), _letters(2))),
    st.THS: ("THS", 1, (_heading(1), _letters(2))),
    st.PASHR: (
        "SHR",
        2,
        (
            _time(1),
            _heading(2),
            _letters(3),
            _angle(4, ge.ROLL_E5DEG, 180),
            _angle(5, ge.PITCH_E5DEG, 90),
            _angle_sigma(7, ge.ROLL_SIGMA_E5DEG),
            _angle_sigma(8, ge.PITCH_SIGMA_E5DEG),
            _angle_sigma(9, ge.HEADING_SIGMA_E5DEG),
            _quality(10),
        ),
    ),
    st.PASHR_HPR: ("RHPR", 2, (*_heading_pitch_roll(2), _quality(8))),
    st.PSAT_HPR: ("THPR", 2, (*_heading_pitch_roll(2), _letters(6))),
    st.HPR: ("HPR", 2, (*_heading_pitch_roll(1), _quality(5))),
    st.PTNL_AVR: (
        "LAVR",
        2,
        (
            _time(2),
            _heading(3),
            _angle(5, ge.PITCH_E5DEG, 90),
            _angle(7, ge.ROLL_E5DEG, 180),
            _number(9, ge.BASELINE_MM, 3, 0, 1_000_000),
            _quality(10),
        ),
    ),
    # "16D" are default leap seconds, not received ones: the letters, not a number
    st.PUBX_04: ("04", 1, (_letters(6),)),
    st.TXT: ("TXT", 1, ()),
}

FRAMES: Final[dict[int, tuple[int, int, tuple[Row, ...]]]] = {
    st.NAV_PVT: (0x0107, 4, NAV_PVT_ROWS),
    st.NAV_TIMEGPS: (0x0120, 1, (_binary(10, I1, st.LEAP_READ, 127), _binary(11, U1, st.VALID_BITS, 0xFF))),
}

FLAG_OF: Final = {
    ge.DATE_DAYS: ge.HAS_DATE,
    ge.LAT_NANODEG: ge.HAS_POSITION,
    ge.HEIGHT_MM: ge.HAS_HEIGHT,
    ge.HEIGHT_MSL_MM: ge.HAS_HEIGHT_MSL,
    ge.SPEED_MMPS: ge.HAS_SPEED,
    ge.COURSE_E5DEG: ge.HAS_COURSE,
    ge.VEL_D_MMPS: ge.HAS_VELOCITY,
    ge.H_ACC_MM: ge.HAS_ACCURACY,
    ge.HEADING_E5DEG: ge.HAS_HEADING,
    ge.PITCH_E5DEG: ge.HAS_PITCH,
    ge.ROLL_E5DEG: ge.HAS_ROLL,
    ge.HEADING_SIGMA_E5DEG: ge.HAS_ATTITUDE_ACCURACY,
    ge.BASELINE_MM: ge.HAS_BASELINE,
}


def write_tables(state: NDArray[np.int64]) -> None:
    """Write the constant part of the state."""
    for field, flag in FLAG_OF.items():
        state[st.FLAG_OF + field] = flag
    codes = {
        m: (int.from_bytes(name.encode(), "big"), rank, rows) for m, (name, rank, rows) in SENTENCES.items()
    }
    begin = 0
    for message, (code, rank, rows) in (codes | FRAMES).items():
        row = st.MESSAGES + message * st.MESSAGE_ROW
        state[row : row + st.MESSAGE_ROW] = (code, begin, begin + len(rows), rank)
        for layout in rows:
            place = st.LAYOUT + begin * st.LAYOUT_ROW
            state[place : place + st.LAYOUT_ROW] = layout
            begin += 1
