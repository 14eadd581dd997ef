"""Opens a port with pyserial, reads until it ends or is quiet, and tells what came. A process of its own."""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import time

import serial

parser = argparse.ArgumentParser()
parser.add_argument("url")
parser.add_argument("--baud", type=int, default=115_200)
parser.add_argument("--quiet-s", type=float, default=3.0)
parser.add_argument("--write", default="", help="hex, written once it is open and something has come")
parser.add_argument("--expect", default="", help="hex that is looked for")
asked = parser.parse_args()

port = serial.serial_for_url(asked.url, baudrate=asked.baud, timeout=0.2)
print("open", flush=True)
digest = hashlib.sha256()
count = 0
tail = b""
found = False
wanted = bytes.fromhex(asked.expect)
quiet_since = None
while True:
    try:
        data = port.read(max(1, min(port.in_waiting, 65_536)))
    except (serial.SerialException, OSError):
        break
    if data:
        quiet_since = time.monotonic()
        if not count and asked.write:
            port.write(bytes.fromhex(asked.write))
        count += len(data)
        digest.update(data)
        tail = (tail + data)[-200_000:]
        found = found or (bool(wanted) and wanted in tail)
    elif quiet_since is not None and time.monotonic() - quiet_since > asked.quiet_s:
        break
json.dump({"bytes": count, "sha256": digest.hexdigest(), "found": found}, sys.stdout)
print(flush=True)
