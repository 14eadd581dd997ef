"""The monitor in a terminal: keys, and the terminal as it was afterwards."""

import os
import pty
import select
import signal
import struct
import sys
import termios
import time
from pathlib import Path

import pytest
from spoken_drive import spoken, write_capture


class Terminal:
    """A monitor in a terminal of its own, 100 × 30."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        import fcntl

        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 100, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.output = bytearray()
        self.process = os.fork()
        if self.process == 0:
            os.setsid()
            fcntl.ioctl(self.slave, termios.TIOCSCTTY, 0)
            for descriptor in (0, 1, 2):
                os.dup2(self.slave, descriptor)
            environment = {**os.environ, "TERM": "xterm-256color"}
            environment.pop("NO_COLOR", None)
            command = [sys.executable, "-m", "host.cli.main", "monitor", *arguments]
            os.execve(sys.executable, command, environment)

    def wait_for(self, words: str, seconds: float = 15.0) -> None:
        """Until they stand on the screen."""
        end = time.monotonic() + seconds
        while words.encode() not in self.output:
            assert time.monotonic() < end, bytes(self.output[-3000:]).decode(errors="replace")
            self._read(0.1)

    def type(self, keys: bytes) -> None:
        os.write(self.master, keys)

    def end(self, seconds: float = 10.0) -> int:
        """Exit code of the program."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._read(0.05)
            process, status = os.waitpid(self.process, os.WNOHANG)
            if process:
                self._read(0.05)
                return os.waitstatus_to_exitcode(status)
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)
        raise AssertionError("the monitor did not end")

    def _read(self, seconds: float) -> None:
        ready, _, _ = select.select([self.master], [], [], seconds)
        if ready:
            self.output += os.read(self.master, 65536)


@pytest.mark.parametrize("leave", [b"\x03", b"q"])
def test_the_terminal_is_left_as_it_was(leave, tmp_path):
    path = write_capture(tmp_path / "run.mcap", spoken(60))
    terminal = Terminal(tmp_path, str(path))
    terminal.wait_for("navigating")
    assert termios.tcgetattr(terminal.slave) != terminal.before
    terminal.type(b" ")
    terminal.wait_for("paused")
    terminal.type(b"\x1b[C\x1b[C")
    terminal.wait_for("0:00:2")
    assert b"\x1b[?1049h" in terminal.output
    terminal.type(leave)
    assert terminal.end() == 0
    assert terminal.output.rindex(b"\x1b[?1049l") > terminal.output.rindex(b"\x1b[?1049h")
    assert b"\x1b[?25h" in terminal.output[-40:]
    assert termios.tcgetattr(terminal.slave) == terminal.before
    assert b"Traceback" not in terminal.output
