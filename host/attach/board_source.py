"""Where a board's bytes come from: a serial port, with the time at which they came, or a capture."""

from __future__ import annotations

import queue
import stat
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from hal.live.port import PortError, has_rate, is_device
from hal.live.rate_search import RateSearch, beginning_with
from hal.live.serial_link import SerialLink
from host.capture.blocks import UartChunk
from host.capture.places import capture_path
from host.capture.reader import CaptureReader
from host.record.errors import UserError

TICK_S = 0.1
ENOUGH_BYTES = 300
"""So many without a whole frame in so long a time: the rate is wrong."""
ENOUGH_S = 1.5


@dataclass(frozen=True, slots=True)
class Chunk:
    """Bytes that had come by `time_ns` of the source's clock; `note` is for people."""

    time_ns: int
    data: bytes = b""
    note: str = ""


class BoardSource(Protocol):
    """What the session listens to."""

    name: str
    live: bool
    """Whether it goes on for ever, in real time."""

    def chunks(self) -> Iterator[Chunk]:
        """All that comes, with an empty chunk now and then when nothing does; ends with the source."""
        ...

    def understood(self) -> None:
        """A whole frame was among what came."""
        ...

    def figures(self) -> dict[str, Any]:
        """Of the line, for `--json`."""
        ...

    def close(self) -> None:
        """Let go of it."""
        ...


def capture_at(given: str) -> Path | None:
    """The capture that is meant when `given` is a file or a run's folder. Raises UserError."""
    path = Path(given)
    if is_device(given) and (path.is_dir() or (path.exists() and stat.S_ISREG(path.stat().st_mode))):
        return capture_path(path)
    return None


def open_serial(given: str, baud: int | None, board_baud: int) -> SerialBoard:
    """A board on a port. Raises UserError."""
    try:
        return SerialBoard(given, baud, board_baud)
    except PortError as error:
        raise UserError(f"--port {error}") from None


class SerialBoard:
    """A board on a port. Without a rate given, others are tried when the board's own one says nothing."""

    live = True

    def __init__(self, url: str, baud: int | None, board_baud: int) -> None:
        self.name = url
        rates = beginning_with(board_baud) if baud is None else (baud,)
        is_known = baud is not None or not has_rate(url)
        self._search = RateSearch(rates, ENOUGH_S, ENOUGH_BYTES - 1, settled=is_known)
        self._arrived: queue.SimpleQueue[Chunk] = queue.SimpleQueue()
        self._begin_ns = time.monotonic_ns()
        self._understood = False
        self._told_silent = False
        self._link = SerialLink(url, self._search.baud, self._arrive)
        self._link.on_change = self._changed

    def chunks(self) -> Iterator[Chunk]:
        """For ever."""
        while True:
            try:
                chunk = self._arrived.get(timeout=TICK_S)
            except queue.Empty:
                chunk = Chunk(self._now_ns())
            yield chunk
            self._search.hear(len(chunk.data))
            note = self._look(chunk.time_ns / 1e9)
            if note:
                yield Chunk(chunk.time_ns, note=note)

    def understood(self) -> None:
        """The rate is right."""
        self._understood = True

    def send(self, data: bytes) -> bool:
        """To the board, if the queue has room for all of it."""
        return self._link.free() >= len(data) and self._link.write(data) == len(data)

    def figures(self) -> dict[str, Any]:
        """Rate, bytes, losses of the port."""
        counters = self._link.counters
        return {
            "baud": self._link.baud,
            "bytes_received": counters.bytes_received,
            "port_losses": counters.losses,
            "port_reopenings": counters.reopenings,
        }

    def close(self) -> None:
        """Close the port."""
        self._link.close()

    def _now_ns(self) -> int:
        return time.monotonic_ns() - self._begin_ns

    def _arrive(self, data: bytes) -> None:
        self._arrived.put(Chunk(self._now_ns(), data))

    def _changed(self, there: bool) -> None:
        word = "the port is there again" if there else "the port has vanished; waiting for it"
        self._arrived.put(Chunk(self._now_ns(), note=word))

    def _look(self, now_s: float) -> str:
        """Try another rate, or tell what is wrong; empty: nothing to tell."""
        search = self._search
        if self._understood:
            return ""
        if search.in_doubt(now_s):
            told = f"{search.bytes_heard} bytes at {self._link.baud} baud and not one frame"
            if search.settled:
                search.wait_again(now_s)
                return f"{told}; is that the board's rate, and its link?"
            self._link.set_baud(search.turn(now_s))
            return f"{told}; trying {self._link.baud} baud"
        if not search.bytes_heard and not self._told_silent and now_s >= ENOUGH_S:
            self._told_silent = True
            return "nothing comes from the port; is the board powered, and its TX wired to our RX?"
        return ""


class CapturedBoard:
    """A board's output in a capture."""

    live = False

    def __init__(self, path: Path, port: str) -> None:
        self.name = str(path)
        self._port = port
        self._reader = CaptureReader(path)
        self._bytes = 0

    @property
    def manifest(self) -> dict[str, Any]:
        """Of the recorded run. Raises UserError for what is no capture of navtwin."""
        next(iter(self._reader.messages()), None)
        return self._reader.manifest

    def chunks(self) -> Iterator[Chunk]:
        """All that was recorded of the port."""
        for record in self._reader:
            if isinstance(record, UartChunk) and (record.port, record.direction) == (self._port, "tx"):
                self._bytes += len(record.data)
                yield Chunk(record.end_ns, record.data)

    def understood(self) -> None:
        """A capture has no rate."""

    def figures(self) -> dict[str, Any]:
        """What was read."""
        return {"bytes_received": self._bytes, "capture_complete": self._reader.complete}

    def close(self) -> None:
        """Nothing is held."""
