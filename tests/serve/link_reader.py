"""Reads a TCP port to its end; prints how many bytes came, their SHA-256, and gaps in the link's sequence
numbers among how many good frames. Knows the frames by docs/link.md alone. A process of its own.
"""

from __future__ import annotations

import hashlib
import socket
import sys

import crcmod

CRC = crcmod.mkCrcFun(0x11021, initCrc=0xFFFF, rev=False)
HEAD = 5  # sync, sync, type, length, sequence

connection = socket.create_connection((sys.argv[1], int(sys.argv[2])))
print("open", flush=True)
digest = hashlib.sha256()
count = frames = gaps = 0
last = -1
rest = b""
while data := connection.recv(1 << 20):
    count += len(data)
    digest.update(data)
    rest += data
    place = 0
    while (begin := rest.find(b"\xa5\x5a", place)) >= 0 and begin + HEAD <= len(rest):
        end = begin + HEAD + rest[begin + 3] + 2
        if end > len(rest):
            break
        if CRC(rest[begin + 2 : end - 2]) != int.from_bytes(rest[end - 2 : end], "little"):
            place = begin + 1
            continue
        sequence = rest[begin + 4]
        gaps += last >= 0 and sequence != (last + 1) % 256
        last, place = sequence, end
        frames += 1
    rest = rest[max(place, begin if begin >= 0 else len(rest) - 1) :]
print(count, digest.hexdigest(), gaps, frames)
