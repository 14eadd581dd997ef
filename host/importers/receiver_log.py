"""Logs of GNSS receivers: UBX, NMEA and RTCM as they come. Damaged pieces are told; all bytes are kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import islice
from typing import Any

from pynmeagps import NMEAReader
from pynmeagps import exceptions as nmea
from pyubx2 import UBXReader
from pyubx2 import exceptions as ubx

from host.importers.esf_samples import MEAS, RAW, EsfSamples
from host.importers.findings import Kind
from host.importers.log_calendar import NO_DATE, Calendar
from host.importers.log_rows import LogRows
from host.importers.nmea_epochs import NmeaEpochs
from host.importers.receiver_frames import Frame, Piece, frames
from host.importers.request import InputFile, Recording, Task, only_file
from host.importers.series import Portion, at_byte, in_line
from host.importers.time_base import day_of, unix_day
from host.importers.ubx_messages import HANDLERS, UbxMessages
from host.record.errors import UserError

PIECES_LOOKED_AT = 3000
"""At the beginning of a log, to see whether UBX tells the positions."""
NAV_PVT = b"\xb5\x62\x01\x07"
NMEA_ERRORS = (nmea.NMEAParseError, nmea.NMEAMessageError, nmea.NMEATypeError, nmea.NMEAStreamError)
UBX_ERRORS = (ubx.UBXParseError, ubx.UBXMessageError, ubx.UBXTypeError, ubx.UBXStreamError)
DECODING_ERRORS = (ValueError, TypeError, AttributeError, KeyError, IndexError, OverflowError)
"""What decoders raise besides, on well-checked frames with senseless content."""


def read_ubx(task: Task) -> Recording:
    """A u-blox log."""
    return _read(task, only_file(task, "drive.ubx"), Piece.UBX, "UBX frame")


def read_nmea(task: Task) -> Recording:
    """A log of sentences."""
    return _read(task, only_file(task, "drive.nmea"), Piece.NMEA, "NMEA sentence with a right checksum")


def _read(task: Task, file: InputFile, wanted: Piece, name: str) -> Recording:
    beginning = list(islice(frames(file.path, _ignore), PIECES_LOOKED_AT))
    counts = Counter(frame.piece for frame in beginning)
    if not counts[wanted] and not any(frame.piece is wanted for frame in frames(file.path, _ignore)):
        others = {Piece.UBX: "ubx", Piece.NMEA: "nmea"}
        other = next((kind for piece, kind in others.items() if counts[piece]), None)
        hint = f"; there are others: navtwin import {other}" if other else ""
        raise UserError(f"{file.path}: there is no {name} in it{hint}")
    has_pvt = any(frame.piece is Piece.UBX and frame.data.startswith(NAV_PVT) for frame in beginning)
    log = _Log(task, file, has_pvt, counts[Piece.UBX] > 0)
    return Recording([log.portions()], is_absolute=True, facts={"time_of_bytes": "that of their epoch"})


def _ignore(_size: int) -> None:
    pass


class _Log:
    """One log on its way through the decoders."""

    def __init__(self, task: Task, file: InputFile, has_pvt: bool, is_binary: bool) -> None:
        request = task.request
        day = None if request.date is None else unix_day(day_of(request.date))
        self._task = task
        self._file = file
        self._rows = LogRows()
        self._calendar = Calendar(day, request.leap_seconds)
        self._in_line = not is_binary
        self._is_cut_off = False
        place = in_line if self._in_line else at_byte
        findings = task.findings
        self._nmea = NmeaEpochs(
            file.name, place, self._rows, self._calendar, findings, request.geoid_separation_m, not has_pvt
        )
        self._esf = {
            MEAS: EsfSamples(MEAS, "esf", file.name, self._rows, findings),
            RAW: EsfSamples(RAW, "esf-raw", file.name, self._rows, findings),
        }
        self._ubx = UbxMessages(file.name, self._rows, self._calendar, findings, self._epoch)

    def portions(self) -> Iterator[Portion]:
        """All of the log."""
        for frame in frames(self._file.path, self._task.meter):
            if frame.piece is Piece.NMEA:  # which may be the first of another epoch
                self._take(frame)
                self._rows.read(frame.data)
            else:
                self._rows.read(frame.data)
                self._take(frame)
            yield from self._rows.drain()
        self._nmea.close()
        self._ubx.finish()
        for esf in self._esf.values():
            esf.finish()
        if self._calendar.waits:
            raise UserError(f"{self._file.path}: {NO_DATE}")
        yield from self._rows.drain(is_last=True)

    def _epoch(self, gps_ns: int) -> None:
        for esf in self._esf.values():
            esf.epoch(gps_ns)

    def _take(self, frame: Frame) -> None:
        if frame.piece is Piece.UBX:
            self._take_ubx(frame)
        elif frame.piece is Piece.NMEA:
            self._take_sentence(frame)
        elif frame.piece is Piece.DAMAGED:
            name = "UBX" if frame.data[:1] == b"\xb5" else "NMEA"
            shown = frame.data.hex(" ")[:24] if name == "UBX" else repr(frame.data[:40])[2:-1]
            self._note(Kind.CHECKSUM, name, frame, shown, "not decoded; its bytes are kept")
        elif frame.piece is Piece.OTHER:
            self._tell_other(frame)
        elif frame.piece is Piece.CUT_OFF:
            self._is_cut_off = True
            self._note(
                Kind.CUT_OFF, "", frame, "the file ends inside a frame or sentence", "its bytes are kept"
            )

    def _tell_other(self, frame: Frame) -> None:
        size = len(frame.data.strip())
        if size and not frame.data.startswith(b"#") and not self._is_cut_off:
            case = (self._where(frame), repr(frame.data.strip()[:20])[2:-1])
            text = "of no frame or sentence; kept"
            self._task.findings.note(Kind.NOTE, self._file.name, "bytes", [case], size, text)

    def _take_ubx(self, frame: Frame) -> None:
        kind = frame.data[2], frame.data[3]
        if kind in self._esf:
            self._esf[kind].take(frame.data[6:-2], frame.offset)
            return
        try:
            message: Any = UBXReader.parse(frame.data)
            if message.identity in HANDLERS:
                self._ubx.take(message, frame.offset)
        except (*UBX_ERRORS, *DECODING_ERRORS) as error:
            self._note(Kind.UNREADABLE, "UBX", frame, str(error)[:80], "its bytes are kept")

    def _take_sentence(self, frame: Frame) -> None:
        place = frame.line if self._in_line else frame.offset
        try:
            self._nmea.take(NMEAReader.parse(frame.data), place)
        except (*NMEA_ERRORS, *DECODING_ERRORS) as error:
            self._note(Kind.UNREADABLE, "NMEA", frame, str(error)[:80], "its bytes are kept")

    def _note(self, kind: Kind, channel: str, frame: Frame, value: str, text: str) -> None:
        self._task.findings.note(kind, self._file.name, channel, [(self._where(frame), value)], text=text)

    def _where(self, frame: Frame) -> str:
        return f"line {frame.line}, byte {frame.offset}" if self._in_line else at_byte(frame.offset)
