"""A capture, played: the board's own bytes where the file has them, else its decoded topics.

Where the file holds neither, the line of a recorded receiver is listened to. Decoded topics come by their
times, since a whole file has an index: imports write minutes of one topic before those of another. Without an
index, rows that stand in it a little out of order are put into theirs. A jump back begins anew.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Iterable, Iterator
from itertools import count
from pathlib import Path

from host.capture.blocks import LinePiece, Traffic, UartChunk, unpack
from host.capture.places import capture_path
from host.capture.reader import CaptureReader, RawMessage
from host.monitor.capture_rows import SHOWN, Rows, is_shown
from host.monitor.pace import Pace
from host.monitor.run_tasks import tasks_of_run
from host.monitor.state import Shown
from host.monitor.view import MonitorView
from host.monitor.words import duration
from host.record.errors import UserError
from host.run.intake import HOST_PORT

BOARD_LINE = f"/uart/{HOST_PORT}/tx"
BATCH_NS = 130_000_000_000
"""Decoded rows of a run are written every two minutes: so far they may stand behind later ones."""
DATED_NS = 30 * 86_400 * 1_000_000_000
"""A file that begins later than this counts from some calendar's beginning: it is shown from its own."""
SEEK_S = 10.0
PIECES_A_LOOK = 64

Piece = tuple[int, bytes | tuple[int, Shown]]
"""Time in ns, and bytes of a line or a message."""


class CaptureSource:
    """Implements `host.monitor.source.Source`."""

    hint = "q quit   space pause   ←/→ 10 s back/on   +/- speed"

    def __init__(self, path: Path, speed: float) -> None:
        """Looks at what the file holds. Raises UserError when there is nothing to show."""
        self._path = capture_path(path)
        self.title = str(path)
        self.pace = Pace(speed)
        self._tasks = tasks_of_run(self._path)
        self.length_s = CaptureReader(self._path).recorded_s()
        self._begin()

    def _begin(self) -> None:
        self._reader = CaptureReader(self._path)
        self._now_s = 0.0
        self._seek_s: float | None = None
        self._ended = False
        self._is_whole = False
        """Whether the file could be read to its end, as far as that was looked at."""
        self._pieces = self._played()
        self._next = next(self._pieces, None)
        self._origin_ns = 0
        if self._next is not None and self._next[0] > DATED_NS:
            self._origin_ns = self._next[0]
        if self._next is None:
            raise UserError(
                f"capture {self._path}: nothing to show; it holds neither {BOARD_LINE} nor the line of a"
                f" receiver nor any of {', '.join(SHOWN)}"
            )

    @property
    def now_s(self) -> float:
        """Of the recorded run."""
        return self._now_s

    @property
    def ended(self) -> bool:
        """The last record was handed over."""
        return self._ended

    def pump(self, view: MonitorView, budget_s: float, until_s: float = float("inf")) -> None:
        """Play what is due."""
        deadline = time.monotonic() + budget_s
        view.state.run_tasks = self._tasks
        due_s = self._seek_s if self._seek_s is not None else self.pace.due_s(self._now_s)
        due_s = min(due_s, until_s)
        played = 0
        while self._next is not None and self._next[0] - self._origin_ns <= due_s * 1e9:
            self._hand_over(view)
            played += 1
            if played % PIECES_A_LOOK == 0 and time.monotonic() > deadline:
                break
        else:
            self._arrive(due_s)
        view.time_passes(self._now_s)
        self._tell(view)

    def press(self, key: str, view: MonitorView) -> None:
        """Pause, jumps, speed."""
        if key == " ":
            self.pace.paused = not self.pace.paused
        elif key == "right":
            self._seek_s = self._goal_s() + SEEK_S
        elif key == "left":
            to_s = max(self._goal_s() - SEEK_S, 0.0)
            view.forget(0.0)
            self._begin()
            self._seek_s = to_s
        elif key in ("+", "-") and self.pace.speed:
            self.pace.speed = min(max(self.pace.speed * (2.0 if key == "+" else 0.5), 0.125), 1024.0)

    def _goal_s(self) -> float:
        """Where a jump under way will end, or else where we are."""
        return self._now_s if self._seek_s is None else self._seek_s

    def close(self) -> None:
        """Let go of the file."""
        self._pieces = iter(())
        self._next = None

    def _hand_over(self, view: MonitorView) -> None:
        assert self._next is not None
        time_ns, what = self._next
        self._now_s = max(self._now_s, (time_ns - self._origin_ns) / 1e9)
        if isinstance(what, bytes):
            view.feed(what, self._now_s)
        else:
            view.take([what], self._now_s)
        self._next = next(self._pieces, None)

    def _arrive(self, due_s: float) -> None:
        """All that was due is played."""
        if self._next is None:
            self._ended = True
        elif due_s != float("inf"):
            self._now_s = max(self._now_s, due_s)
        if self._seek_s is not None:
            self._seek_s = None
            self.pace.jump(self._now_s)

    def _tell(self, view: MonitorView) -> None:
        length = ""
        if self.length_s is not None:
            length = f" of {duration(max(self.length_s - self._origin_ns / 1e9, self._now_s))}"
        state = "seeking" if self._seek_s is not None else "end" if self._ended else self.pace.told()
        view.source = f"{state}{length}"
        view.source_style = "yellow" if self._ended or self.pace.paused else "green"
        if self._ended and not (self._is_whole or self._reader.complete):
            view.source += ", the file is not whole"

    def _played(self) -> Iterator[Piece]:
        topics = self._topics()
        rows = {topic for topic in topics if is_shown(topic)}
        lines = sorted(t for t in topics if t.startswith("/uart/") and t.endswith("/rx"))
        if BOARD_LINE in topics:
            yield from self._bytes_of(BOARD_LINE)
        elif rows:
            yield from self._rows(Rows("/solution" in rows), rows | {"/event"})
        elif lines:
            yield from self._bytes_of(lines[0])

    def _topics(self) -> set[str]:
        """Topics with messages in the file; not all of them, when the board's line is one."""
        topics: set[str] = set()
        reader = CaptureReader(self._path)
        for message in reader.messages():
            if message.is_raw or not message.topic.startswith("/uart/"):
                topics.add(message.topic)
            if BOARD_LINE in topics:
                break
        self._is_whole = reader.complete
        return topics

    def _bytes_of(self, line: str) -> Iterator[Piece]:
        for message in self._reader.messages():
            if message.topic == line and message.is_raw:
                for record in self._records(message):
                    if isinstance(record, UartChunk | LinePiece):
                        yield record.end_ns, record.data

    def _records(self, message: RawMessage) -> Iterator[Traffic]:
        try:
            yield from unpack(message.schema.name, message.topic, message.data)
        except ValueError as error:
            raise UserError(f"capture {self._path}: damaged: {error}") from None

    def _rows(self, rows: Rows, topics: set[str]) -> Iterator[Piece]:
        if self._is_whole:
            return _opened(rows, self._reader.in_time_order(topics))
        return _in_order(_opened(rows, (raw for raw in self._reader.messages() if raw.topic in topics)))


def _opened(rows: Rows, found: Iterable[RawMessage]) -> Iterator[Piece]:
    for raw in found:
        message = rows.message(raw.topic, raw.time_ns, raw.data) if raw.encoding == "json" else None
        if message is not None:
            yield raw.time_ns, message


def _in_order(pieces: Iterator[Piece]) -> Iterator[Piece]:
    """By time, where none stands more than BATCH_NS behind a later one."""
    waiting: list[tuple[int, int, Piece]] = []
    number = count()
    latest = 0
    for piece in pieces:
        heapq.heappush(waiting, (piece[0], next(number), piece))
        latest = max(latest, piece[0])
        while waiting and waiting[0][0] < latest - BATCH_NS:
            yield heapq.heappop(waiting)[2]
    while waiting:
        yield heapq.heappop(waiting)[2]
