"""Takes the board's byte stream apart into frames, whatever the chunks and whatever came between.

Between frames the board may print NMEA sentences; everything else is garbage and is counted. After a frame
with a wrong CRC the search goes on one byte behind its start, so that a whole frame is never lost to a false
start. Random bytes never raise.
"""

from __future__ import annotations

import functools
import operator
import re
from collections.abc import Callable
from typing import Final

import numpy as np
from crcmod.predefined import mkPredefinedCrcFun

from firmware.drivers.satellite_lists import SYSTEM_NAMES, SatelliteInView
from firmware.link.frames import (
    ATTITUDE,
    BIAS,
    COVARIANCE,
    CRC_LENGTH,
    FILTER,
    GNSS,
    HEADER_LENGTH,
    INNOVATION,
    LIST_HEAD,
    NOT_TOLD,
    PAYLOADS,
    SATELLITE_HEAD,
    SATELLITE_ROW,
    SATELLITES,
    SENSOR,
    SOLUTION,
    STATUS,
    SYNC,
    TASK_ROW,
    TASKS,
    TEXT,
)
from firmware.link.raw_frames import RAW_START
from host.link.attitude import attitude_as_solution
from host.link.messages import (
    Bias,
    Covariance,
    FilterState,
    Gnss,
    Innovation,
    Message,
    Satellites,
    Sensor,
    Solution,
    Status,
    TaskFigures,
    Tasks,
)
from host.link.raw import open_raw

SENTENCE: Final = 0x100
"""Kind under which an NMEA sentence is given out, `$` … checksum without CR LF."""

LONGEST_SENTENCE: Final = 255
_SENTENCE: Final = re.compile(rb"\$([ -#%-)+-~]{1,250})\*([0-9A-F]{2})\r\n")
_crc: Final[Callable[[bytes], int]] = mkPredefinedCrcFun("crc-ccitt-false")


class LinkDecoder:
    """Feed bytes; get (kind, message) in order, or (kind, payload) with `feed_raw`."""

    def __init__(self) -> None:
        self.frames = 0
        """Frames with a correct CRC."""
        self.sentences = 0
        self.bad_crc = 0
        self.lost = 0
        """Frames missing by sequence number (modulo 256)."""
        self.unknown = 0
        """Frames of unknown type or length."""
        self.garbage_bytes = 0
        self._pending = bytearray()
        self._next_sequence: int | None = None

    def feed(self, data: bytes) -> list[tuple[int, Message]]:
        """Messages completed by `data`."""
        return self._open_all(self.feed_raw(data))

    def finish(self) -> list[tuple[int, Message]]:
        """No more bytes will come: what is left, looking into frames that were cut off."""
        return self._open_all(self._split(final=True))

    def finish_raw(self) -> list[tuple[int, bytes]]:
        """The same, payloads as they came."""
        return self._split(final=True)

    def feed_raw(self, data: bytes) -> list[tuple[int, bytes]]:
        """Frames completed by `data`, their payloads as they came; of sentences, their text."""
        self._pending += data
        return self._split(final=False)

    def _split(self, final: bool) -> list[tuple[int, bytes]]:
        pending = bytes(self._pending)
        last_end = len(pending) - CRC_LENGTH
        find, crc = pending.find, _crc
        found: list[tuple[int, bytes]] = []
        sequences = bytearray()
        between = 0
        at = find(SYNC)
        while at >= 0:
            body = at + HEADER_LENGTH
            end = body + pending[at + 3] if body <= last_end else len(pending)
            if end > last_end:
                if not final:
                    break
            elif crc(pending[at + 2 : end]) != pending[end] | pending[end + 1] << 8:
                self.bad_crc += 1
            else:
                if at > between:
                    self._between(pending[between:at], found)
                sequences.append(pending[at + 4])
                found.append((pending[at + 2], pending[body:end]))
                between = end + CRC_LENGTH
                at = find(SYNC, between)
                continue
            at = find(SYNC, at + 1)
        self._count(sequences)
        keep = len(pending) if final else max(self._undecided(pending, between, at), between)
        if keep > between:
            self._between(pending[between:keep], found)
        del self._pending[:keep]
        return found

    @staticmethod
    def _undecided(pending: bytes, between: int, at: int) -> int:
        """Where the bytes begin of which more must be known: a frame, a sentence or half a sync."""
        if at < 0:
            at = len(pending) - 1 if pending.endswith(SYNC[:1]) else len(pending)
        dollar = pending.rfind(b"$", max(between, at - LONGEST_SENTENCE), at)
        whole = pending.find(b"\n", dollar, at) >= 0
        return at if dollar < 0 or whole or at < len(pending) - 1 else dollar

    def _between(self, data: bytes, found: list[tuple[int, bytes]]) -> None:
        """What stands between two frames: sentences and garbage."""
        garbage = len(data)
        for match in _SENTENCE.finditer(data):
            if functools.reduce(operator.xor, match[1]) == int(match[2], 16):
                self.sentences += 1
                found.append((SENTENCE, match[0][:-2]))
                garbage -= len(match[0])
        self.garbage_bytes += garbage

    def _count(self, sequences: bytearray) -> None:
        """Frames with these numbers have come, in this order."""
        if not sequences:
            return
        self.frames += len(sequences)
        before = sequences[0] if self._next_sequence is None else self._next_sequence
        expected = np.frombuffer(bytes(((before - 1) & 0xFF,)) + sequences, np.uint8)
        self.lost += int((np.diff(expected) - np.uint8(1)).sum())
        self._next_sequence = (sequences[-1] + 1) & 0xFF

    def _open_all(self, raw: list[tuple[int, bytes]]) -> list[tuple[int, Message]]:
        opened: list[tuple[int, Message]] = []
        for kind, payload in raw:
            message = open_payload(kind, payload)
            if message is None:
                self.unknown += 1
            else:
                opened.append((kind, message))
        return opened


_FIXED: Final[dict[int, Callable[[tuple[float, ...]], Message]]] = {
    SOLUTION: Solution._make,
    COVARIANCE: Covariance,
    INNOVATION: Innovation,
    BIAS: Bias,
    STATUS: Status._make,
    GNSS: Gnss._make,
    ATTITUDE: attitude_as_solution,
    SENSOR: Sensor._make,
    FILTER: FilterState._make,
}


def open_payload(kind: int, payload: bytes) -> Message | None:
    """The message in a payload; None when its type or length is not known."""
    layout = PAYLOADS.get(kind)
    if layout is not None:
        return _FIXED[kind](layout.unpack(payload)) if layout.size == len(payload) else None
    if kind in (TEXT, SENTENCE):
        return payload.decode(errors="replace")
    if kind >= RAW_START:
        return open_raw(kind, payload)
    if kind == TASKS and _rows(payload, LIST_HEAD.size, TASK_ROW.size):
        return _tasks(payload)
    if kind == SATELLITES and _rows(payload, SATELLITE_HEAD.size, SATELLITE_ROW.size):
        return _satellites(payload)
    return None


def _rows(payload: bytes, head: int, row: int) -> bool:
    return len(payload) >= head and (len(payload) - head) % row == 0


def _tasks(payload: bytes) -> Tasks:
    (time_us,) = LIST_HEAD.unpack_from(payload)
    rows = TASK_ROW.iter_unpack(payload[LIST_HEAD.size :])
    figures = (TaskFigures(n.rstrip(b"\0").decode(errors="replace"), *f) for n, *f in rows)
    return Tasks(time_us, tuple(figures))


def _satellites(payload: bytes) -> Satellites:
    time_us, number, frames = SATELLITE_HEAD.unpack_from(payload)
    rows = SATELLITE_ROW.iter_unpack(payload[SATELLITE_HEAD.size :])
    return Satellites(time_us, number, frames, tuple(_satellite(*row) for row in rows))


def _satellite(
    system: int, number: int, elevation: int, azimuth: int, cn0: int, used: int
) -> SatelliteInView:
    return SatelliteInView(
        SYSTEM_NAMES[system] if system < len(SYSTEM_NAMES) else SYSTEM_NAMES[0],
        number,
        None if elevation == NOT_TOLD else elevation,
        None if azimuth == 0xFFFF else azimuth,
        None if cn0 == NOT_TOLD else cn0,
        bool(used),
    )
