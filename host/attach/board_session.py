"""A board attached to the twin: its bytes are recorded, decoded, shown and shadowed as they come."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from firmware.link.frames import PAYLOADS, TEXT
from firmware.link.raw_frames import RAW_START
from host.attach.board_recording import BoardRecording
from host.attach.board_source import BoardSource
from host.attach.shadow import Shadow
from host.link.attitude import SOLUTIONS
from host.link.decoder import LinkDecoder, open_payload
from host.link.messages import Message

NO_RAW_AFTER = 30
"""Solutions without a raw frame among them, after which the board is taken to send none."""

Show = Callable[[list[tuple[int, Message]], float, int], None]
"""Messages, when they came, and in how many bytes."""
Notice = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Attachment:
    """What an attached board said, and whether the twin agreed."""

    source: str
    seconds: float
    line: dict[str, Any]
    frames: int
    frames_lost: int
    bad_crc: int
    garbage_bytes: int
    unknown: int
    solutions: int
    raw_frames: int
    shadow: Shadow | None

    @property
    def ok(self) -> bool:
        """Whether all that could be compared was equal."""
        return self.shadow is None or not self.shadow.differences

    @property
    def compared(self) -> bool:
        """Whether there was anything to compare."""
        if self.shadow is None:
            return False
        counts = self.shadow.counts
        return bool(self.shadow.differences or counts.solutions_equal or counts.copies_equal)

    def to_dict(self) -> dict[str, Any]:
        """For `--json`; the keys are stable."""
        return {
            "source": self.source,
            "seconds": self.seconds,
            "line": self.line,
            "link": {
                "frames": self.frames,
                "frames_lost": self.frames_lost,
                "bad_crc": self.bad_crc,
                "garbage_bytes": self.garbage_bytes,
                "unknown": self.unknown,
                "solutions": self.solutions,
                "raw_frames": self.raw_frames,
            },
            "shadow": None if self.shadow is None else self.shadow.to_dict(),
            "compared": self.compared,
            "ok": self.ok,
        }


class BoardSession:
    """Works a source off. `decoder` is the one whose counts are shown."""

    def __init__(
        self,
        source: BoardSource,
        shadow: Shadow | None,
        recording: BoardRecording | None,
        show: Show,
        notice: Notice,
    ) -> None:
        self.decoder = LinkDecoder()
        self.solutions = 0
        self.raw_frames = 0
        self.now_ns = 0
        self._source = source
        self._shadow = shadow
        self._recording = recording
        self._show = show
        self._notice = notice
        self._stopped = False
        self._has_told_no_raw = False
        self._told_phase = shadow.phase if shadow is not None else None
        self._told_differences = 0

    def run(self, seconds: float | None) -> None:
        """Until the source ends, for so long, or until `stop`."""
        for chunk in self._source.chunks():
            if self._stopped:
                break
            if seconds is not None and chunk.time_ns > seconds * 1e9:
                self.now_ns = round(seconds * 1e9)
                break
            self.now_ns = chunk.time_ns
            if chunk.note:
                self._tell(chunk.note)
            if self._recording is not None and chunk.data:
                self._recording.bytes_came(chunk.time_ns, chunk.data)
            found = self.decoder.feed_raw(chunk.data) if chunk.data else []
            self._take(chunk.time_ns, found, len(chunk.data))
            if self._recording is not None:
                self._recording.look(chunk.time_ns)

    def stop(self) -> None:
        """End soon; from a signal."""
        self._stopped = True

    def result(self) -> Attachment:
        """After the end."""
        self._take(self.now_ns, self.decoder.finish_raw(), 0)
        if self._shadow is not None:
            self._shadow.finish()
        decoder = self.decoder
        return Attachment(
            source=self._source.name,
            seconds=self.now_ns / 1e9,
            line=self._source.figures(),
            frames=decoder.frames,
            frames_lost=decoder.lost,
            bad_crc=decoder.bad_crc,
            garbage_bytes=decoder.garbage_bytes,
            unknown=decoder.unknown,
            solutions=self.solutions,
            raw_frames=self.raw_frames,
            shadow=self._shadow,
        )

    def _take(self, time_ns: int, found: list[tuple[int, bytes]], size: int) -> None:
        messages: list[tuple[int, Message]] = []
        for kind, payload in found:
            message = open_payload(kind, payload)
            if message is None:
                self.decoder.unknown += 1
                continue
            messages.append((kind, message))
            self._take_frame(time_ns, kind, payload)
        if found:
            self._source.understood()
        self._show(messages, time_ns / 1e9, size)
        self._tell_news()

    def _take_frame(self, time_ns: int, kind: int, payload: bytes) -> None:
        recording = self._recording
        if kind in SOLUTIONS and len(payload) == PAYLOADS[kind].size:
            self.solutions += 1
            if recording is not None:
                recording.solution(time_ns, kind, payload)
        elif kind >= RAW_START and kind < 0x100:
            self.raw_frames += 1
        elif kind == TEXT and recording is not None:
            recording.event(time_ns, "board", payload.decode(errors="replace"))
        if self._shadow is not None:
            self._shadow.take(kind, payload)

    def _tell_news(self) -> None:
        """The shadow's phase and differences, and what it lacks."""
        shadow = self._shadow
        if shadow is None:
            return
        if not self.raw_frames and self.solutions >= NO_RAW_AFTER and not self._has_told_no_raw:
            self._has_told_no_raw = True
            self._tell("the board sends no raw frames (profile key raw_output): nothing can be compared")
        if shadow.phase is not self._told_phase:
            self._told_phase = shadow.phase
            self._tell(f"shadow: {shadow.phase.value}")
        if shadow.differences and not self._told_differences:
            self._told_differences = 1
            self._tell(f"first difference: {shadow.differences[0].text()}")

    def _tell(self, text: str) -> None:
        self._notice(text)
        if self._recording is not None:
            self._recording.event(self.now_ns, "attach", text)
