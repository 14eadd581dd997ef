"""Opening a serial port, and saying in one message why it cannot be opened.

A port is whatever pyserial opens by its address: /dev/ttyUSB0, COM3, socket://HOST:PORT,
rfc2217://HOST:PORT, loop://, or the path of a pseudo-terminal.
"""

from __future__ import annotations

import errno
import os
import stat
from enum import Enum
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import serial
from serial.tools.list_ports import comports

try:
    import grp
except ImportError:  # Windows
    grp = None  # type: ignore[assignment]

EXAMPLE = "e.g. /dev/ttyUSB0 or socket://192.168.1.5:2000"
READ_TIMEOUT_S = 0.2
WRITE_TIMEOUT_S = 2.0
WITHOUT_WRITE_TIMEOUT = frozenset({"rfc2217"})


class PortProblem(Enum):
    """Why a port cannot be had."""

    ADDRESS = "not the address of a serial port"
    MISSING = "there is no such port"
    DENIED = "permission denied"
    BUSY = "in use by another program"
    UNREACHABLE = "nobody answers there"
    NO_PORT = "not a serial port"
    RATE = "a rate that the port does not have"
    OTHER = "cannot be opened"


class PortError(Exception):
    """A serial port cannot be opened. The message says why and what to do about it."""

    def __init__(self, problem: PortProblem, message: str) -> None:
        super().__init__(message)
        self.problem = problem


def open_port(url: str, baud: int, timeout_s: float = READ_TIMEOUT_S) -> Any:
    """The open port, ours alone where the system can grant that. Raises PortError."""
    if not isinstance(baud, int) or not 50 <= baud <= 12_000_000:
        raise PortError(PortProblem.RATE, f"{url}: a rate of {baud} baud; possible are e.g. 9600 or 115200")
    if not _has_port_number(url):
        raise PortError(
            PortProblem.ADDRESS,
            f"{url!r} is no address of a port: it needs a number of 1 to 65535; {EXAMPLE}",
        )
    try:
        port = serial.serial_for_url(url, do_not_open=True, baudrate=baud)
    except (ValueError, ImportError) as error:
        raise PortError(
            PortProblem.ADDRESS, f"{url!r} is no serial port: {error}; give one, {EXAMPLE}"
        ) from None
    except OSError as error:  # hwgrep:// finds nothing
        raise PortError(PortProblem.MISSING, f"{url}: {error}; {_ports_there_are()}") from None
    port.timeout = timeout_s
    if urlsplit(url).scheme not in WITHOUT_WRITE_TIMEOUT:
        port.write_timeout = WRITE_TIMEOUT_S
    try:
        if hasattr(port, "exclusive") and is_device(url):
            port.exclusive = True
        port.open()
    except (OSError, ValueError) as error:  # pyserial's own error is an OSError
        raise explained(url, baud, error) from None
    return port


def has_rate(url: str) -> bool:
    """Whether a bit rate means anything there."""
    return not url.startswith(("socket://", "loop://"))


def is_device(url: str) -> bool:
    """Whether the address is a path of this computer rather than a URL."""
    return "://" not in url


def explained(url: str, baud: int, error: Exception) -> PortError:
    """What a failure to open means for whoever typed the address."""
    code = getattr(error, "errno", None)
    if not is_device(url):
        return _explained_url(url, error)
    path = Path(url)
    if code in (errno.EACCES, errno.EPERM):
        return PortError(PortProblem.DENIED, f"{url}: permission denied; {_how_to_be_allowed(path)}")
    if code == errno.ENOENT or not path.exists():
        return PortError(PortProblem.MISSING, f"{url}: there is no such port; {_ports_there_are()}")
    if code in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error):
        return PortError(
            PortProblem.BUSY, f"{url}: in use by {_holders(path)}; close it there, or take another port"
        )
    if not stat.S_ISCHR(path.stat().st_mode) or "configure port" in str(error):
        return PortError(PortProblem.NO_PORT, f"{url} is not a serial port; {_ports_there_are()}")
    if isinstance(error, ValueError):
        return PortError(PortProblem.RATE, f"{url}: {error} ({baud} baud); try e.g. 9600 or 115200")
    return PortError(PortProblem.OTHER, f"{url} cannot be opened: {error}")


def _explained_url(url: str, error: Exception) -> PortError:
    text = str(error)
    if isinstance(error, ValueError) or "expected a string in the form" in text:
        return PortError(PortProblem.ADDRESS, f"{url!r} is no address of a port: {text}; {EXAMPLE}")
    if "RFC2217" in text:
        return PortError(
            PortProblem.NO_PORT,
            f"{url}: somebody answers there, but not by RFC 2217; is it meant as socket://?",
        )
    reason = text.rpartition("] ")[2] if "Errno" in text else text
    return PortError(
        PortProblem.UNREACHABLE,
        f"{url}: nobody answers there ({reason}); is the server running on that port?",
    )


def _has_port_number(url: str) -> bool:
    """Whether an address of another computer tells a port there."""
    try:
        parts = urlsplit(url)
        return parts.scheme not in ("socket", "rfc2217") or (parts.port or 0) > 0
    except ValueError:
        return False


def _ports_there_are() -> str:
    names = sorted(port.device for port in comports())
    return f"there are: {', '.join(names)}" if names else "no serial port is connected to this computer"


def _how_to_be_allowed(path: Path) -> str:
    try:
        group = grp.getgrgid(path.stat().st_gid).gr_name
    except (AttributeError, KeyError, OSError):
        return "ask whoever administers this computer for access to it"
    return f"it belongs to the group {group}: sudo usermod -aG {group} $USER, then log in again"


def _holders(path: Path) -> str:
    """Names and numbers of the processes that have the file open, as far as this user may see them."""
    target = path.resolve()
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            open_files = [os.readlink(link) for link in (process / "fd").iterdir()]
            if str(target) in open_files:
                name = (process / "comm").read_text().strip()
                found.append(f"{name} (process {process.name})")
        except OSError:
            continue
    return ", ".join(found) or "another program"
