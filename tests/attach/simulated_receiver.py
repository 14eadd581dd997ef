"""A u-blox-like receiver behind a pseudo-terminal, in a process of its own; made with pyubx2, it knows
nothing of this project.

    python simulated_receiver.py NAME [--baud 9600] [--deaf] [--no-fix] [--latency S]

Makes the link NAME to its terminal, then answers and talks at its own rate: what is said to it at another one
it does not understand, and what it says is garbled for whoever listens at another one. `unplug` on its
standard input takes the terminal away, `plug` brings another; `silence` and `talk` are told.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import select
import sys
import termios
import time
from datetime import UTC, datetime

from pyubx2 import GET, UBXMessage

LATITUDE, LONGITUDE, HEIGHT, SEPARATION = 48.1173, 11.5167, 545.4, 46.9


class Receiver:
    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.baud = options.baud
        self.pvt = False
        self.sentences = {"GGA", "RMC", "GSA"}
        self.heard = bytearray()
        self.seed = 1
        self.master = -1
        self.silent = False
        self.plug()

    def plug(self) -> None:
        self.master, slave = os.openpty()
        attributes = termios.tcgetattr(slave)
        attributes[0] = attributes[1] = attributes[3] = 0
        termios.tcsetattr(slave, termios.TCSANOW, attributes)
        os.symlink(os.ttyname(slave), self.options.name)
        os.close(slave)
        os.set_blocking(self.master, False)

    def unplug(self) -> None:
        os.unlink(self.options.name)
        os.close(self.master)
        self.master = -1

    def rates_agree(self) -> bool:
        code = termios.tcgetattr(self.master)[5]
        return code == getattr(termios, f"B{self.baud}")

    def send(self, data: bytes) -> None:
        if self.master < 0 or self.silent:
            return
        if not self.rates_agree():
            data = bytes((5 * byte + 1) & 0xFF for byte in data[::2])
        with contextlib.suppress(OSError):
            os.write(self.master, data)

    def noise(self) -> float:
        self.seed = (self.seed * 1103515245 + 12345) & 0x7FFFFFFF
        return self.seed / 0x3FFFFFFF - 1.0

    def epoch(self, second: float) -> None:
        """Everything about one epoch, valid at UTC `second`."""
        utc = datetime.fromtimestamp(second, UTC)
        north, east = 1e-5 * self.noise(), 1e-5 * self.noise()
        self.send(self.binary(utc, north, east) if self.pvt else b"")
        for name in sorted(self.sentences):
            self.send(self.sentence(name, utc, north, east))

    def binary(self, utc: datetime, north: float, east: float) -> bytes:
        fixed = not self.options.no_fix
        week_s = (utc.weekday() + 1) % 7 * 86400 + utc.hour * 3600 + utc.minute * 60 + utc.second + 18
        message = UBXMessage(
            "NAV", "NAV-PVT", GET,
            iTOW=week_s % 604800 * 1000 + utc.microsecond // 1000,
            year=utc.year, month=utc.month, day=utc.day, hour=utc.hour, min=utc.minute, second=utc.second,
            nano=utc.microsecond // 1000 * 1_000_000,
            validDate=1, validTime=1, fullyResolved=1, tAcc=30,
            fixType=3 if fixed else 0, gnssFixOk=int(fixed), numSV=9,
            lon=LONGITUDE + east, lat=LATITUDE + north, height=round(1000 * (HEIGHT + SEPARATION)),
            hMSL=round(1000 * HEIGHT), hAcc=2500, vAcc=4000, sAcc=200, pDOP=1.8,
        )  # fmt: skip
        return message.serialize()

    def sentence(self, name: str, utc: datetime, north: float, east: float) -> bytes:
        clock, date = f"{utc:%H%M%S}.{utc.microsecond // 10000:02d}", f"{utc:%d%m%y}"
        lat, lon = degrees(LATITUDE + north, 2), degrees(LONGITUDE + east, 3)
        if self.options.no_fix:
            body = {"GGA": f"GNGGA,{clock},,,,,0,00,99.99,,,,,,", "RMC": f"GNRMC,{clock},V,,,,,,,{date},,,N"}
        else:
            body = {
                "GGA": f"GNGGA,{clock},{lat},N,{lon},E,1,09,0.95,{HEIGHT:.1f},M,{SEPARATION:.1f},M,,",
                "RMC": f"GNRMC,{clock},A,{lat},N,{lon},E,0.010,,{date},,,A",
            }
        text = body.get(name, "GNGSA,A,3,04,05,09,12,,,,,,,,,1.80,0.95,1.50")
        check = 0
        for character in text.encode():
            check ^= character
        return f"${text}*{check:02X}\r\n".encode()

    def listen(self) -> None:
        try:
            data = os.read(self.master, 4096)
        except (BlockingIOError, OSError):
            return
        if self.options.deaf or not self.rates_agree():
            return
        self.heard += data
        while (at := self.heard.find(b"\xb5\x62")) >= 0 and len(self.heard) >= at + 6:
            length = int.from_bytes(self.heard[at + 4 : at + 6], "little")
            end = at + 8 + length
            if len(self.heard) < end:
                return
            self.obey(bytes(self.heard[at + 2 : end - 2]))
            del self.heard[:end]

    def obey(self, body: bytes) -> None:
        kind, payload = body[:2], body[4:]
        if kind == b"\x0a\x04":
            self.send(
                UBXMessage(
                    "MON", "MON-VER", GET, swVersion=b"EXT CORE 3.01", hwVersion=b"00080000"
                ).serialize()
            )
            return
        if kind[0] != 0x06:
            return
        self.send(UBXMessage("ACK", "ACK-ACK", GET, clsID=6, msgID=kind[1]).serialize())
        if kind == b"\x06\x00" and len(payload) == 20:
            time.sleep(0.02)
            self.baud = int.from_bytes(payload[8:12], "little")
        elif kind == b"\x06\x01" and payload[:2] == b"\x01\x07":
            self.pvt = payload[2] > 0
        elif kind == b"\x06\x01" and payload[0] == 0xF0:
            name = {0: "GGA", 1: "GLL", 2: "GSA", 3: "GSV", 4: "RMC", 5: "VTG"}.get(payload[1], "")
            (self.sentences.add if payload[2] else self.sentences.discard)(name)


def degrees(value: float, width: int) -> str:
    whole = math.floor(value)
    return f"{whole:0{width}d}{(value - whole) * 60:08.5f}"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("name")
    parser.add_argument("--baud", type=int, default=9600)
    parser.add_argument("--deaf", action="store_true")
    parser.add_argument("--no-fix", action="store_true")
    parser.add_argument("--latency", type=float, default=0.06)
    receiver = Receiver(parser.parse_args())
    print("ready", flush=True)
    next_second = math.floor(time.time()) + 1
    while True:
        due = next_second + receiver.options.latency
        wait = min(max(0.0, due - time.time()), 0.01)
        for ready in select.select([sys.stdin], [], [], wait)[0]:
            word = ready.readline()
            if not word:
                return
            command = {"unplug": receiver.unplug, "plug": receiver.plug}.get(word.strip())
            if command is not None:
                command()
            else:
                receiver.silent = word.strip() == "silence"
            print("done", flush=True)
        if receiver.master >= 0:
            receiver.listen()
        if time.time() >= due:
            receiver.epoch(next_second)
            next_second += 1


if __name__ == "__main__":
    main()
