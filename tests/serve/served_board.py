"""A board served by a process of its own, and clients for its control channel."""

from __future__ import annotations

import json
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

from host.record.result import RunRequest
from host.serve.address import Address
from host.serve.service import Wanted, figures_of, opened

PLACE = re.compile(r"^(?:UART (\w+), .*|CAN (\w+)|(control)): (\S+)$")
CLIENT = Path(__file__).with_name("serial_client.py")


class Control:
    """The control channel, as any program would use it."""

    def __init__(self, place: str) -> None:
        host, _, port = place.rpartition(":")
        self.connection = socket.create_connection((host.strip("[]"), int(port)), timeout=30.0)
        self._lines = self.connection.makefile("rb")

    def ask(self, command: str, **arguments: Any) -> dict[str, Any]:
        """Send a command; the reply."""
        return self.say(json.dumps({"command": command, **arguments}).encode())

    def say(self, line: bytes) -> dict[str, Any]:
        """Send a line; the reply."""
        self.connection.sendall(line + b"\n")
        return json.loads(self._lines.readline())

    def until(self, time_s: float, limit_s: float = 60.0) -> dict[str, Any]:
        """Wait for a virtual time; the status then."""
        end = time.monotonic() + limit_s
        while (status := self.ask("status"))["time_s"] < time_s:
            assert time.monotonic() < end, status
            time.sleep(0.01)
        return status


class Board:
    """A served board that waits for `resume`; `places` are told by name, `told` holds every line."""

    def __init__(self) -> None:
        self.places: dict[str, str] = {}
        self.told: list[str] = []

    def tell(self, line: str) -> None:
        """A line of the served board."""
        self.told.append(line.rstrip())
        match = PLACE.match(line)
        if match:
            self.places[match[1] or match[2] or match[3]] = match[4]

    def ended(self, limit_s: float = 120.0) -> dict[str, Any]:
        """Wait for its end; what --json would hold."""
        raise NotImplementedError

    def connect(self, name: str) -> socket.socket:
        """A TCP connection to a served line."""
        host, _, port = self.places[name].removeprefix("tcp://").rpartition(":")
        return socket.create_connection((host, int(port)), timeout=30.0)


class ServedHere(Board):
    """In a thread of this process, which is there at once."""

    def __init__(
        self,
        out: Path | None,
        *uarts: str,
        duration_s: float = 30.0,
        board: str = "car_mems",
        scenario: str = "static",
        changes: tuple[str, ...] = (),
        **wanted: Any,
    ) -> None:
        super().__init__()
        request = RunRequest(
            board,
            scenario,
            overrides=(f"duration_s={duration_s!r}", *changes),
            out_dir=out,
            capture=wanted.pop("capture", True),
        )
        wanted = {"pace": 0.0, "paused": True, **wanted}
        self._wanted = Wanted(uarts=uarts, control=Address("127.0.0.1", 0), tell=self.tell, **wanted)
        self._request = request
        self._ready = threading.Event()
        self._result: dict[str, Any] = {}
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> ServedHere:
        self._thread.start()
        if not self._ready.wait(180.0) or "control" not in self.places:
            raise TimeoutError("the served board did not come up")
        self.control = Control(self.places["control"])
        return self

    def __exit__(self, *_error: object) -> None:
        if self._thread.is_alive():
            self.service.stop()
            self.service.stop()
            self._thread.join(20.0)

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        return self._thread.is_alive()

    def ended(self, limit_s: float = 120.0) -> dict[str, Any]:
        """Wait for its end."""
        self._thread.join(limit_s)
        assert not self._thread.is_alive()
        return self._result

    def _serve(self) -> None:
        try:
            with opened(self._request, self._wanted) as self.service:
                self._ready.set()
                result = self.service.serve()
                self._result = {**result.to_dict(), "serve": figures_of(self.service)}
        finally:
            self._ready.set()


class Served(Board):
    """In a process of its own, as a user has it."""

    def __init__(self, out: Path, *options: str, scenario: str = "static", paused: bool = True) -> None:
        super().__init__()
        self.out = out
        control = ("--control", "127.0.0.1:0", *(["--paused"] if paused else []))
        command = [sys.executable, "-m", "host.cli.main", "serve", "car_mems", "-s", scenario, *control]
        command += ["--out", str(out), "--json", str(out) + ".json", *options]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.tell(line)
            if "control" in self.places:
                break
        self._reader = threading.Thread(target=self._listen, daemon=True)
        self._reader.start()

    def __enter__(self) -> Served:
        assert "control" in self.places, self.told
        self.control = Control(self.places["control"])
        return self

    def __exit__(self, *_error: object) -> None:
        self.process.kill()
        self.process.wait()

    def end(self, by: int = signal.SIGTERM) -> dict[str, Any]:
        """Stop it as a user does; what --json holds."""
        self.process.send_signal(by)
        return self.ended()

    def ended(self, limit_s: float = 120.0) -> dict[str, Any]:
        """Wait for its end; what --json holds."""
        self.code = self.process.wait(limit_s)
        self._reader.join(5.0)
        return json.loads(Path(str(self.out) + ".json").read_text())

    def _listen(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.tell(line)


def serial_client(url: str, *options: str) -> subprocess.Popen[str]:
    """A process of its own that opens `url` with pyserial; ready when this returns."""
    client = subprocess.Popen(
        [sys.executable, str(CLIENT), url, *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert client.stdout is not None
    assert client.stdout.readline() == "open\n"
    return client


def heard_by(client: subprocess.Popen[str]) -> dict[str, Any]:
    """What a serial client tells at its end."""
    assert client.stdout is not None
    found = json.loads(client.stdout.readline())
    client.wait(10.0)
    return found
