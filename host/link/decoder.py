"""Takes the board's byte stream apart into frames, whatever the chunks and whatever came between."""

from __future__ import annotations

from dataclasses import dataclass, field

from crcmod.predefined import mkPredefinedCrcFun

from firmware.link.frames import (
    CRC_LENGTH,
    HEADER_LENGTH,
    PAYLOADS,
    SYNC,
    TEXT,
)

_crc = mkPredefinedCrcFun("crc-ccitt-false")


@dataclass
class LinkDecoder:
    """Feed bytes, get (type, fields) in order. Random bytes never raise; they are counted."""

    frames: int = 0
    bad_crc: int = 0
    lost: int = 0
    """Frames missing by sequence number."""
    unknown: int = 0
    garbage_bytes: int = 0
    _pending: bytearray = field(default_factory=bytearray)
    _next_sequence: int | None = None

    def feed(self, data: bytes) -> list[tuple[int, tuple[float, ...] | str]]:
        """Frames completed by `data`: numbers in the order of the layout, a str for TEXT."""
        pending = self._pending
        pending += data
        found: list[tuple[int, tuple[float, ...] | str]] = []
        at = 0
        while True:
            sync = pending.find(SYNC, at)
            if sync < 0:
                keep = 1 if pending[-1:] == SYNC[:1] and len(pending) > at else 0
                self.garbage_bytes += len(pending) - keep - at
                at = len(pending) - keep
                break
            self.garbage_bytes += sync - at
            at = sync
            if len(pending) - at < HEADER_LENGTH:
                break
            end = at + HEADER_LENGTH + pending[at + 3]
            if len(pending) < end + CRC_LENGTH:
                break
            if _crc(bytes(pending[at + 2 : end])) != pending[end] | pending[end + 1] << 8:
                self.bad_crc += 1
                at += len(SYNC)
                continue
            frame = self._open(pending[at + 2], pending[at + 4], bytes(pending[at + HEADER_LENGTH : end]))
            if frame is not None:
                found.append(frame)
            at = end + CRC_LENGTH
        del pending[:at]
        return found

    def _open(
        self, kind: int, sequence: int, payload: bytes
    ) -> tuple[int, tuple[float, ...] | str] | None:
        self.frames += 1
        if self._next_sequence is not None:
            self.lost += (sequence - self._next_sequence) & 0xFF
        self._next_sequence = (sequence + 1) & 0xFF
        if kind == TEXT:
            return kind, payload.decode(errors="replace")
        layout = PAYLOADS.get(kind)
        if layout is None or layout.size != len(payload):
            self.unknown += 1
            return None
        return kind, layout.unpack(payload)
