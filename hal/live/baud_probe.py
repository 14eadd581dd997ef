"""At which rate does the other end of a serial line talk?

The line is listened to at one known rate after the other. At a wrong rate framing errors and bytes without
sense come in, at the right one whole sentences. A device that waits to be asked cannot be found this way.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from serial import SerialException

from hal.live.port import PortError, PortProblem, open_port
from hal.live.traffic import KNOWN, Recogniser, understood

RATES = (9600, 115_200, 38_400, 460_800, 230_400, 57_600, 19_200, 4800, 921_600)
"""Most common first."""
LISTEN_S = 1.3
"""A receiver that talks once a second is heard in every such time."""
SURE_BYTES = 60
SURE_SHARE = 0.9
LEAST_BYTES = 16
LEAST_SHARE = 0.5
POLL_S = 0.05


@dataclass(frozen=True)
class Heard:
    """What came in at one rate."""

    baud: int
    bytes_heard: int
    bytes_understood: int
    kind: str
    """What was understood, e.g. "NMEA and UBX"."""

    @property
    def makes_sense(self) -> bool:
        """Whether enough of it was understood."""
        enough = self.bytes_understood >= LEAST_BYTES
        return enough and self.bytes_understood >= LEAST_SHARE * self.bytes_heard

    @property
    def is_sure(self) -> bool:
        """Whether no other rate needs to be tried."""
        enough = self.bytes_understood >= SURE_BYTES
        return enough and self.bytes_understood >= SURE_SHARE * self.bytes_heard


@dataclass(frozen=True)
class Probe:
    """What came in at all rates that were tried."""

    url: str
    heard: tuple[Heard, ...]

    @property
    def best(self) -> Heard | None:
        """The rate that makes sense; None when none does."""
        sensible = [one for one in self.heard if one.makes_sense]
        return max(sensible, key=lambda one: one.bytes_understood / one.bytes_heard, default=None)

    def __str__(self) -> str:
        best = self.best
        if best is not None:
            return f"{self.url} talks {best.kind} at {best.baud} baud"
        rates = ", ".join(str(one.baud) for one in self.heard)
        if not any(one.bytes_heard for one in self.heard):
            return f"{self.url} is silent at {rates} baud: is the device on, and its TX wired to our RX?"
        most = max(self.heard, key=lambda one: one.bytes_heard)
        return (
            f"{self.url} sends bytes that make no sense at {rates} baud "
            f"({most.bytes_heard} at {most.baud}, {most.bytes_understood} of them understood)"
        )


def probe_baud(
    url: str,
    rates: Sequence[int] = RATES,
    recognisers: Mapping[str, Recogniser] = KNOWN,
    listen_s: float = LISTEN_S,
) -> Probe:
    """Listen at each of `rates` until one is sure. Takes up to `listen_s` each. Raises PortError."""
    port = open_port(url, rates[0], timeout_s=POLL_S)
    heard: list[Heard] = []
    try:
        for baud in rates:
            one = _listen(port, baud, recognisers, listen_s)
            if one is None:
                continue
            heard.append(one)
            if one.is_sure:
                break
    except (OSError, SerialException) as error:
        raise PortError(PortProblem.OTHER, f"{url} went away while it was listened to: {error}") from None
    finally:
        with suppress(Exception):
            port.close()
    return Probe(url, tuple(heard))


def _listen(port: Any, baud: int, recognisers: Mapping[str, Recogniser], listen_s: float) -> Heard | None:
    """None when the port cannot do that rate."""
    try:
        port.baudrate = baud
    except (ValueError, OSError):
        return None
    port.reset_input_buffer()
    data = bytearray()
    deadline = time.monotonic() + listen_s
    while time.monotonic() < deadline:
        look_at = time.monotonic() + POLL_S
        while time.monotonic() < look_at:
            data += port.read(max(1, port.in_waiting))
        one = Heard(baud, len(data), *understood(bytes(data), recognisers))
        if one.is_sure:
            break
    return Heard(baud, len(data), *understood(bytes(data), recognisers))
