"""Eight hours of board time at full speed, and ten minutes of noise on every input."""

from __future__ import annotations

import hashlib
import os
import random
import re
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import can
import pytest
from served_board import ServedHere

from host.capture.reader import CaptureReader
from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict

READER = Path(__file__).with_name("link_reader.py")


@pytest.mark.soak
def test_eight_hours_at_full_speed_lose_and_reorder_nothing(tmp_path):
    """A client in a process of its own counts the link's sequence numbers and hashes all that comes; the
    capture holds what the board really sent."""
    lines = ("host=tcp://127.0.0.1:0", "gnss=tcp://127.0.0.1:0")
    with ServedHere(tmp_path / "out", *lines, duration_s=8 * 3600.0) as board:
        clients = {name: reader_of(board.places[name]) for name in ("host", "gnss")}
        board.control.ask("resume")
        heard = {name: client.communicate()[0].split() for name, client in clients.items()}
        result = board.ended(3600.0)
    sent = {line["name"]: line for line in result["serve"]["uarts"]}
    for name, (count, digest, _gaps, _frames) in heard.items():
        assert (int(count), digest) == (sent[name]["bytes_sent"], sent[name]["sha256_sent"])
        assert sent[name]["lost"] == 0
    gaps, frames = map(int, heard["host"][2:])
    assert gaps == 0
    assert frames > 8 * 3600 * 10
    recorded = hashlib.sha256()
    for window in CaptureReader(tmp_path / "out" / "run.mcap").windows():
        recorded.update(data_of(window.raw.get("/uart/host/tx", b"")))
    assert recorded.hexdigest() == heard["host"][1]


def data_of(block: bytes) -> bytes:
    """The bytes of records of what a UART sent: end i64, baud u32, n u32, n bytes."""
    pieces, place = [], 0
    while place < len(block):
        n = int.from_bytes(block[place + 12 : place + 16], "little")
        pieces.append(block[place + 16 : place + 16 + n])
        place += 16 + n
    return b"".join(pieces)


def reader_of(place: str) -> subprocess.Popen[str]:
    """A process that reads everything from a TCP place."""
    host, _, port = place.removeprefix("tcp://").rpartition(":")
    reader = subprocess.Popen([sys.executable, str(READER), host, port], stdout=subprocess.PIPE, text=True)
    assert reader.stdout is not None
    assert reader.stdout.readline() == "open\n"
    return reader


@pytest.mark.parametrize("minutes", [0.5, pytest.param(10, marks=pytest.mark.soak)])
def test_noise_on_every_input_breaks_nothing_and_is_counted(minutes, tmp_path):
    noise = random.Random(3)
    channel = f"noise-{os.getpid()}"
    lines = ("host=tcp://127.0.0.1:0", "gnss=rfc2217://127.0.0.1:0")
    served = ServedHere(tmp_path / "out", *lines, duration_s=60.0 * minutes, cans=(f"virtual:{channel}",))
    written = {"host": 0, "gnss": 0}
    with served as board, can.Bus(interface="virtual", channel=channel) as bus:
        clients = {}
        for name in written:
            host, port = re.match(r"\w+://(.*):(\d+)", board.places[name]).groups()
            clients[name] = socket.create_connection((host, int(port)), timeout=20.0)
            threading.Thread(target=drain, args=(clients[name],), daemon=True).start()
        board.control.ask("resume")
        garbage = socket.create_connection(board.control.connection.getpeername())
        number = 0
        while served.alive:
            number += 1
            for name, client in clients.items():
                data = noise.randbytes(noise.randrange(1, 4000))
                if put(client, data):
                    written[name] += len(data)
            bus.send(
                can.Message(
                    arbitration_id=noise.getrandbits(11),
                    data=noise.randbytes(noise.randrange(9)),
                    is_extended_id=bool(noise.getrandbits(1)),
                )
            )
            if not put(garbage, noise.randbytes(200)):
                garbage = called_again(board, garbage)
            time.sleep(0.001)
        result = board.ended()
    sent = {line["name"]: line for line in result["serve"]["uarts"]}
    buses = {bus["name"]: bus for bus in result["buses"]}
    assert buses["host.rx"]["bytes"] == sent["host"]["bytes_written"] > 10_000 * minutes
    assert 0 < sent["host"]["bytes_written"] <= written["host"]
    assert 0 < sent["gnss"]["bytes_written"] < written["gnss"]  # less the commands of the protocol in it
    assert result["serve"]["can"][0]["frames_written"] <= number
    assert sum(cpu["resets"] for cpu in result["cpu"]) == 0
    replayed = replay_strict(ReplayRequest(tmp_path / "out" / "run.mcap"))
    assert replayed.difference is None
    assert replayed.state_hash == result["state_hash"]


def called_again(board: ServedHere, connection: socket.socket) -> socket.socket:
    """A new connection to the control channel, if it is still there."""
    connection.close()
    try:
        return socket.create_connection(board.control.connection.getpeername())
    except OSError:
        return connection


def drain(client: socket.socket) -> None:
    """Read and forget."""
    try:
        while client.recv(1 << 16):
            pass
    except OSError:
        pass


def put(client: socket.socket, data: bytes) -> bool:
    """Whether all of it could be sent."""
    try:
        client.sendall(data)
    except OSError:
        return False
    return True
