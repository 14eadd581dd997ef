"""Serial links: ports that vanish and come back, wrong rates, ports that cannot be had."""

import os
import pty
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from live_benches import until
from pty_port import PtyPort

from hal.emulated.uart_bytes import SentBytes, sample
from hal.live.baud_probe import probe_baud
from hal.live.cpu import LiveCpu
from hal.live.port import PortError, PortProblem, explained, open_port
from hal.live.serial_link import SerialLink
from hal.live.traffic import nmea, ubx
from hal.live.uart import LiveUart

GGA = b"$GPGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.01,499.6,M,48.0,M,,*5B\r\n"
"""The example of u-blox' protocol specification."""
ACK = bytes.fromhex("b5 62 05 01 02 00 06 00 0e 37")
"""UBX-ACK-ACK of CFG-PRT, as receivers send it."""


def garbled(data: bytes, sent_baud: int, heard_baud: int) -> bytes:
    """What a UART at one rate hears of another at another, sampled bit by bit."""
    if sent_baud == heard_baud:
        return data
    return b"".join(found.data for found in sample([SentBytes(data, 0, 0, sent_baud)], heard_baud, 0))


def checksummed(body: bytes) -> bytes:
    total = 0
    for byte in body:
        total ^= byte
    return b"$%s*%02X\r\n" % (body, total)


# -- vanishing ports -------------------------------------------------------------------------------


def test_a_port_that_is_unplugged_comes_back(tmp_path: Path) -> None:
    cpu = LiveCpu({"rx": 1})
    with PtyPort(tmp_path / "ttyGNSS") as device:
        link = SerialLink(str(device.path), 9600)
        uart = LiveUart(cpu, link)
        changes: list[bool] = []
        link.on_change = changes.append
        ring = bytearray(64)
        uart.start_receive(ring, cpu.attach("rx", lambda: None))
        device.send(b"before")
        until(lambda: uart.received() == 6)
        assert ring[:6] == b"before"

        device.unplug()
        until(lambda: not link.is_open)
        assert not link.is_open
        assert uart.write(b"into the void") == 13  # a cable that nobody has plugged in takes everything
        assert link.counters.bytes_lost == 13
        assert link.counters.losses == 1
        uart.set_baud(19200)  # remembered for when it is back
        assert uart.take_errors() == 0
        time.sleep(0.25)

        device.plug_in()
        until(lambda: link.is_open, 3.0)
        assert link.counters.reopenings == 1
        assert changes == [False, True]
        assert device.baud == 19200
        device.send(b"after")
        until(lambda: uart.received() == 11)
        assert ring[6:11] == b"after"
        uart.write(b"hello")
        until(lambda: device.written.endswith(b"hello"))
        assert device.written.endswith(b"hello")
        link.close()


def test_a_server_that_restarts_is_found_again() -> None:
    server = socket.create_server(("127.0.0.1", 0))
    port = server.getsockname()[1]
    link = SerialLink(f"socket://127.0.0.1:{port}", 115_200)
    heard = bytearray()
    link.receiver = heard.extend  # type: ignore[assignment]
    first, _ = server.accept()
    first.sendall(b"one")
    until(lambda: bytes(heard) == b"one")
    server.close()
    first.close()
    until(lambda: not link.is_open)
    with socket.create_server(("127.0.0.1", port)) as again:
        second, _ = again.accept()
        until(lambda: link.is_open)  # opening a port empties it
        second.sendall(b"two")
        until(lambda: bytes(heard) == b"onetwo")
        assert bytes(heard) == b"onetwo"
        second.close()
    link.close()
    assert link.counters.losses >= 1


def test_a_lot_of_bytes_come_through_in_order(tmp_path: Path) -> None:
    cpu = LiveCpu({"rx": 1})
    with PtyPort(tmp_path / "ttyFAST") as device:
        link = SerialLink(str(device.path), 115_200)
        uart = LiveUart(cpu, link)
        ring = bytearray(1 << 18)
        uart.start_receive(ring, cpu.attach("rx", lambda: None))
        data = os.urandom(200_000)
        device.send(data)
        until(lambda: uart.received() == len(data), 10.0)
        assert ring[: len(data)] == data
        sent = 0
        deadline = time.monotonic() + 10.0
        while sent < len(data) and time.monotonic() < deadline:
            sent += uart.write(data[sent : sent + 1000])
            cpu.delay(100_000)
        until(lambda: len(device.written) == len(data))
        assert device.written == data
        link.close()


def test_an_end_that_does_not_read_fills_the_queue_and_no_more() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        uart = LiveUart(LiveCpu(), SerialLink(f"socket://127.0.0.1:{server.getsockname()[1]}", 115_200))
        connection, _ = server.accept()
        stuck = 0
        while stuck < 10:
            stuck = stuck + 1 if uart.write(bytes(4096)) == 0 else 0
            time.sleep(0.005 if stuck else 0)
        assert uart.tx_free() == 0
        assert uart.link.counters.bytes_lost == 0  # refused, not lost
        connection.close()
        uart.link.close()


# -- wrong rates -----------------------------------------------------------------------------------


def test_recognisers_know_published_messages() -> None:
    assert nmea(b"$GPG" + GGA + b"noise" + GGA) == 2 * len(GGA)
    assert nmea(GGA.replace(b"4717", b"4718")) == 0
    assert ubx(b"noise" + ACK + b"\xb5\x62" + ACK) == 2 * len(ACK)


@pytest.mark.parametrize(("talks_at", "first"), [(9600, 115_200), (115_200, 9600), (38_400, 57_600)])
def test_the_rate_of_a_receiver_is_found(tmp_path: Path, talks_at: int, first: int) -> None:
    """The device's bytes are sampled bit by bit at whatever rate the program has set."""
    sentence = checksummed(b"GNRMC,083559.00,A,4717.11437,N,00833.91522,E,0.004,77.52,091202,,,A")
    with PtyPort(tmp_path / "ttyGNSS") as device:
        from threading import Event, Thread

        stop = Event()

        def talk() -> None:
            while not stop.wait(0.02):
                device.send(garbled(sentence, talks_at, device.baud))

        talker = Thread(target=talk, daemon=True)
        talker.start()
        probe = probe_baud(str(device.path), (first, 19_200, talks_at), listen_s=0.15)
        stop.set()
        talker.join()
    assert probe.best is not None
    assert probe.best.baud == talks_at
    assert probe.best.kind == "NMEA"
    assert str(probe) == f"{device.path} talks NMEA at {talks_at} baud"
    wrong = [one for one in probe.heard if one.baud != talks_at]
    assert all(one.bytes_understood == 0 and not one.makes_sense for one in wrong)


def test_noise_has_no_rate(tmp_path: Path) -> None:
    from threading import Event, Thread

    with PtyPort(tmp_path / "ttyNOISE") as device:
        stop = Event()

        def talk() -> None:
            while not stop.wait(0.01):
                device.send(os.urandom(60))

        talker = Thread(target=talk, daemon=True)
        talker.start()
        probe = probe_baud(str(device.path), (9600, 115_200), listen_s=0.15)
        stop.set()
        talker.join()
    assert probe.best is None
    assert "make no sense at 9600, 115200 baud" in str(probe)


def test_a_silent_line_is_told(tmp_path: Path) -> None:
    with PtyPort(tmp_path / "ttySILENT") as device:
        probe = probe_baud(str(device.path), (9600, 115_200), listen_s=0.1)
    assert probe.best is None
    assert "is silent at 9600, 115200 baud" in str(probe)


# -- ports that cannot be had ----------------------------------------------------------------------


def refused(url: str, baud: int = 9600) -> PortError:
    with pytest.raises(PortError) as caught:
        open_port(url, baud).close()
    return caught.value


def test_a_port_that_is_not_there_is_told_with_those_that_are() -> None:
    error = refused("/dev/ttyUSB97")
    assert error.problem is PortProblem.MISSING
    assert str(error).startswith("/dev/ttyUSB97: there is no such port; ")


def test_a_busy_port_is_told_with_who_has_it(tmp_path: Path) -> None:
    with PtyPort(tmp_path / "ttyBUSY") as device:
        holder = subprocess.Popen(
            [
                sys.executable,
                "-c",
                "import sys, serial; port = serial.Serial(sys.argv[1], exclusive=True); "
                "print('open', flush=True); sys.stdin.read()",
                str(device.path),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert holder.stdout is not None
        holder.stdout.readline()
        error = refused(str(device.path))
        holder.communicate()
    assert error.problem is PortProblem.BUSY
    assert f"(process {holder.pid})" in str(error)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody who may not")
def test_a_port_without_permission_is_told_with_the_way_to_it() -> None:
    _master, slave = pty.openpty()
    path = os.ttyname(slave)
    os.chmod(path, 0o600)
    child = subprocess.run(
        [
            sys.executable,
            "-c",
            "import os, sys; sys.path.insert(0, os.getcwd())\n"
            "from hal.live.port import PortError, open_port\n"
            "os.setgroups([]); os.setuid(65534)\n"
            "try:\n    open_port(sys.argv[1], 9600)\n"
            "except PortError as error:\n    print(error.problem.name, error)",
            path,
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert child.stdout.startswith(f"DENIED {path}: permission denied; it belongs to the group "), child
    assert "usermod -aG" in child.stdout


@pytest.mark.parametrize(
    ("url", "problem", "words"),
    [
        ("socket://127.0.0.1:1", PortProblem.UNREACHABLE, "nobody answers there"),
        ("rfc2217://127.0.0.1:1", PortProblem.UNREACHABLE, "nobody answers there"),
        ("socket://127.0.0.1", PortProblem.ADDRESS, "no address of a port"),
        ("socket://127.0.0.1:99999", PortProblem.ADDRESS, "it needs a number of 1 to 65535"),
        ("rfc2217://127.0.0.1:abc", PortProblem.ADDRESS, "it needs a number of 1 to 65535"),
        ("hwgrep://no such device", PortProblem.MISSING, "no ports found"),
        ("nonsense://x", PortProblem.ADDRESS, "is no serial port"),
        ("/", PortProblem.NO_PORT, "is not a serial port"),
        ("/dev/null", PortProblem.NO_PORT, "is not a serial port"),
        ("", PortProblem.MISSING, "there is no such port"),
    ],
)
def test_an_address_that_is_no_port_is_told(url: str, problem: PortProblem, words: str) -> None:
    error = refused(url)
    assert error.problem is problem, error
    assert words in str(error)
    assert "\n" not in str(error)


@pytest.mark.soak
def test_a_plain_tcp_server_is_no_rfc_2217_server() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        error = refused(f"rfc2217://127.0.0.1:{server.getsockname()[1]}")
    assert error.problem is PortProblem.NO_PORT
    assert "not by RFC 2217; is it meant as socket://?" in str(error)


def test_a_file_is_no_port(tmp_path: Path) -> None:
    path = tmp_path / "log.nmea"
    path.write_bytes(GGA)
    assert refused(str(path)).problem is PortProblem.NO_PORT
    assert path.read_bytes() == GGA


@pytest.mark.parametrize("baud", [0, -5, 10**9])
def test_a_rate_that_is_none_is_told(baud: int) -> None:
    assert refused("loop://", baud).problem is PortProblem.RATE


def test_whatever_else_goes_wrong_is_one_line(tmp_path: Path) -> None:
    with PtyPort(tmp_path / "tty") as device:
        error = explained(str(device.path), 9600, OSError(5, "Input/output error"))
    assert error.problem is PortProblem.OTHER
    assert "Input/output error" in str(error)
