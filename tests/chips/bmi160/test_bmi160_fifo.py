"""FIFO byte streams worked out by hand (fact sheet section 6)."""

from __future__ import annotations

from struct import pack, unpack

import pytest
from bmi160_fifo_rig import ACCEL_ON, GYRO_ON, HEADER, TIME, counting, fifo_rig, length, steady
from bmi160_rig import BYTE_NS, MS
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

GYRO = bytes.fromhex("6806 0000 98f9")  # 100, 0, −100 deg/s at 16.4: 1640, 0, −1640
ACCEL = bytes.fromhex("0020 0000 0040")  # 0.5, 0, 1 g at 16384: 8192, 0, 16384


def test_header_mode_frames_of_both_sensors() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER)
    rig.until(320 * MS + 1)
    assert length(rig) == 39
    assert rig.read(0x24, 39) == 3 * (b"\x8c" + GYRO + ACCEL)
    assert length(rig) == 0


@pytest.mark.parametrize(("config", "frame"), [(GYRO_ON, b"\x88" + GYRO), (ACCEL_ON, b"\x84" + ACCEL)])
def test_header_mode_frames_of_one_sensor(config: int, frame: bytes) -> None:
    rig = fifo_rig(config | HEADER)
    rig.until(320 * MS + 1)
    assert rig.read(0x24, 21) == 3 * frame


def test_header_mode_frames_of_two_rates() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER, steady, (0x40, 0x27))  # accelerometer 50 Hz
    rig.until(330 * MS + 1)
    both, gyro = b"\x8c" + GYRO + ACCEL, b"\x88" + GYRO
    assert rig.read(0x24, 40) == both + gyro + both + gyro


@pytest.mark.parametrize(
    ("config", "data"), [(GYRO_ON | ACCEL_ON, GYRO + ACCEL), (GYRO_ON, GYRO), (ACCEL_ON, ACCEL)]
)
def test_headerless_frames(config: int, data: bytes) -> None:
    rig = fifo_rig(config)
    rig.until(320 * MS + 1)
    assert length(rig) == 3 * len(data)
    assert rig.read(0x24, 3 * len(data)) == 3 * data


# -- reading beyond the end --------------------------------------------------------------------------------


def test_over_read_in_header_mode() -> None:
    rig = fifo_rig(GYRO_ON | HEADER)
    rig.until(300 * MS + 1)
    assert rig.read(0x24, 12) == b"\x88" + GYRO + b"\x80" * 5
    assert rig.read(0x24, 3) == b"\x80" * 3


def test_over_read_without_headers() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON)
    rig.until(300 * MS + 1)
    assert rig.read(0x24, 24) == GYRO + ACCEL + b"\x80\x00" * 6


def test_sensor_time_frame_behind_the_last_frame() -> None:
    rig = fifo_rig(ACCEL_ON | HEADER | TIME)
    rig.until(300 * MS + 5_000)
    ticks = 300_005_000 * 25600 // 10**9
    assert rig.read(0x24, 14) == b"\x84" + ACCEL + b"\x44" + ticks.to_bytes(3, "little") + b"\x80" * 3


def test_empty_fifo_still_tells_the_time() -> None:
    rig = fifo_rig(HEADER | TIME)
    rig.until(300 * MS)
    assert rig.read(0x24, 6) == b"\x44" + (7680).to_bytes(3, "little") + b"\x80\x80"
    assert length(rig) == 0


def test_no_sensor_time_frame_while_frames_are_left() -> None:
    rig = fifo_rig(ACCEL_ON | HEADER | TIME)
    rig.until(310 * MS + 5_000)
    assert rig.read(0x24, 7) == b"\x84" + ACCEL
    assert rig.read(0x24, 8) == b"\x84" + ACCEL + b"\x44"


# -- partial reads ------------------------------------------------------------------------------------------


def test_frame_read_in_part_comes_again_whole() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER, counting)
    rig.until(320 * MS + 1)
    whole = b"".join(
        b"\x8c" + pack("<6h", round(1640 * t), 0, 0, round(16384 * t), 0, 0) for t in (0.30, 0.31, 0.32)
    )
    assert rig.read(0x24, 20) == whole[:20]
    assert length(rig) == 26
    assert rig.read(0x24, 12) == whole[13:25]
    assert length(rig) == 26
    assert rig.read(0x24, 26) == whole[13:]


def test_length_and_data_in_one_burst() -> None:
    rig = fifo_rig(GYRO_ON | HEADER)
    rig.until(310 * MS + 1)
    assert rig.read(0x22, 16) == b"\x0e\x00" + 2 * (b"\x88" + GYRO)


# -- overrun -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("config", "frame", "fit"),
    [
        (GYRO_ON | ACCEL_ON | HEADER, 13, 78),
        (GYRO_ON | HEADER, 7, 146),
        (GYRO_ON | ACCEL_ON, 12, 85),
        (ACCEL_ON, 6, 170),
    ],
)
def test_capacity_and_oldest_dropped(config: int, frame: int, fit: int) -> None:
    rig = fifo_rig(config, counting)
    header = bool(config & HEADER)
    rig.until(300 * MS + (fit - 1) * 10 * MS + 1)
    assert length(rig) == fit * frame
    rig.wait(30 * MS)
    assert length(rig) == fit * frame + (2 if header else 0)
    data = rig.read(0x24, fit * frame + (2 if header else 0))
    if header:
        assert data[:2] == b"\x40\x03"
        data = data[2:]
    first = unpack("<h", data[header : header + 2])[0]
    t = 0.300 + 0.030
    assert first == round((1640 if config & GYRO_ON else 16384) * t)
    assert length(rig) == 0


def test_skip_count_saturates() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER)
    rig.until(300 * MS + 5_000 * MS + 1)
    assert rig.read(0x24, 3) == b"\x40\xff\x8c"
    assert length(rig) == 78 * 13


def test_skip_frame_is_told_once() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER)
    rig.until(300 * MS + 780 * MS + 1)
    assert rig.read(0x24, 15) == b"\x40\x01\x8c" + GYRO + ACCEL
    assert rig.read(0x24, 1) == b"\x8c"


# -- set-up --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("downs", "every"), [(0x80 | 0x08, 1), (0x90 | 0x08 | 1, 2), (0xA0 | 0x08 | 2, 4)])
def test_downsampling(downs: int, every: int) -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON, counting, (0x45, downs))
    rig.until(400 * MS - 1)
    data = rig.read(0x24, length(rig))
    stored = [unpack("<6h", data[i : i + 12]) for i in range(0, len(data), 12)]
    times = [n / 100 for n in range(30, 40) if n % every == 0]
    assert [frame[0] for frame in stored] == [round(1640 * t) for t in times]
    assert [frame[3] for frame in stored] == [round(16384 * t) for t in times]


def test_unfiltered_data_come_at_the_internal_rate() -> None:
    """Accelerometer 1600 Hz, gyroscope 3200 Hz, thinned out by 2^4 and 2^5: one frame every 10 ms."""
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER, counting, (0x45, 0x45))
    rig.until(330 * MS + 1)
    frames = rig.read(0x24, length(rig))
    expected = b"".join(
        b"\x8c" + pack("<6h", round(1640 * t), 0, 0, round(16384 * t), 0, 0) for t in (0.30, 0.31, 0.32, 0.33)
    )
    assert frames == expected


def test_unfiltered_gyroscope_at_full_rate() -> None:
    rig = fifo_rig(GYRO_ON, counting, (0x45, 0x80))
    rig.until(310 * MS - 1)
    data = rig.read(0x24, 32 * 6)
    x = [unpack("<h", data[i : i + 2])[0] for i in range(0, len(data), 6)]
    assert x == [round(1640 * n / 3200) for n in range(957, 957 + 32)]  # from 299.06 ms on


def test_flush_empties_and_keeps_the_configuration() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER)
    rig.until(2_000 * MS + 1)
    assert length(rig) == 1016
    rig.write(0x7E, 0xB0, gap_ns=2_000)
    assert length(rig) == 0
    assert rig.read(0x47) == bytes((GYRO_ON | ACCEL_ON | HEADER,))
    rig.until(2_010 * MS + 1)
    assert rig.read(0x24, 13) == b"\x8c" + GYRO + ACCEL


def test_changing_between_header_modes_empties() -> None:
    rig = fifo_rig(GYRO_ON | HEADER)
    rig.until(320 * MS + 1)
    rig.write(0x47, GYRO_ON, gap_ns=2_000)
    assert length(rig) == 0
    rig.until(330 * MS + 1)
    rig.write(0x47, GYRO_ON | HEADER, gap_ns=2_000)
    assert length(rig) == 0


def test_changing_the_sensors_empties_only_without_headers() -> None:
    rig = fifo_rig(GYRO_ON | HEADER)
    rig.until(310 * MS + 1)
    rig.write(0x47, GYRO_ON | ACCEL_ON | HEADER, gap_ns=2_000)
    rig.until(320 * MS + 1)
    assert rig.read(0x24, 27) == 2 * (b"\x88" + GYRO) + b"\x8c" + GYRO + ACCEL
    rig.write(0x47, GYRO_ON, gap_ns=2_000)
    rig.until(330 * MS + 1)
    rig.write(0x47, GYRO_ON | ACCEL_ON, gap_ns=2_000)
    assert length(rig) == 0


@pytest.mark.parametrize(
    ("register", "value", "bit"),
    [(0x40, 0x29, 0x01), (0x41, 0x05, 0x02), (0x42, 0x18, 0x04), (0x43, 0x01, 0x08)],
)
def test_config_change_frame_in_front_of_the_next_data(register: int, value: int, bit: int) -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER)
    rig.until(300 * MS + 1)
    rig.write(register, value, gap_ns=2_000)
    assert length(rig) == 13
    rig.until(310 * MS + 1)
    data = rig.read(0x24, 40)
    assert data[:15] == b"\x8c" + GYRO + ACCEL + bytes((0x48, bit))


def test_no_config_change_frame_for_a_sensor_that_is_not_stored() -> None:
    rig = fifo_rig(GYRO_ON | HEADER)
    rig.write(0x41, 0x05, gap_ns=2_000)
    rig.until(300 * MS + 1)
    assert rig.read(0x24, 7) == b"\x88" + GYRO


def test_suspended_sensor_is_not_stored() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER)
    rig.until(300 * MS + 1)
    rig.write(0x7E, 0x14, gap_ns=2_000)
    rig.until(310 * MS + 1)
    assert rig.read(0x24, 20) == b"\x8c" + GYRO + ACCEL + b"\x84" + ACCEL


def test_fifo_off_stores_nothing() -> None:
    rig = fifo_rig(HEADER)
    rig.until(1_000 * MS)
    assert length(rig) == 0


# -- tags ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pin", "latch", "tag", "bit"), [("INT1", 0x10, 0x08, 0x01), ("INT2", 0x20, 0x04, 0x02)]
)
def test_tags_of_the_interrupt_inputs(pin: str, latch: int, tag: int, bit: int) -> None:
    rig = fifo_rig(ACCEL_ON | HEADER | tag, steady, (0x54, latch))
    for at, level in ((305, True), (325, False), (334, True), (336, False)):
        rig.until(at * MS)
        rig.nets[pin].set(level)
    rig.until(350 * MS + 1)
    data = rig.read(0x24, 42)
    assert [data[i] for i in range(0, 42, 7)] == [0x84, 0x84 | bit, 0x84 | bit, 0x84, 0x84, 0x84]


def test_no_tag_unless_enabled() -> None:
    rig = fifo_rig(ACCEL_ON | HEADER, steady, (0x54, 0x30))
    rig.nets["INT1"].set(True)
    rig.until(300 * MS + 1)
    assert rig.read(0x24, 1) == b"\x84"


# -- interrupts ----------------------------------------------------------------------------------------------

WATERMARK_ON_INT1 = ((0x53, 0x0A), (0x56, 0x40), (0x51, 0x40))
FULL_ON_INT1 = ((0x53, 0x0A), (0x56, 0x20), (0x51, 0x20))


def test_watermark_interrupt_follows_the_fill_level() -> None:
    """Watermark 13 · 4 = 52 bytes: the fourth frame reaches it, at 330 ms."""
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER, steady, *WATERMARK_ON_INT1, (0x46, 13), listen="INT1")
    rig.edges["INT1"].clear()
    rig.until(335 * MS)
    assert rig.edges["INT1"] == [(330 * MS, True)]
    assert rig.read(0x1D)[0] & 0x40
    rig.read(0x24, 13)
    assert rig.edges["INT1"][-1] == (335 * MS + 2 * BYTE_NS, False)
    assert not rig.read(0x1D)[0] & 0x40
    rig.until(345 * MS)
    assert rig.edges["INT1"][-1] == (340 * MS, True)


def test_default_watermark_is_512_bytes() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON, steady, (0x51, 0x40))
    rig.until(300 * MS + 41 * 10 * MS + 1)  # 42 frames of 12 bytes: 504
    assert rig.read(0x1D) == b"\x00"
    rig.until(300 * MS + 42 * 10 * MS + 1)
    assert rig.read(0x1D) == b"\x40"


def test_watermark_zero_never_fires() -> None:
    rig = fifo_rig(GYRO_ON, steady, (0x46, 0), (0x51, 0x40))
    rig.until(2_000 * MS)
    assert rig.read(0x1D) == b"\x00"


def test_full_interrupt_when_the_next_frame_would_not_fit() -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER, steady, *FULL_ON_INT1, listen="INT1")
    rig.edges["INT1"].clear()
    rig.until(1_200 * MS)
    assert rig.edges["INT1"] == [(300 * MS + 77 * 10 * MS, True)]
    assert rig.read(0x1D) == b"\x20"
    rig.write(0x7E, 0xB0, gap_ns=2_000)
    assert rig.read(0x1D) == b"\x00"
    assert not rig.nets["INT1"].level


@settings(max_examples=25, deadline=None, phases=(Phase.explicit, Phase.reuse, Phase.generate))
@given(
    accel_code=st.integers(5, 10),
    gyro_code=st.integers(6, 10),
    watermark=st.integers(1, 250),
    config=st.sampled_from([GYRO_ON, ACCEL_ON, GYRO_ON | ACCEL_ON]),
    range_change=st.booleans(),
)
def test_watermark_edge_comes_with_the_sample_that_reaches_it(
    accel_code: int, gyro_code: int, watermark: int, config: int, range_change: bool
) -> None:
    """The edge, foreseen without an event a sample, against the fill level looked at every millisecond."""
    writes = ((0x40, 0x20 | accel_code), (0x42, 0x20 | gyro_code), (0x46, watermark), *WATERMARK_ON_INT1)
    followed, polled = (fifo_rig(config | HEADER, steady, *writes, listen=listen) for listen in ("INT1", ""))
    for rig in (followed, polled):
        if range_change:
            rig.write(0x41, 0x05, gap_ns=2_000)
    followed.until(6_000 * MS)
    for _ in range(5_700):
        polled.wait(1 * MS)
        if length(polled) >= 4 * watermark:
            break
    reached = [when for when, level in followed.edges["INT1"] if level]
    if length(polled) < 4 * watermark:
        assert reached == []
    else:
        assert len(reached) == 1
        assert 0 <= polled.time.now - reached[0] < 2 * MS
