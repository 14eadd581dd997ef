"""What an emulated board says on its host port with raw output on, and ports to say it through."""

from __future__ import annotations

import functools
import os
import termios
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from boards.assembly import assemble, installation_of
from boards.description import load_board
from firmware.apps.car_mems.program import raw_loop
from hal.emulated.virtual_time import SECOND
from host.attach.shadow import Shadow
from host.link.decoder import LinkDecoder
from host.record.result import RunRequest
from host.run.faults import place_faults
from host.run.readiness import prepared
from host.run.surroundings import Surroundings

BAUD = 230_400
PIECE = 512


@functools.cache
def said(profile: str = "full-rate", seconds: int = 25, *changes: str) -> bytes:
    """All bytes of the host port; `changes` as of --set."""
    overrides = (f"duration_s={seconds}", "expect={}", "profile.raw_output=true", *changes)
    setup, world = prepared(RunRequest("car_mems", "town-open", profile, 1, overrides))
    surroundings = Surroundings(world, None)
    board = assemble(setup.board, setup.profile, surroundings)
    place_faults(world.scenario.fault, board, surroundings.sights, 1, seconds * SECOND)
    ear = board.from_board["host"].connect_late()
    board.machine.run_until(seconds * SECOND)
    data = b"".join(piece for piece, _end, _baud in ear.pieces())
    board.machine.power_off()
    return data


def frames_of(data: bytes) -> list[tuple[int, bytes]]:
    """Kinds and payloads, in order."""
    return LinkDecoder().feed_raw(data)


def shadow_for(profile: str = "full-rate", **changes: object) -> Shadow:
    """A shadow of that profile."""
    board = load_board("car_mems")
    return Shadow(raw_loop({**board.profiles[profile], **changes}, installation_of(board), ["timepulse"]))


def shadowed(data: bytes, shadow: Shadow) -> Shadow:
    """After all of `data`."""
    decoder = LinkDecoder()
    for begin in range(0, len(data), PIECE):
        for kind, payload in decoder.feed_raw(data[begin : begin + PIECE]):
            shadow.take(kind, payload)
    shadow.finish()
    return shadow


class Adapter:
    """A pseudo-terminal behind a name that stays: unplugged and plugged in again, as a USB adapter is.

    With `baud` it garbles what is said to a port that is set to another rate, as a UART would.
    """

    def __init__(self, link: Path, baud: int | None = None) -> None:
        self.path = link
        self._baud = baud
        self._master = -1
        self.plug_in()

    def plug_in(self) -> None:
        """The device is there."""
        self._master, slave = os.openpty()
        attributes = termios.tcgetattr(slave)
        attributes[0] = attributes[1] = attributes[3] = 0
        termios.tcsetattr(slave, termios.TCSANOW, attributes)
        name = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(name)

    def unplug(self) -> None:
        """The device is gone."""
        self.path.unlink(missing_ok=True)
        os.close(self._master)
        self._master = -1

    def say(self, data: bytes, deadline_s: float = 20.0) -> None:
        """Give all of it to whoever reads."""
        end = time.monotonic() + deadline_s
        while data and time.monotonic() < end:
            piece = data[:PIECE]
            if self._baud is not None and self._speed() != self._baud:
                piece = bytes((7 * byte + 3) & 0x7F for byte in piece)
            try:
                data = data[os.write(self._master, piece) :]
            except BlockingIOError:
                time.sleep(0.001)

    def heard(self) -> bytes:
        """What came from the other side by now."""
        try:
            return os.read(self._master, 4096)
        except (BlockingIOError, OSError):
            return b""

    def _speed(self) -> int:
        code = termios.tcgetattr(self._master)[5]
        names = (name for name in dir(termios) if name[:1] == "B" and name[1:].isdigit())
        return next(int(name[1:]) for name in names if getattr(termios, name) == code)

    def close(self) -> None:
        """After use."""
        if self._master >= 0:
            self.unplug()


@contextmanager
def saying(adapter: Adapter, *parts: bytes | float) -> Iterator[None]:
    """In a thread of its own: bytes to say, and pauses in s."""

    def work() -> None:
        for part in parts:
            if isinstance(part, bytes):
                adapter.say(part)
            else:
                time.sleep(part)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    try:
        yield
    finally:
        thread.join(20.0)
