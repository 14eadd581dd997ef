"""The unit's frames against closed forms, its clock, limits, supply and defects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from serial_imu_rig import MS, Motion, Rig

G = 9.80665
TRANSCRIPT = Path(__file__).with_name("serial_imu_golden.txt")


def test_frames_come_at_200_hz_on_its_own_clock() -> None:
    rig = Rig(clock_error_ppm=100.0)
    rig.wait(1500 * MS)
    frames = rig.frames()
    assert [frame.counter for frame in frames] == list(range(len(frames)))
    # the first period ends 500 ms after the supply; a frame begins 0.1 ms later and has 320 bits
    period = 10**18 // (200 * 1_000_100_000)
    expected = [
        500 * MS + n * 10**18 // (200 * 1_000_100_000) + 100_000 + 320 * 10**9 // 230_400 for n in range(200)
    ]
    assert max(abs(frame.end_ns - at) for frame, at in zip(frames, expected, strict=False)) <= 2
    assert len(frames) == 1 + (1000 * MS - 100_000 - 320 * 10**9 // 230_400) // period


def test_increments_are_the_integrals() -> None:
    """sin and a ramp: midpoint sums of four are within (ωh)²/24 of the integral."""
    turning = 2 * np.pi * 2.0
    rig = Rig(
        Motion(wx=lambda t: 0.5 * np.sin(turning * t), fz=lambda t: -G + 3.0 * t, fy=lambda t: 1.0 + 0 * t)
    )
    rig.wait(1505 * MS)
    frames = rig.frames()
    ends = [(500 + 5 * n) * 1e-3 for n in range(len(frames))]
    for frame, end in zip(frames, ends, strict=True):
        begin = end - 5e-3
        angle = 0.5 / turning * (np.cos(turning * begin) - np.cos(turning * end))
        assert frame.angle[0] * 1e-9 == pytest.approx(angle, abs=2e-9 + abs(angle) * 1e-5)
        assert frame.velocity[2] * 1e-8 == pytest.approx(-G * 5e-3 + 1.5 * (end**2 - begin**2), abs=2e-8)
    assert rig.world.bandwidths == {400.0}
    # rounding does not pile up
    assert sum(f.velocity[1] for f in frames) * 1e-8 == pytest.approx(5e-3 * len(frames), abs=1.1e-8)


def test_a_constant_below_the_resolution_is_not_lost() -> None:
    rig = Rig(Motion(wz=lambda t: 3e-8 + 0 * t))  # 0.15 units a sample
    rig.wait(2500 * MS)
    frames = rig.frames()
    assert {f.angle[2] for f in frames} == {0, 1}
    assert sum(f.angle[2] for f in frames) == pytest.approx(0.15 * len(frames), abs=1)


def test_beyond_the_range_it_clips_and_says_so() -> None:
    rig = Rig(Motion(wx=lambda t: np.where(t > 1.0, 20.0, 0.0), fx=lambda t: np.where(t > 1.2, -400.0, 0.0)))
    rig.wait(1600 * MS)
    frames = rig.frames()
    assert all(f.status & 3 == 0 for f in frames if f.end_ns < 1000 * MS)
    late = [f for f in frames if f.end_ns > 1300 * MS]
    assert {f.status for f in late} == {3}
    assert late[-1].angle[0] == pytest.approx(np.radians(500.0) * 5e-3 * 1e9, abs=1)
    assert late[-1].velocity[0] == pytest.approx(-30.0 * G * 5e-3 * 1e8, abs=1)


def test_it_tells_that_it_starts() -> None:
    rig = Rig()
    rig.wait(1200 * MS)
    assert {f.status for f in rig.frames() if f.end_ns < 1000 * MS} == {4}
    assert {f.status for f in rig.frames() if f.end_ns > 1010 * MS} == {0}


def test_supply_off_cuts_the_frame_and_on_begins_anew() -> None:
    rig = Rig()
    rig.wait(600 * MS + 700_000)  # in the middle of a frame
    rig.chip.power(False)
    before = len(rig.chunks)
    rig.wait(100 * MS)
    assert sum(len(data) for data, _ in rig.chunks[before:]) < 32
    rig.chunks.clear()
    rig.chip.power(True)
    rig.wait(600 * MS)
    assert [f.counter for f in rig.frames()][:3] == [0, 1, 2]
    assert rig.frames()[0].end_ns == 700 * MS + 700_000 + 500 * MS + 100_000 + 320 * 10**9 // 230_400


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"rate_hz": 400, "baud": 115_200}, "too slow for 400 frames"),
        ({"rate_hz": 150}, "possible: 50, 100, 200, 400"),
        ({"gyro_range_dps": 0.0}, "gyro_range_dps = 0.0"),
        ({"accel_range_g": -1.0}, "accel_range_g"),
    ],
)
def test_what_cannot_be_is_refused(parameters: dict, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        Rig(**parameters)


def test_the_slowest_baud_that_fits_200_hz_keeps_up() -> None:
    rig = Rig(baud=64_000)
    rig.wait(3000 * MS)
    gaps = np.diff([end for _, end in rig.chunks])
    assert gaps.min() >= 5 * MS - 2
    assert gaps.max() <= 5 * MS + 2


def test_bytes_sent_to_it_are_reported_and_ignored() -> None:
    rig = Rig()
    rig.chip.receive(b"\xaa\x55hello", 5)
    rig.wait(600 * MS)
    assert [str(r.kind.value) for r in rig.chip.reports] == ["protocol"]
    assert len(rig.frames()) == 20


def test_defects() -> None:
    rig = Rig(Motion(wx=lambda t: t))
    rig.wait(700 * MS)
    rig.chip.set_clock_error(10_000.0)
    before = rig.chunks[-1][1]
    rig.wait(1000 * MS)
    after = [f for f in rig.frames() if f.end_ns > before]
    assert abs(np.diff([f.end_ns for f in after])[2:].mean() - 5 * MS / 1.01) < 10
    assert all(b.counter - a.counter == 1 for a, b in zip(rig.frames(), rig.frames()[1:], strict=False))
    rig.chip.raise_flags(0x0008)
    rig.wait(50 * MS)
    assert rig.frames()[-1].status == 0x0008
    rig.chip.halt(True)
    rig.wait(MS * 20)
    silent = len(rig.chunks)
    rig.wait(100 * MS)
    assert len(rig.chunks) == silent
    rig.chip.halt(False)
    rig.wait(100 * MS)
    told = rig.frames()[silent:]
    assert told[0].counter - rig.frames()[silent - 1].counter == pytest.approx(24, abs=2), (
        "its counter went on"
    )


def test_it_looks_at_the_world_again_when_told() -> None:
    world = Motion(wx=lambda t: 0 * t)
    rig = Rig(world)
    rig.wait(600 * MS)
    world.columns["wx"] = lambda t: 1.0 + 0 * t
    rig.wait(20 * MS)
    assert rig.frames()[-1].angle[0] == 0, "it had asked ahead"
    rig.chip.look_anew()
    rig.wait(20 * MS)
    assert rig.frames()[-1].angle[0] == 5_000_000


@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(["power", "halt", "clock", "flags", "bytes", "look"]), st.integers(0, 40)),
        max_size=12,
    )
)
def test_whatever_happens_only_whole_frames_leave_and_nothing_raises(steps: list) -> None:
    rig = Rig()
    on = halted = False
    for what, wait_ms in steps:
        if what == "power":
            rig.chip.power(on)
            on = not on
        elif what == "halt":
            halted = not halted
            rig.chip.halt(halted)
        elif what == "clock":
            rig.chip.set_clock_error(500.0 * wait_ms)
        elif what == "flags":
            rig.chip.raise_flags(wait_ms)
        elif what == "bytes":
            rig.chip.receive(bytes(wait_ms), rig.time.now)
        else:
            rig.chip.look_anew()
        rig.wait((1 + wait_ms) * 15 * MS)
    for data, _ in rig.chunks:
        assert data[:2] == b"\xaa\x55"
        assert len(data) <= 32


def test_golden() -> None:
    """Twelve frames of a known motion, byte by byte; the driver reads the same file."""
    rig = Rig(
        Motion(wx=lambda t: 0.1 + 0 * t, wy=lambda t: -t, fx=lambda t: np.sin(t), fz=lambda t: -G + 0 * t)
    )
    rig.wait(560 * MS)
    lines = [f"{end_ns} {data.hex(' ')}" for data, end_ns in rig.chunks]
    assert lines == TRANSCRIPT.read_text().splitlines()
