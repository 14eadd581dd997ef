"""The serial line of the monitor: frames, and requests over a port that loses and spoils bytes."""

import random
import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.pil import frames
from host.pil.monitor_link import ANSWER, CALLS, READ, REFUSAL, MonitorLink
from host.record.errors import UserError


@given(st.integers(0, 255), st.integers(0, 255), st.binary(max_size=1200))
def test_a_frame_comes_back_and_holds_no_zero(kind, sequence, payload):
    line = frames.encode(kind, sequence, payload)
    assert line[:1] == line[-1:] == b"\0"
    assert b"\0" not in line[1:-1]
    assert frames.decode(line[1:-1]) == (kind, sequence, payload)


def test_frames_are_cobs_as_published():
    """The examples of the COBS paper (Cheshire and Baker 1999), by the body with its CRC stripped off."""
    line = frames.encode(0x11, 0x22, b"\x00\x33")
    body = b"\x11\x22\x00\x33"
    crc = struct.pack("<I", zlib.crc32(body))
    assert b"\0" not in crc
    assert line == b"\0\x03\x11\x22" + bytes((2 + len(crc),)) + b"\x33" + crc + b"\0"


@given(st.binary(min_size=1, max_size=600), st.data())
def test_a_frame_with_one_byte_lost_or_changed_is_no_frame(payload, data):
    line = frames.encode(5, 7, payload)[1:-1]
    at = data.draw(st.integers(0, len(line) - 1))
    spoilt = data.draw(st.one_of(st.just(b""), st.integers(1, 255).map(lambda x: bytes((x,)))))
    changed = line[:at] + spoilt + line[at + 1 :]
    if changed != line:
        assert frames.decode(changed) is None


class Monitor:
    """A port behind which a monitor answers; `spoil` sees each request and answer on its way."""

    def __init__(self, spoil=lambda line, number: line):
        self.spoil, self.number = spoil, 0
        self.waiting, self.done, self.last = b"", [], (None, b"")

    @property
    def in_waiting(self):
        return len(self.waiting)

    def reset_input_buffer(self):
        self.waiting = b""

    def read(self, size):
        taken, self.waiting = self.waiting[:size], self.waiting[size:]
        return taken

    def write(self, line):
        for frame in filter(None, self._way(line).split(b"\0")):
            self.waiting += self._way(self._answer(frame))

    def _way(self, line):
        self.number += 1
        return self.spoil(line, self.number)

    def _answer(self, frame):
        found = frames.decode(frame)
        if found is None:
            return frames.encode(REFUSAL, 0, b"\1")
        kind, sequence, payload = found
        if sequence != self.last[0]:
            self.done.append(payload)
            self.last = (sequence, frames.encode(kind | ANSWER, sequence, payload[::-1]))
        return self.last[1]


def test_lost_and_spoilt_requests_and_answers_are_resumed_and_worked_off_once():
    chance = random.Random(11)

    def spoil(line, number):
        kinds = (line, line, line, b"", line[:9] + line[10:], line[:5] + b"\x07" + line[6:])
        return chance.choice(kinds)

    port = Monitor(spoil)
    link = MonitorLink(port, "port")
    wanted = [bytes((n, 1, 0, n, 255)) * 20 for n in range(20)]
    for payload in wanted:
        assert link._exchange(CALLS, payload, 50, 0.01) == payload[::-1]
    assert port.done == wanted
    assert min(link.trouble.damaged, link.trouble.silent) > 0


def test_a_silent_port_is_one_message():
    link = MonitorLink(Monitor(lambda line, number: b""), "/dev/ttyX")
    with pytest.raises(UserError, match=r"/dev/ttyX: no whole answer to 2 requests.*460800 baud"):
        link._exchange(READ, b"", 2, 0.01)


def test_another_image_on_the_board_is_told():
    class Other(Monitor):
        def _answer(self, frame):
            _, sequence, _ = frames.decode(frame)
            told = struct.pack("<BBHII16s", 1, 3, 8192, 98304, 168_000_000, b"0123456789abcdef")
            return frames.encode(1 | ANSWER, sequence, told)

    with pytest.raises(UserError, match="another image"):
        MonitorLink(Other(), "/dev/ttyX").greet("fedcba9876543210")
