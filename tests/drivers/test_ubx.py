"""UBX frames: made as the fact sheet and pyubx2 make them; NAV-PVT into the epoch."""

import struct

import pytest
import pyubx2
from hypothesis import given, settings
from hypothesis import strategies as some
from receiver_line import ReceiverLine

from firmware.drivers import gnss_epoch as ge
from firmware.drivers import receiver_state as st
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.ubx import frame

PVT_FORMAT = struct.Struct("<IHBBBBBBIiBBBBiiiiIIiiiiiIIHBB4xihH")
"""The layout table of fact sheet section 4, written down once more."""
PVT = {
    "itow": 0, "year": 2024, "month": 3, "day": 15, "hour": 9, "minute": 27, "second": 25,
    "valid": 7, "tacc": 20, "nano": 0, "fix_type": 3, "flags": 1, "flags2": 0, "satellites": 14,
    "lon": -42_590_535, "lat": 505_020_575, "height": 135_500, "msl": 87_400, "h_acc": 1100,
    "v_acc": 1700, "v_n": 8660, "v_e": 5000, "v_d": -250, "speed": 10_000, "course": 3_000_000,
    "s_acc": 120, "course_acc": 100_000, "pdop": 156, "flags3": 0, "r": 0, "heading": 0, "dec": 0,
    "mag_acc": 0,
}  # fmt: skip


def pvt(**changes: int) -> bytes:
    return frame(0x0107, PVT_FORMAT.pack(*(PVT | changes).values()))


def pvt_epoch(**changes: int) -> dict[str, int]:
    line = ReceiverLine()
    line.send(pvt(**changes))
    line.silence()
    (epoch,) = line.epochs
    return epoch


@pytest.mark.parametrize(
    ("message", "payload", "expected"),
    [
        (0x0A04, "", "B5 62 0A 04 00 00 0E 34"),
        (0x0107, "", "B5 62 01 07 00 00 08 19"),
        (0x0608, "E8 03 01 00 01 00", "B5 62 06 08 06 00 E8 03 01 00 01 00 01 39"),
        (0x0601, "01 07 01", "B5 62 06 01 03 00 01 07 01 13 51"),
        (0x0501, "06 08", "B5 62 05 01 02 00 06 08 16 3F"),
    ],
)
def test_frames_are_those_of_the_fact_sheet(message, payload, expected):
    assert frame(message, bytes.fromhex(payload)) == bytes.fromhex(expected)


@settings(max_examples=50, deadline=None)
@given(some.integers(0, 0xFFFF), some.binary(max_size=300))
def test_frames_are_those_of_pyubx2(message, payload):
    made = frame(message, payload)
    assert made[-2:] == pyubx2.calc_checksum(made[2:-2])
    assert made[4:6] == len(payload).to_bytes(2, "little")


def test_nav_pvt():
    epoch = pvt_epoch()
    assert (epoch["lat_nanodeg"], epoch["lon_nanodeg"]) == (50_502_057_500, -4_259_053_500)
    assert (epoch["vel_n_mmps"], epoch["vel_e_mmps"], epoch["vel_d_mmps"]) == (8660, 5000, -250)
    assert (epoch["height_mm"], epoch["height_msl_mm"]) == (135_500, 87_400)
    assert epoch["time_of_day_ms"] == ((9 * 60 + 27) * 60 + 25) * 1000
    everything = 1 | 2 | 4 | 8 | 16 | 32 | 64 | 128 | 256
    assert epoch["flags"] == everything


@pytest.mark.parametrize(
    ("changes", "quality", "flags"),
    [
        ({"fix_type": 0, "flags": 0}, 0, ge.HAS_TIME | ge.HAS_DATE),
        ({"flags": 0}, 0, ge.HAS_TIME | ge.HAS_DATE),
        ({"fix_type": 1}, 6, ge.HAS_TIME | ge.HAS_DATE),
        ({"fix_type": 5}, 0, ge.HAS_TIME | ge.HAS_DATE),
        ({"flags": 3}, 2, 0x1FF),
        ({"flags": 1 | 1 << 6}, 5, 0x1FF),
        ({"flags": 1 | 2 << 6}, 4, 0x1FF),
        ({"fix_type": 2}, 1, 0x1FF & ~(ge.HAS_HEIGHT | ge.HAS_HEIGHT_MSL | ge.HAS_VELOCITY)),
        ({"course_acc": 18_000_000}, 1, 0x1FF & ~ge.HAS_COURSE),
        ({"valid": 1}, 1, 0x1FF & ~(ge.HAS_TIME | ge.HAS_DATE)),
        ({"valid": 2}, 1, 0x1FF & ~ge.HAS_DATE),
    ],
)
def test_nav_pvt_validity(changes, quality, flags):
    epoch = pvt_epoch(**changes)
    assert (epoch["fix_quality"], epoch["flags"]) == (quality, flags)


@pytest.mark.parametrize(
    ("changes", "time_ms", "day"),
    [
        ({"nano": -400_000}, 34_045_000, 15),
        ({"nano": -500_001}, 34_044_999, 15),
        ({"nano": 799_899_687}, 34_045_800, 15),
        ({"hour": 0, "minute": 0, "second": 0, "nano": -3_000_000}, 86_399_997, 14),
        ({"hour": 23, "minute": 59, "second": 60, "nano": 0}, 86_400_000, 15),
    ],
)
def test_nanoseconds_of_either_sign(changes, time_ms, day):
    epoch = pvt_epoch(**changes)
    assert epoch["time_of_day_ms"] == time_ms
    assert epoch["date_days"] - pvt_epoch(day=1)["date_days"] == day - 1


@pytest.mark.parametrize(
    "changes",
    [{"lat": 900_000_001}, {"lon": -1_800_000_001}, {"hour": 24}, {"fix_type": 6}, {"month": 13}, {"day": 0}],
)
def test_impossible_values_spoil_the_frame(changes):
    line = ReceiverLine()
    line.send(pvt(**changes))
    line.silence()
    assert line.epochs == []
    assert line.stream.statistics().malformed == 1


def test_sentences_and_frames_of_one_epoch_are_one_epoch():
    line = ReceiverLine(ReceiverStream(last_message=st.NAV_PVT))
    gga = b"$GNGGA,092725.00,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,*6E\r\n"
    line.send(gga + pvt(nano=-3_000_000, lat=505_020_570))
    (epoch,) = line.epochs
    assert (epoch["lat_nanodeg"], epoch["hdop_centi"], epoch["satellites"]) == (50_502_057_000, 95, 14)


def test_frames_without_a_time_are_told_apart_by_repetition():
    line = ReceiverLine()
    line.chunks([pvt(valid=0), pvt(valid=0), pvt(valid=0)])
    line.silence()
    assert len(line.epochs) == 3


def test_acknowledgements_are_noted():
    stream = ReceiverStream()
    line = ReceiverLine(stream)
    line.send(frame(0x0501, b"\x06\x08") + frame(0x0500, b"\x06\x01") + frame(0x0A04, bytes(70)))
    state = stream.state
    assert (state[st.ACKS], state[st.ACK_OF]) == (1, 0x0608)
    assert (state[st.NAKS], state[st.NAK_OF]) == (1, 0x0601)
    assert state[st.VERSIONS] == 1


def test_leap_seconds_of_nav_timegps():
    line = ReceiverLine()
    line.send(frame(0x0120, struct.pack("<IihbBI", 0, 0, 2300, 17, 3, 0)) + pvt())
    line.silence()
    line.send(frame(0x0120, struct.pack("<IihbBI", 0, 0, 2300, 18, 7, 0)) + pvt(second=26))
    line.silence()
    assert [epoch["leap_seconds"] for epoch in line.epochs] == [0, 18]
