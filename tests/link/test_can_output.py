"""The five CAN frames, read back by cantools with the board's DBC."""

import math
from pathlib import Path
from typing import Any

import cantools
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from firmware.link.frames import FrameWriter
from firmware.link.solution_output import SolutionOutput
from hal.can import CanSet

DBC = Path(__file__).parents[2] / "boards" / "car_mems" / "car_mems.dbc"
DATABASE = cantools.database.load_file(DBC)


def can_set(output: SolutionOutput, floats: list[float], **changes: int) -> CanSet:
    told = {"lat_nanodeg": 0, "lon_nanodeg": 0, "time_of_day_ms": 0, "mode": 3, "flags": 0} | changes
    places = ("lat_nanodeg", "lon_nanodeg", "mode", "flags")
    integers = np.array([0, *(told[name] for name in places)], np.int64)
    return output.pack(np.array(floats, np.float32), integers, 0, told["time_of_day_ms"], 0)[1]


def decode(floats: list[float], **changes: int) -> dict[str, Any]:
    signals: dict[str, Any] = {}
    for frame in can_set(SolutionOutput(FrameWriter()), floats, **changes):
        assert len(frame.data) == 8
        assert not frame.extended
        signals |= DATABASE.decode_message(frame.identifier, frame.data, decode_choices=False)
    return signals


ORDINARY = some.floats(-300, 300, width=32)
SIGMA = some.floats(0, 5, width=32)


@settings(max_examples=150, deadline=None)
@given(
    some.integers(-90 * 10**9, 90 * 10**9),
    some.integers(-180 * 10**9, 180 * 10**9),
    some.floats(-1000, 20000, width=32),
    some.tuples(ORDINARY, ORDINARY, ORDINARY),
    some.tuples(
        some.floats(0, 6.28125, width=32),
        some.floats(-1.5625, 1.5625, width=32),
        some.floats(-3.125, 3.125, width=32),
        some.floats(-5.5, 5.5, width=32),
    ),
    some.tuples(SIGMA, SIGMA, SIGMA, SIGMA, SIGMA, some.floats(0, 0.4375, width=32)),
    some.integers(0, 86_399_999),
)
def test_every_signal_within_half_its_step(lat, lon, height, velocity, angles, sigmas, time_ms):
    yaw, pitch, roll, rate = angles
    s_n, s_e, s_d, s_vn, s_ve, s_yaw = sigmas
    floats = [height, *velocity, yaw, pitch, roll, 0, 0, rate, s_n, s_e, s_d, s_vn, s_ve, 0, 0, 0, s_yaw]
    told = decode(floats, lat_nanodeg=lat, lon_nanodeg=lon, time_of_day_ms=time_ms, mode=4, flags=0xBEEF)
    # float32 scaling adds a few units of its last place
    expected = {
        "latitude": (lat * 1e-9, 1e-7, 0),
        "longitude": (lon * 1e-9, 1e-7, 0),
        "height": (height, 1e-3, 2e-7),
        "time_of_day": (time_ms * 1e-3, 1e-3, 0),
        "velocity_north": (velocity[0], 0.01, 2e-7),
        "velocity_east": (velocity[1], 0.01, 2e-7),
        "velocity_down": (velocity[2], 0.01, 2e-7),
        "speed": (math.hypot(velocity[0], velocity[1]), 0.01, 4e-7),
        "pitch": (math.degrees(pitch), 0.01, 2e-7),
        "roll": (math.degrees(roll), 0.01, 2e-7),
        "yaw_rate": (math.degrees(rate), 0.01, 2e-7),
        "sigma_horizontal": (math.hypot(s_n, s_e), 0.01, 4e-7),
        "sigma_height": (s_d, 0.1, 2e-7),
        "sigma_velocity": (min(math.hypot(s_vn, s_ve), 5.1), 0.02, 4e-7),
        "sigma_yaw": (math.degrees(s_yaw), 0.1, 2e-7),
    }
    for name, (value, step, relative) in expected.items():
        assert told[name] == pytest.approx(value, rel=0, abs=0.5001 * step + relative * abs(value)), name
    turn = (told["yaw"] - math.degrees(yaw) + 180.0) % 360.0 - 180.0
    assert abs(turn) <= 0.005 + 1e-4
    assert 0 <= told["yaw"] < 360
    assert (told["mode"], told["flags"], told["counter"]) == (4, 0xBEEF, 0)


def test_positions_are_rounded_to_the_nearest():
    for nanodeg, expected in ((49, 0), (50, 1), (-50, -1), (149, 1), (179_999_999_950, 1_800_000_000)):
        told = decode([0.0] * 19, lon_nanodeg=nanodeg)
        assert round(told["longitude"] * 1e7) == expected


def test_what_is_too_large_saturates():
    huge = 1e30
    told = decode(
        [huge, huge, -huge, huge, 6.2, 0, 0, 0, 0, -huge, huge, huge, huge, huge, huge, 0, 0, 0, huge]
    )
    assert told["height"] == 2_000_000
    assert (told["velocity_north"], told["velocity_east"]) == (327.67, -327.67)
    assert told["speed"] == 655.35
    assert told["yaw_rate"] == -327.67
    assert (told["sigma_horizontal"], told["sigma_height"]) == (655.35, 25.5)
    assert (told["sigma_velocity"], told["sigma_yaw"]) == (pytest.approx(5.1), 25.5)


def test_not_a_number_is_no_small_sigma():
    told = decode([math.nan] * 19)
    assert (told["sigma_horizontal"], told["sigma_yaw"]) == (655.35, 25.5)


def test_an_unknown_time():
    assert decode([0.0] * 19, time_of_day_ms=0xFFFFFFFF)["time_of_day"] == 4294967.295


def test_the_counter_runs_with_each_set():
    output = SolutionOutput(FrameWriter())
    counters = [can_set(output, [0.0] * 19)[4].data[0] >> 4 for _ in range(18)]
    assert counters == [*range(16), 0, 1]


def test_identifiers_are_those_of_the_dbc():
    frames = can_set(SolutionOutput(FrameWriter()), [0.0] * 19)
    assert [frame.identifier for frame in frames] == sorted(m.frame_id for m in DATABASE.messages)
    assert can_set(SolutionOutput(FrameWriter(), 0x7FB), [0.0] * 19)[-1].identifier == 0x7FF
    for base in (0x7FC, -1):
        with pytest.raises(ValueError, match="for 5 frames 0x0 … 0x7fb is possible"):
            SolutionOutput(FrameWriter(), base)
