"""Frames: packed by the firmware, opened by the host; the CRC against crcmod."""

import struct

import numpy as np
import pytest
from crcmod.predefined import mkPredefinedCrcFun
from hypothesis import given, settings
from hypothesis import strategies as some
from link_samples import COVARIANCE, FIXED, SATELLITES, SOLUTION, TASKS, transmission

from firmware.link import frames
from firmware.link.crc import crc16
from firmware.link.solution_output import SolutionOutput
from host.link import messages as msg
from host.link.decoder import SENTENCE, LinkDecoder

reference = mkPredefinedCrcFun("crc-ccitt-false")


@settings(max_examples=100, deadline=None)
@given(some.binary(max_size=300), some.integers(0, 20))
def test_the_crc_is_crcmods(data, begin):
    array = np.frombuffer(bytearray(data), np.uint8) if data else np.zeros(0, np.uint8)
    begin = min(begin, len(data))
    assert crc16(array, begin, len(data)) == reference(data[begin:])


def test_the_crc_has_its_check_value():
    assert crc16(np.frombuffer(bytearray(b"123456789"), np.uint8), 0, 9) == 0x29B1


def test_every_message_comes_back():
    data, sent = transmission(frames.FrameWriter())
    decoder = LinkDecoder()
    assert decoder.feed(data) == sent
    assert (decoder.frames, decoder.lost, decoder.bad_crc, decoder.garbage_bytes) == (7, 0, 0, 0)


def test_frame_layout():
    writer = frames.FrameWriter()
    writer.text("")
    frame = writer.text("ab")
    assert frame == b"\xa5\x5a\x08\x02\x01ab" + reference(b"\x08\x02\x01ab").to_bytes(2, "little")


@pytest.mark.parametrize(("kind", "size"), [(1, 109), (2, 188), (3, 57), (4, 80), (5, 35), (6, 71)])
def test_payload_lengths(kind, size):
    assert frames.PAYLOADS[kind].size == size


def test_values_that_do_not_fit_are_refused():
    writer = frames.FrameWriter()
    with pytest.raises(struct.error):
        writer.pack(frames.SOLUTION, -1, *SOLUTION[1:])
    with pytest.raises(struct.error):
        writer.pack(frames.SOLUTION, *SOLUTION[:-1])


@settings(max_examples=60, deadline=None)
@given(
    some.lists(some.floats(width=32, allow_nan=False), min_size=19, max_size=19),
    some.tuples(some.integers(0, 2**53), some.integers(0, 2**32 - 1), some.integers(0, 2**16 - 1)),
    some.tuples(
        *[some.integers(-(2**63), 2**63 - 1)] * 2, some.integers(0, 255), some.integers(0, 2**16 - 1)
    ),
    some.integers(0, 300),
)
def test_a_solution_packed_for_both_ports_is_the_frame_of_its_layout(numbers, times, integers, sent_before):
    latitude, longitude, mode, flags = integers
    plain, writer = frames.FrameWriter(), frames.FrameWriter()
    output = SolutionOutput(writer)
    for _ in range(sent_before):
        assert plain.text("x") == writer.text("x")
    record = np.array([0, latitude, longitude, mode, flags], np.int64)
    frame, _ = output.pack(np.array(numbers, np.float32), record, *times)
    assert frame == plain.pack(frames.SOLUTION, *times, mode, flags, latitude, longitude, *numbers)
    assert writer.text("next") == plain.text("next")


def test_long_texts_are_cut_at_a_whole_character():
    decoder = LinkDecoder()
    ((_, text),) = decoder.feed(frames.FrameWriter().text("x" + "µ" * 200))
    assert text == "x" + "µ" * 127


def test_tasks_and_satellites_take_as_many_frames_as_they_need():
    writer, decoder = frames.FrameWriter(), LinkDecoder()
    tasks = [m for _, m in decoder.feed(b"".join(writer.tasks(5, TASKS)))]
    assert [len(part.tasks) for part in tasks] == [9, 6]
    assert tasks[0].tasks + tasks[1].tasks == TASKS
    parts = [m for _, m in decoder.feed(b"".join(writer.satellites(5, SATELLITES)))]
    assert [(part.number, part.frames) for part in parts] == [(0, 2), (1, 2)]
    assert parts[0].satellites + parts[1].satellites == SATELLITES
    ((_, none),) = decoder.feed(b"".join(writer.satellites(5, ())))
    assert none == msg.Satellites(5, 0, 1, ())


def test_covariance_matrix():
    P = COVARIANCE.matrix()
    assert P.shape == (9, 9)
    assert np.array_equal(P, P.T)
    assert P[0].tolist() == list(COVARIANCE[1:10])
    assert P[8, 8] == COVARIANCE[45]


def test_many_solutions_at_once():
    writer = frames.FrameWriter()
    data = b"".join(writer.pack(frames.SOLUTION, k, *SOLUTION[1:]) for k in range(300))
    raw = LinkDecoder().feed_raw(data)
    batch = msg.solution_array([payload for _, payload in raw])
    assert batch["time_us"].tolist() == list(range(300))
    assert batch["lat_nanodeg"][7] == SOLUTION.lat_nanodeg
    assert batch["velocity_ned"][299].tolist() == [SOLUTION.v_n, SOLUTION.v_e, SOLUTION.v_d]
    assert batch["sigma_attitude"][0, 2] == SOLUTION.sigma_phi_d


@settings(max_examples=60, deadline=None)
@given(
    some.lists(some.integers(1, 200), min_size=1, max_size=6),
    some.binary(max_size=30),
    some.binary(max_size=30),
)
def test_chunks_do_not_matter(sizes, before, between):
    writer = frames.FrameWriter()
    first, _ = transmission(writer)
    sentence = b"$INHDT,123.4,T*21\r\n"
    data = before + first + sentence + between + transmission(writer)[0]
    whole = LinkDecoder()
    expected = whole.feed(data) + whole.finish()
    cut = LinkDecoder()
    got = []
    position = turn = 0
    while position < len(data):
        size = sizes[turn % len(sizes)]
        got += cut.feed(data[position : position + size])
        position += size
        turn += 1
    got += cut.finish()
    assert got == expected
    assert vars(cut) == vars(whole)


@settings(max_examples=60, deadline=None)
@given(some.binary(max_size=400).map(lambda data: data.replace(b"\xa5\x5a", b"..")), some.integers(1, 50))
def test_frames_are_found_behind_garbage(garbage, count):
    writer, decoder = frames.FrameWriter(), LinkDecoder()
    data, sent = transmission(writer)
    assert (
        decoder.feed(garbage[:-1] + b"\xa5\x5a\x01" + data)[-7:] + decoder.finish() == sent or garbage == b""
    )


def test_a_checksum_that_ends_like_a_frame_begins_leaves_nothing_behind():
    """One frame in 256 ends with the first sync byte; no byte of it is garbage, whatever comes next."""
    writer, decoder = frames.FrameWriter(), LinkDecoder()
    ended_so = 0
    for _ in range(1500):
        frame = writer.text("mode")
        ended_so += frame.endswith(b"\xa5")
        assert decoder.feed(frame) == [(frames.TEXT, "mode")]
    assert ended_so >= 1
    assert decoder.garbage_bytes == 0


def test_a_false_start_does_not_swallow_what_follows():
    data, sent = transmission(frames.FrameWriter())
    decoder = LinkDecoder()
    assert decoder.feed(b"\xa5\x5a\x01\xff\x00" + data) + decoder.finish() == sent
    assert decoder.bad_crc == 1
    assert decoder.garbage_bytes == 5


def test_a_frame_cut_off_at_the_end_is_garbage():
    data, sent = transmission(frames.FrameWriter())
    decoder = LinkDecoder()
    assert decoder.feed(data[:-1]) == sent[:-1]
    assert decoder.finish() == []
    assert decoder.garbage_bytes > 0


@pytest.mark.parametrize("position", range(2, 20))
def test_any_wrong_byte_loses_one_frame_only(position):
    writer = frames.FrameWriter()
    first, second, third = (writer.pack(kind, *values) for kind, values in FIXED[:3])
    spoilt = bytearray(second)
    spoilt[position] ^= 0x10
    decoder = LinkDecoder()
    got = decoder.feed(first + bytes(spoilt) + third) + decoder.finish()
    assert got == [FIXED[0], FIXED[2]]
    assert decoder.lost == 1
    assert decoder.bad_crc >= (position != 3)


def test_unknown_types_and_lengths_are_counted():
    writer, decoder = frames.FrameWriter(), LinkDecoder()
    body = b"\x77\x01\x00\x00"
    unknown = b"\xa5\x5a" + body + reference(body).to_bytes(2, "little")
    body = b"\x01\x01\x01\x00"
    short = b"\xa5\x5a" + body + reference(body).to_bytes(2, "little")
    assert decoder.feed(unknown + short) == []
    assert decoder.unknown == 2
    assert writer.text("") != b""


def test_sentences_between_frames():
    writer, decoder = frames.FrameWriter(), LinkDecoder()
    data = writer.text("a") + b"$INHDT,123.4,T*21\r\n" + b"$INHDT,123.4,T*20\r\n" + writer.text("b")
    assert decoder.feed(data) == [
        (frames.TEXT, "a"),
        (SENTENCE, "$INHDT,123.4,T*21"),
        (frames.TEXT, "b"),
    ]
    assert (decoder.sentences, decoder.garbage_bytes) == (1, 19)


@settings(max_examples=150, deadline=None)
@given(
    some.lists(some.one_of(some.binary(max_size=40), some.just(b"\xa5\x5a"), some.just(b"$")), max_size=20)
)
def test_random_bytes_never_raise(pieces):
    decoder = LinkDecoder()
    messages = [message for piece in pieces for message in decoder.feed(piece)] + decoder.finish()
    total = sum(map(len, pieces))
    assert decoder.garbage_bytes <= total
    assert decoder.garbage_bytes == total or messages or decoder.unknown
