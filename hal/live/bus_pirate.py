"""The Bus Pirate's binary protocol (firmware of its versions 3 and 4), from the side of the computer.

    terminal ──0x00, up to 20 times──► bitbang "BBIO1" ──0x01──► SPI "SPI1"
        ◄──────────0x0F──────────────      │  ▲   ──0x02──► I²C "I2C1"
                                           └──┴── 0x00 from either mode

    0x02 0x03       SPI: chip select low, high; I²C: start, stop         → 01
    0x1n b₀ … bₙ    exchange n + 1 bytes; SPI → 01 MISO₀ … MISOₙ, I²C → 01 and an acknowledge bit each
    0x04 0x06 0x07  I²C: read a byte → byte; acknowledge, refuse → 01
    0x4w            w = power | pull-ups | AUX | CS                      → 01
    0x6s            speed                                                → 01
    0x8c            SPI: c = output 3.3 V | clock idle high | edge active to idle | sample at end   → 01

Every byte sent is answered by one byte, in order, so a whole transaction can be sent at once and costs one
round trip of USB. There is no flow control: what is sent must not come faster than the bus works it off,
hence no slower buses than those in `bus_pirate_buses`. Write-then-read (0x04, 0x05; I²C 0x08) is not used:
it drops what the slave says during the write, and cannot repeat a start.
"""

from __future__ import annotations

import contextlib
import time
from typing import Any

from serial import SerialException

from hal.live.port import open_port

BAUD = 115_200
ZEROS = 25
"""20 leave the terminal; the others fill up an exchange that was cut off."""
ANSWER_S = 0.02
"""For the answer to one of them; a USB adapter may keep it for 16 ms."""
QUIET_S = 0.03
REPLY_S = 0.5
SLOWEST_BYTE_S = 0.001
"""Each further byte of a reply may take so long."""
SLICE_BYTES = 128
"""Sent before its replies are read, so that neither side's buffers fill up."""
SHOWN_BYTES = 24

RESET = 0x00
ENTER_SPI = 0x01
ENTER_I2C = 0x02
TO_TERMINAL = 0x0F
BITBANG = b"BBIO1"

OK = 0x01

POWER = 0x08
PULL_UPS = 0x04
AUX = 0x02
CS = 0x01
PERIPHERALS = 0x40


class BusPirateError(Exception):
    """The other end does not do what a Bus Pirate does. The message says what came instead."""


class BusPirate:
    """One Bus Pirate on an open port. Every call raises BusPirateError or an OSError when it fails."""

    def __init__(self, url: str, port: Any) -> None:
        self.url = url
        self._port = port

    @classmethod
    def open(cls, url: str, baud: int = BAUD) -> BusPirate:
        """Open the port. Raises PortError."""
        port = open_port(url, baud, timeout_s=ANSWER_S)
        with contextlib.suppress(AttributeError, NotImplementedError, OSError, ValueError):
            port.set_low_latency_mode(True)  # 1 ms instead of 16 on the common USB adapter
        return cls(url, port)

    def enter(self, command: int, name: bytes) -> None:
        """From whatever state it is in to the mode that answers with `name`."""
        self._to_bitbang()
        self._port.write(bytes((command,)))
        answer = self._read(len(name), REPLY_S)
        for _ in range(ZEROS):
            if answer != BITBANG[: len(name)]:
                break
            self._read(len(BITBANG) - len(name), REPLY_S)  # a zero's answer that was late
            answer = self._read(len(name), REPLY_S)
        if answer != name:
            raise BusPirateError(
                f"{self.url}: the Bus Pirate answers {_shown(answer)} when asked for its mode "
                f"{name.decode()}; its firmware lacks that mode"
            )

    def configure(self, *commands: int) -> None:
        """Commands of one byte that answer 01."""
        for command in commands:
            self._port.write(bytes((command,)))
            answer = self._read(1, REPLY_S)
            if answer != bytes((OK,)):
                raise BusPirateError(
                    f"{self.url}: the Bus Pirate answers {_shown(answer)}, not 01, "
                    f"to the setting 0x{command:02X}"
                )

    def exchange(self, request: bytes, bus_s: float = 0.0) -> bytes:
        """Send commands that answer a byte for each of theirs, on a bus that needs `bus_s` for them.

        Returns the replies; fewer than asked for when the rest did not come in time.
        """
        replies = bytearray()
        for start in range(0, len(request), SLICE_BYTES):
            part = request[start : start + SLICE_BYTES]
            self._port.write(part)
            answer = self._read(len(part), REPLY_S + bus_s)
            replies += answer
            if len(answer) < len(part):
                break
        return bytes(replies)

    def leave(self) -> None:
        """Back to the terminal, outputs and power off, and close the port."""
        with contextlib.suppress(OSError, SerialException):
            self._port.write(bytes((RESET,)))
            self._read(len(BITBANG), REPLY_S)
            self._port.write(bytes((TO_TERMINAL,)))
            self._read(1, REPLY_S)
        self.close()

    def close(self) -> None:
        """Let go of the port, whatever state the other end is in."""
        try:
            self._port.close()
        except Exception:  # whatever is left of a vanished port
            return

    def _to_bitbang(self) -> None:
        heard = self._quiet()
        for _ in range(ZEROS):
            self._port.write(bytes((RESET,)))
            heard += self._read(len(BITBANG), ANSWER_S)
            if BITBANG in heard:
                self._quiet()
                return
        if BITBANG in heard + self._quiet():
            return
        raise BusPirateError(_not_a_bus_pirate(self.url, bytes(heard)))

    def _quiet(self) -> bytearray:
        """Read until nothing more comes; at most a few times QUIET_S."""
        heard = bytearray()
        now = quiet_since = time.monotonic()
        end = now + 10 * QUIET_S
        while now < end and now - quiet_since < QUIET_S:
            piece = self._port.read(max(1, self._port.in_waiting))
            now = time.monotonic()
            if piece:
                heard += piece
                quiet_since = now
        return heard

    def _read(self, count: int, patience_s: float) -> bytes:
        """`count` bytes, or what has come by the time that they may take."""
        data = bytearray()
        deadline = time.monotonic() + patience_s + count * SLOWEST_BYTE_S
        while len(data) < count:
            data += self._port.read(min(count - len(data), max(1, self._port.in_waiting)))
            if len(data) < count and time.monotonic() >= deadline:
                break
        return bytes(data)


def _not_a_bus_pirate(url: str, heard: bytes) -> str:
    wanted = f"is it a Bus Pirate v3 or v4, at {BAUD} baud? (version 5 and later speak another protocol)"
    if not heard:
        return f"{url}: nothing answers; {wanted}"
    return f"{url}: answers {_shown(heard)} instead of BBIO1; {wanted}"


def _shown(data: bytes) -> str:
    if not data:
        return "nothing"
    text = data[:SHOWN_BYTES]
    dots = " …" if len(data) > SHOWN_BYTES else ""
    readable = "".join(chr(byte) if 32 <= byte < 127 else "." for byte in text)
    return f"{text.hex(' ')}{dots} ({readable!r})"
