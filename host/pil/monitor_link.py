"""Requests to the monitor of an image over a serial port, each answered once however often it is sent.

A request or answer that is lost or damaged is sent again; the processor does the work only once, as it knows
the request by its sequence number. The messages are described in firmware/target/monitor.c.
"""

from __future__ import annotations

import random
import struct
import time
from dataclasses import dataclass, field
from typing import Any, Final

import serial

from host.pil import frames
from host.pil.image import BAUD
from host.record.errors import UserError

HELLO, WRITE, READ, ARRAY, CALLS, RESULTS = range(1, 7)
ANSWER: Final = 0x80
REFUSAL: Final = 0xFF
DAMAGED: Final = 1
VERSION: Final = 1
ATTEMPTS = 5
PATIENCE_S = 4.0
"""For an answer; the largest batch takes a second in an emulator on a busy computer."""
GREETING_S = 1.0
GREETINGS = 6


@dataclass(slots=True)
class Trouble:
    """What went wrong on the line and was mended."""

    damaged: int = 0
    """Answers with a wrong CRC."""
    refused: int = 0
    """Requests that reached the processor damaged."""
    silent: int = 0
    """Requests without an answer in time."""


@dataclass(slots=True)
class Greeting:
    """What the image says of itself."""

    kernels: int
    frame_limit: int
    memory: int
    core_hz: int
    identity: str


@dataclass(slots=True)
class MonitorLink:
    """One serial port with an image behind it."""

    port: Any
    """Of pyserial."""
    name: str
    """Of the port, for messages."""
    trouble: Trouble = field(default_factory=Trouble)
    _sequence: int = field(default_factory=lambda: random.SystemRandom().randrange(256))
    _received: bytearray = field(default_factory=bytearray)

    def greet(self, identity: str) -> Greeting:
        """Find the image. Raises UserError when nothing answers, or another image does."""
        self.port.reset_input_buffer()
        answer = self._exchange(HELLO, b"", GREETINGS, GREETING_S)
        version, kernels, limit, memory, core_hz, name = struct.unpack("<BBHII16s", answer)
        found = name.decode("ascii", "replace")
        if version != VERSION or found != identity:
            raise UserError(
                f"{self.name}: the board holds another image ({found}) than these sources make ({identity});"
                " build and flash it again: navtwin build BOARD --target stm32f405"
            )
        return Greeting(kernels, limit, memory, core_hz, found)

    def request(self, kind: int, payload: bytes) -> bytes:
        """The payload of the answer. Raises UserError for a silent port or a refusal."""
        return self._exchange(kind, payload, ATTEMPTS, PATIENCE_S)

    def _exchange(self, kind: int, payload: bytes, attempts: int, patience_s: float) -> bytes:
        self._sequence = (self._sequence + 1) & 0xFF
        line = frames.encode(kind, self._sequence, payload)
        for _ in range(attempts):
            self._write(line)
            answer = self._answer(kind, time.monotonic() + patience_s)
            if answer is not None:
                return answer
        damaged = self.trouble.damaged + self.trouble.refused
        told = f"{self.trouble.silent} times silent, {damaged} damaged frames"
        raise UserError(
            f"{self.name}: no whole answer to {attempts} requests ({told});"
            f" is the image flashed, the port right and its speed {BAUD} baud?"
        )

    def _write(self, line: bytes) -> None:
        try:
            self.port.write(line)
        except (OSError, serial.SerialException) as error:
            raise UserError(f"{self.name}: the port is gone: {error}") from None

    def _answer(self, kind: int, until: float) -> bytes | None:
        """The payload; None when it must be asked for again."""
        while (line := self._line(until)) is not None:
            frame = frames.decode(line)
            if frame is None:
                self.trouble.damaged += 1
                return None
            found, sequence, payload = frame
            if found == REFUSAL and payload[:1] == bytes((DAMAGED,)):
                self.trouble.refused += 1
                return None
            if sequence != self._sequence:
                continue  # the second answer to an earlier request
            if found == REFUSAL:
                raise UserError(f"{self.name}: the image refuses request {kind}; is it the right one?")
            if found == kind | ANSWER:
                return payload
        self.trouble.silent += 1
        return None

    def _line(self, until: float) -> bytes | None:
        """What stood between two ends; None when time is over."""
        while True:
            line, end, rest = self._received.partition(frames.END)
            if end:
                self._received = bytearray(rest)
                if line:
                    return bytes(line)
                continue
            if time.monotonic() > until:
                return None
            try:
                self._received += self.port.read(max(1, self.port.in_waiting))
            except (OSError, TypeError, serial.SerialException) as error:
                raise UserError(f"{self.name}: the port is gone: {error}") from None


def open_port(url: str) -> Any:
    """A serial port by name or URL of pyserial. Raises UserError."""
    try:
        return serial.serial_for_url(url, baudrate=BAUD, timeout=0.1, write_timeout=10.0)
    except (OSError, ValueError, serial.SerialException) as error:
        raise UserError(f"--port {url}: {error}; for example --port /dev/ttyUSB0") from None
