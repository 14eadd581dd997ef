"""Programs that nobody here wrote: socat, gpsd with gpspipe, candump-like loggers. Skipped where they are not
installed (apt-get install socat gpsd gpsd-clients)."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import socket
import subprocess
import sys
import threading
import time
import tty

import can
import pytest
from served_board import ServedHere


def needs(*programs: str) -> pytest.MarkDecorator:
    missing = [program for program in programs if shutil.which(program) is None]
    return pytest.mark.skipif(bool(missing), reason=f"not installed: {', '.join(missing)}")


@needs("socat")
@pytest.mark.parametrize("place", ["pty", "tcp"])
def test_socat_gets_every_byte(place, tmp_path):
    link = tmp_path / "tty"
    uart = {"pty": f"pty:{link}", "tcp": "tcp://127.0.0.1:0"}[place]
    with ServedHere(None, f"host={uart}", duration_s=30.0) as board:
        source = f"FILE:{link},rawer" if place == "pty" else board.places["host"].replace("tcp://", "TCP:")
        reader = subprocess.Popen(
            ["socat", "-u", source, "STDOUT"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        while not board.control.ask("status")["uarts"][0]["clients_now"]:
            time.sleep(0.02)
        board.control.ask("resume")
        result = board.ended()
        came, _ = reader.communicate(timeout=20.0)
    (sent,) = result["serve"]["uarts"]
    assert len(came) == sent["bytes_sent"]
    assert hashlib.sha256(came).hexdigest() == sent["sha256_sent"]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@needs("gpsd", "gpspipe")
@pytest.mark.parametrize("place", ["pty", "tcp"])
def test_gpsd_recognises_the_receiver_and_tells_where_the_board_is(place, tmp_path):
    link = tmp_path / "gnss"
    uart = {"pty": f"pty:{link}", "tcp": "tcp://127.0.0.1:0"}[place]
    port = free_port()
    with ServedHere(None, f"gnss={uart}", duration_s=1e6, pace=10.0) as board:
        board.control.ask("resume")
        board.control.until(6.0)
        device = str(link) if place == "pty" else board.places["gnss"]
        daemon = subprocess.Popen(
            ["gpsd", "-N", "-n", "-b", "-S", str(port), device], stderr=subprocess.DEVNULL
        )
        try:
            report = first_fix(port)
        finally:
            daemon.terminate()
            daemon.wait(10.0)
        board.control.ask("stop")
        board.ended()
    assert report["lat"] == pytest.approx(30.5278, abs=2e-4)
    assert report["lon"] == pytest.approx(114.3557, abs=2e-4)
    assert report["mode"] == 3
    assert report["time"].startswith("2024-05-14T08:0")


def first_fix(port: int) -> dict:
    """The first report of gpsd with a three-dimensional fix, as gpspipe prints it."""
    end = time.monotonic() + 40.0
    while time.monotonic() < end:
        command = ["gpspipe", "-w", "-n", "200", "-x", "20", f"127.0.0.1:{port}"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as pipe:
            assert pipe.stdout is not None
            for line in pipe.stdout:
                report = json.loads(line)
                if report.get("class") == "TPV" and report.get("mode") == 3 and "lat" in report:
                    pipe.kill()
                    return report
        time.sleep(0.1)
    raise AssertionError("gpsd told no fix within 40 s")


CAN_LOGGER = """
import can, json, sys
bus = can.Bus(interface="udp_multicast", channel=sys.argv[1], fd=False)
print("open", flush=True)
for data in (b"\\x01", b"\\x02\\x03"):
    bus.send(can.Message(arbitration_id=0x123, data=data, is_extended_id=False))
heard = []
while (message := bus.recv(3.0)) is not None:
    heard.append([message.arbitration_id, bytes(message.data).hex()])
json.dump(heard, sys.stdout)
bus.shutdown()
"""


def test_a_can_logger_in_another_process_hears_the_board_and_is_heard():
    pytest.importorskip("msgpack")
    channel = "239.74.163.77"
    with ServedHere(None, duration_s=1e6, pace=10.0, cans=(f"can1=udp_multicast:{channel}",)) as board:
        logger = subprocess.Popen(
            [sys.executable, "-c", CAN_LOGGER, channel], stdout=subprocess.PIPE, text=True
        )
        assert logger.stdout is not None
        assert logger.stdout.readline() == "open\n"
        board.control.ask("resume")
        board.control.until(10.0)
        board.control.ask("stop")
        result = board.ended()
        heard = json.loads(logger.communicate(timeout=30.0)[0])
    (can,) = result["serve"]["can"]
    assert can["frames_written"] == 2
    boards_own = [frame for frame in heard if frame[0] != 0x123]  # multicast brings the logger its own too
    assert 0.9 * can["frames_sent"] < len(boards_own) <= can["frames_sent"]  # and may lose some
    can1 = next(bus for bus in result["buses"] if bus["name"] == "can1")
    assert can1["transactions"] == can["frames_sent"] + 2


def test_datagrams_that_are_no_can_frames_are_counted_and_keep_no_frame_away():
    msgpack = pytest.importorskip("msgpack")
    place = ("239.74.163.78", 43113)
    half_a_frame = msgpack.packb({"arbitration_id": 100.5, "is_extended_id": False, "data": b"\1", "dlc": 1})
    junk = (b"", b"\x00", b"junk" * 20, msgpack.packb({"no": "frame"}), half_a_frame)
    with (
        ServedHere(None, duration_s=1e6, pace=10.0, cans=(f"can1=udp_multicast:{place[0]}",)) as board,
        can.Bus(interface="udp_multicast", channel=place[0], fd=False) as bus,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        board.control.ask("resume")
        for k in range(100):
            stranger.sendto(junk[k % len(junk)], place)
            bus.send(can.Message(arbitration_id=k, is_extended_id=False, data=[k]))
            time.sleep(0.005)
        board.control.until(board.control.ask("status")["time_s"] + 10.0)
        board.control.ask("stop")
        (line,) = board.ended()["serve"]["can"]
    assert line["frames_written"] == 100
    assert line["foreign"] == 100


def test_a_serial_can_adapter_carries_frames_both_ways():
    """An slcan device as its text protocol has it: tiiildd… and a carriage return."""
    device, port = os.openpty()
    tty.setraw(port)
    said = bytearray()
    listening = threading.Thread(target=listen, args=(device, said), daemon=True)
    listening.start()
    with ServedHere(None, duration_s=1e6, pace=10.0, cans=(f"slcan:{os.ttyname(port)}",)) as board:
        board.control.ask("resume")
        board.control.until(1.0)
        os.write(device, b"t12321A2B\rT0123456780001020304050607\rt7FF0\r")
        while board.control.ask("status")["can"][0]["frames_written"] < 3:
            time.sleep(0.01)
        board.control.until(10.0)
        board.control.ask("stop")
        result = board.ended()
    os.close(port)
    listening.join(5.0)
    (can,) = result["serve"]["can"]
    frames = [line for line in bytes(said).split(b"\r") if line[:1] in (b"t", b"T")]
    assert len(frames) == can["delivered"] == can["frames_sent"] > 100
    assert can["frames_written"] == 3
    assert {frame[1:4] for frame in frames} >= {b"310", b"311"}


def listen(device: int, said: bytearray) -> None:
    """Up to the end."""
    with contextlib.suppress(OSError):
        while data := os.read(device, 65_536):
            said += data
