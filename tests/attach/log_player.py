"""Plays a recorded NMEA log in a process of its own, one epoch a second, at TCP or a pseudo-terminal.

python log_player.py LOG PORT_NUMBER|NAME [SECONDS]
"""

from __future__ import annotations

import os
import re
import socket
import sys
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path


def epochs(log: Path) -> Iterator[bytes]:
    """Sentences of one time of day together."""
    group, clock = b"", None
    for line in log.read_bytes().splitlines(keepends=True):
        if not line.startswith(b"$"):
            continue
        fields = line.split(b",")
        told = fields[1][:6] if re.match(rb"\$G.(RMC|GGA|GNS|ZDA)", line) else None
        if told and clock and told != clock:
            yield group
            group = b""
        clock = told or clock
        group += line.rstrip() + b"\r\n"
    yield group


def outlet(where: str) -> Callable[[bytes], object]:
    """Where the bytes go, once somebody is there."""
    if where.isdigit():
        server = socket.create_server(("127.0.0.1", int(where)))
        print("ready", flush=True)
        return server.accept()[0].sendall
    master, slave = os.openpty()
    attributes = termios.tcgetattr(slave)
    attributes[0] = attributes[1] = attributes[3] = 0
    termios.tcsetattr(slave, termios.TCSANOW, attributes)
    os.symlink(os.ttyname(slave), where)
    os.set_blocking(master, False)
    print("ready", flush=True)
    return lambda data: os.write(master, data)


def main() -> None:
    send = outlet(sys.argv[2])
    end = time.monotonic() + float(sys.argv[3]) if len(sys.argv) > 3 else float("inf")
    for group in epochs(Path(sys.argv[1])):
        if time.monotonic() > end:
            return
        try:
            send(group)
        except (BlockingIOError, BrokenPipeError, ConnectionError):
            if sys.argv[2].isdigit():
                return
        time.sleep(1.0)


if __name__ == "__main__":
    main()
