"""The shadow of a board: bit-equal when nothing is missing, never wrong when something is."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from attached_board import frames_of, said, shadow_for, shadowed
from hypothesis import given, settings
from hypothesis import strategies as some

from firmware.link import frames, raw_frames
from firmware.link.frames import PAYLOADS, SOLUTION
from host.attach.difference import solution_difference
from host.attach.shadow import Phase
from host.link.messages import Solution

SLICES = 77
"""Of a copy of the memory: 3516 float32, 517 int64 and an epoch of 31, in parts of 240 bytes."""


@pytest.mark.parametrize("profile", ["full-rate", "thesis"])
def test_every_solution_is_equal_to_the_last_bit(profile):
    shadow = shadowed(said(profile), shadow_for(profile))
    counts = shadow.counts
    assert shadow.differences == []
    assert counts.solutions_equal == sum(kind == SOLUTION for kind, _ in frames_of(said(profile)))
    assert counts.solutions_equal > 240
    assert (counts.starts, counts.losses, counts.solutions_unchecked) == (1, 0, 0)
    assert counts.copies_equal >= 2
    assert shadow.in_step


@pytest.mark.parametrize(
    "changes",
    [
        ("board.pins.timepulse.wired=false",),
        ("profile.gnss_rate_hz=10", "profile.output_rate_hz=50"),
        pytest.param(("profile.precision='float64'",), marks=pytest.mark.soak),
        ('fault=[{kind="cpu-reset",target="mcu",at_s=12}]',),
        (
            'fault=[{kind="chip-reset",target="U2",at_s=8},{kind="spi-bit-errors",target="imu",at_s=14,duration_s=4}]',
        ),
        ('fault=[{kind="uart-garbage",target="gnss",at_s=9,parameters={length=300}}]',),
    ],
    ids=["no pulse", "fast", "double", "reset", "sensor", "receiver"],
)
def test_whatever_happens_on_the_board_is_shadowed(changes):
    own = dict(one.removeprefix("profile.").split("=") for one in changes if one.startswith("profile."))
    told = {key: value.strip("'") if "'" in value else int(value) for key, value in own.items()}
    shadow = shadow_for(**told)
    if "board.pins.timepulse.wired=false" in changes:
        board_shadow = shadow_without_pulse()
        shadow = board_shadow
    shadowed(said("full-rate", 20, *changes), shadow)
    assert shadow.differences == []
    assert shadow.counts.solutions_equal > 180
    assert shadow.counts.losses == 0
    assert shadow.counts.starts == 1 + ("cpu-reset" in changes[0])


def shadow_without_pulse():
    from boards.assembly import installation_of
    from boards.description import load_board
    from firmware.apps.car_mems.program import raw_loop
    from host.attach.shadow import Shadow

    board = load_board("car_mems")
    return Shadow(raw_loop(board.profiles["full-rate"], installation_of(board), []))


def test_a_setting_that_differs_is_found():
    shadow = shadowed(said("full-rate", 16, "profile.initial_yaw_deg=62.0"), shadow_for())
    start, state, solution = (
        next(d for d in shadow.differences if d.what == w) for w in ("start", "state", "solution")
    )
    assert start.field == "check sum of the configured memory"
    assert state.field.startswith("INITIAL_YAW")
    assert (solution.field, solution.board, solution.twin) == ("mode", 3, 2)
    assert shadow.counts.solutions_different > 0


def test_a_memory_upset_on_the_board_is_found():
    """A cell that a cosmic ray changed: NaN in the velocity."""
    shadow = shadowed(said("full-rate", 40, 'fault=[{kind="nav-nan",target="mcu",at_s=30}]'), shadow_for())
    first = shadow.first_difference
    assert first is not None
    assert 29.5 < first.board_s < 32.0
    assert shadow.counts.solutions_equal > 290


def test_a_board_that_has_run_for_long_is_joined_by_a_copy_of_its_memory():
    data = said()
    shadow = shadowed(data[len(data) // 4 :], shadow_for())
    assert shadow.in_step
    assert (shadow.counts.starts, shadow.counts.joined) == (0, 1)
    assert shadow.differences == []
    assert shadow.counts.solutions_equal > 80
    other = shadowed(data[len(data) // 4 :], shadow_for(aiding=False))
    assert [d.what for d in other.differences] == ["configuration"]
    assert other.differences[0].field.startswith("CONSTRAINT_ON")


def test_a_missing_input_is_noticed_and_the_next_copy_joins_again():
    all_frames = frames_of(said())
    place = next(
        k for k, (kind, _) in enumerate(all_frames) if kind == raw_frames.RAW_IMU and k > len(all_frames) // 5
    )
    shadow = shadow_for()
    for k, (kind, payload) in enumerate(all_frames):
        if k != place:
            shadow.take(kind, payload)
    shadow.finish()
    counts = shadow.counts
    assert shadow.differences == []
    assert (counts.losses, counts.inputs_missing, counts.joined) == (1, 1, 1)
    total = sum(kind == SOLUTION for kind, _ in all_frames)
    assert counts.solutions_equal + counts.solutions_unchecked == total
    assert 0 < counts.solutions_unchecked < 200


@settings(max_examples=15, deadline=None)
@given(some.lists(some.tuples(some.floats(0, 1), some.integers(1, 400)), min_size=1, max_size=6))
def test_loss_is_never_taken_for_a_difference(holes):
    """Frames of any kind that did not come, from one to a hundred times the length of a hole."""
    all_frames = frames_of(said("full-rate", 12))
    kept = [True] * len(all_frames)
    for where, length in holes:
        begin = int(where * len(kept))
        kept[begin : begin + length] = [False] * len(kept[begin : begin + length])
    shadow = shadow_for()
    for (kind, payload), is_kept in zip(all_frames, kept, strict=True):
        if is_kept:
            shadow.take(kind, payload)
    shadow.finish()
    assert shadow.differences == []


@settings(max_examples=30, deadline=None)
@given(some.lists(some.tuples(some.integers(0, 255), some.binary(max_size=255)), max_size=40))
def test_no_frame_makes_it_fall(garbage):
    shadow = shadow_for()
    for kind, payload in garbage:
        shadow.take(kind, payload)
    shadow.finish()


NUMBERED = (raw_frames.RAW_IMU, raw_frames.RAW_EPOCH, raw_frames.RAW_TEMPERATURE, raw_frames.RAW_CLOCK)


@settings(max_examples=60, deadline=None)
@given(
    some.lists(some.tuples(some.sampled_from(NUMBERED), some.binary(min_size=220, max_size=220)), max_size=8)
)
def test_no_input_makes_it_fall(inputs):
    """Frames in step with values that no sensor gives: times, epochs and temperatures of any bits."""
    shadow = shadow_for()
    start = next(payload for kind, payload in frames_of(said()) if kind == raw_frames.RAW_START)
    solution = next(payload for kind, payload in frames_of(said()) if kind == SOLUTION)
    shadow.take(raw_frames.RAW_START, start)
    for number, (kind, bits) in enumerate(inputs, 1):
        size = raw_frames.INPUTS[kind].size - 4
        shadow.take(kind, struct.pack("<I", number) + bits[:size].ljust(size, bits[-1:]))
        shadow.take(SOLUTION, solution)
    shadow.finish()
    assert shadow.counts.inputs == len(inputs)


def test_one_bit_of_one_sample_is_seen():
    """What the board would do that computes a sample otherwise: its memory and then its solutions differ."""
    shadow = shadow_for(initial_yaw_deg=62.0)
    for kind, payload in frames_of(said("full-rate", 20, "profile.initial_yaw_deg=62.0")):
        if kind == raw_frames.RAW_IMU and struct.unpack_from("<I", payload)[0] == 1500:
            payload = payload[:12] + bytes((payload[12] ^ 1,)) + payload[13:]
        shadow.take(kind, payload)
    shadow.finish()
    assert shadow.differences
    assert {found.what for found in shadow.differences} <= {"state", "solution"}
    assert shadow.counts.solutions_equal >= 140


def test_a_board_with_another_program_is_told():
    """Its memory has another size: nothing can be compared, until a start of the right one."""
    shadow = shadow_for()
    for payload in raw_frames.slices_of(bytes(5000), 7):
        shadow.take(raw_frames.RAW_STATE, payload)
    assert shadow.phase is Phase.FOREIGN
    assert shadow.differences[0].field == "bytes of the memory"
    assert shadow.differences[0].board == 5000


def test_a_difference_is_told_by_field_values_and_ulp():
    payload = next(p for kind, p in frames_of(said()) if kind == SOLUTION)
    values = Solution(*PAYLOADS[SOLUTION].unpack(payload))
    assert solution_difference(payload, payload) is None
    height = np.nextafter(np.nextafter(np.float32(values.height), np.float32(9e9)), np.float32(9e9))
    twin = PAYLOADS[SOLUTION].pack(*values._replace(height=float(height), sigma_d=values.sigma_d + 1.0))
    found = solution_difference(payload, twin)
    assert (found.field, found.ulp, found.fields) == ("height", 2, 2)
    assert "2 ULP apart" in found.text()
    zero = PAYLOADS[SOLUTION].pack(*values._replace(v_e=0.0))
    negative = PAYLOADS[SOLUTION].pack(*values._replace(v_e=-0.0))
    assert solution_difference(zero, negative).field == "v_e"


def test_a_copy_has_as_many_slices_as_documented():
    heads = [
        raw_frames.SLICE_HEAD.unpack_from(p) for kind, p in frames_of(said()) if kind == raw_frames.RAW_STATE
    ]
    assert {places for _, _, places in heads} == {SLICES}
    assert [place for _, place, _ in heads[:SLICES]] == list(range(SLICES))


def test_raw_output_needs_a_fast_port():
    from host.record.errors import UserError
    from host.record.result import RunRequest
    from host.run.runner import run

    changes = ("duration_s=2", "profile.raw_output=true", "board.uarts.host.baud=57600")
    with pytest.raises(
        UserError, match=r"raw_output = true needs \d+ baud on the host port, which has 57600"
    ):
        run(RunRequest("car_mems", "town-open", overrides=changes))


def test_numbers_are_little_endian_and_follow_one_another():
    inputs = [(k, p) for k, p in frames_of(said()) if k in raw_frames.INPUTS]
    assert inputs[0][0] == raw_frames.RAW_START
    assert [struct.unpack_from("<I", p)[0] for _, p in inputs] == list(range(len(inputs)))
    assert all(
        len(p) + frames.HEADER_LENGTH + frames.CRC_LENGTH == raw_frames.IMU_FRAME_BYTES
        for k, p in inputs
        if k == raw_frames.RAW_IMU
    )
