"""ATTITUDE frames: what a record says comes out at the other end, whatever the numbers."""

from __future__ import annotations

import math
from struct import Struct

import numpy as np
import pytest
from crcmod.predefined import mkPredefinedCrcFun
from hypothesis import given
from hypothesis import strategies as some

from firmware.link.attitude_output import AttitudeOutput
from firmware.link.frames import ATTITUDE, FrameWriter
from firmware.nav.attitude import layout as at
from host.link.attitude import flag_name, solution_rows
from host.link.decoder import LinkDecoder
from host.link.messages import SOLUTION_DTYPE, Solution, solution_array

LAYOUT = Struct("<QBHHqqq12i")
WIDE = some.integers(-(1 << 62), 1 << 62)
AttitudeOutput(FrameWriter())  # compiles what no example shall wait for
ANGLE = some.integers(-3_141_592_654, 6_283_185_307)


@given(
    some.lists(WIDE, min_size=at.OUT_SIZE, max_size=at.OUT_SIZE),
    some.integers(0, (1 << 63) - 1),
    some.integers(0, 255),
    some.integers(0, 0xFFFF),
    some.integers(0, 0xFFFF),
)
def test_any_record_is_packed_and_saturates(
    record: list[int], time_us: int, mode: int, flags: int, age_us: int
) -> None:
    frame = AttitudeOutput(FrameWriter()).pack(np.array(record, np.int64), time_us, mode, flags, age_us)
    assert frame[:5] == bytes((0xA5, 0x5A, ATTITUDE, LAYOUT.size, 0))
    crc = mkPredefinedCrcFun("crc-ccitt-false")(frame[2:-2])
    assert frame[-2:] == crc.to_bytes(2, "little")
    told = LAYOUT.unpack(frame[5:-2])
    assert told[:4] == (time_us, mode, flags, age_us)
    assert told[4:7] == tuple(record[at.OUT_LATITUDE : at.OUT_LATITUDE + 3])

    def held(value: float) -> int:
        return max(-(1 << 31), min((1 << 31) - 1, math.floor(value)))

    places = (*(at.OUT_YAW + n for n in range(3)), *(at.OUT_RATE + n for n in range(3)))
    places += tuple(at.OUT_GYRO_BIAS + n for n in range(3))
    assert told[7:10] == tuple(held(record[at.OUT_VELOCITY + n]) for n in range(3))
    assert told[10:] == tuple(held((record[place] + 2) // 4) for place in places)


@given(yaw=some.integers(0, 6_283_185_306), pitch=some.integers(-1_570_796_327, 1_570_796_327), roll=ANGLE)
def test_angles_come_back_to_two_nanoradians(yaw: int, pitch: int, roll: int) -> None:
    record = np.zeros(at.OUT_SIZE, np.int64)
    record[at.OUT_YAW : at.OUT_YAW + 3] = yaw, pitch, roll
    frame = AttitudeOutput(FrameWriter()).pack(record, 5_000_000, 3, 0, 100)
    ((kind, message),) = LinkDecoder().feed(frame)
    assert kind == ATTITUDE
    assert isinstance(message, Solution)
    for told, true in ((message.yaw, yaw), (message.pitch, pitch), (message.roll, roll)):
        assert told == pytest.approx(true * 1e-9, abs=2.1e-9)
    rows = solution_rows(ATTITUDE, [frame[5:-2]])
    assert rows["yaw"][0] == pytest.approx(message.yaw, abs=1e-15)
    assert rows["roll"][0] == pytest.approx(message.roll, abs=1e-15)
    assert np.isnan(rows["sigma_attitude"]).all()


def test_frames_are_numbered_with_the_others() -> None:
    writer = FrameWriter()
    output = AttitudeOutput(writer)
    record = np.zeros(at.OUT_SIZE, np.int64)
    stream = writer.text("a") + output.pack(record, 1, 3, 0, 0) + writer.text("b")
    decoder = LinkDecoder()
    assert [kind for kind, _ in decoder.feed(stream)] == [8, ATTITUDE, 8]
    assert decoder.lost == decoder.bad_crc == 0


def test_flags_stand_behind_those_of_a_solution() -> None:
    frame = AttitudeOutput(FrameWriter()).pack(np.zeros(at.OUT_SIZE, np.int64), 1, 3, 0b1001, 0)
    ((_, message),) = LinkDecoder().feed(frame)
    assert isinstance(message, Solution)
    assert [flag_name(bit) for bit in range(32) if message.flags >> bit & 1] == ["stale", "gyro_saturated"]
    assert flag_name(12) == "gnss_lost"
    assert flag_name(31) == "flag_31"


def test_rows_of_solution_frames_are_the_same_numbers() -> None:
    payload = bytes(range(SOLUTION_DTYPE.itemsize))
    wide, narrow = solution_rows(1, [payload, payload]), solution_array([payload, payload])
    assert len(wide) == 2
    for name in SOLUTION_DTYPE.names or ():
        assert np.array_equal(wide[name], narrow[name].astype(wide[name].dtype), equal_nan=True)
