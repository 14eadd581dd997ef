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
from hal.live.rate_search import RateSearch, beginning_with
from hal.live.traffic import KNOWN, Recogniser, understood

RATES = beginning_with(9600, 115_200, 38_400, 460_800)
"""Those of receivers, most common first."""
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
    search = RateSearch(rates, listen_s, least_bytes=-1)
    heard: list[Heard] = []
    try:
        while not (search.settled or search.all_tried):
            one = _listen(port, search, recognisers)
            if one is not None:
                heard.append(one)
    except (OSError, SerialException) as error:
        raise PortError(PortProblem.OTHER, f"{url} went away while it was listened to: {error}") from None
    finally:
        with suppress(Exception):
            port.close()
    return Probe(url, tuple(heard))


def _listen(port: Any, search: RateSearch, recognisers: Mapping[str, Recogniser]) -> Heard | None:
    """Listen until the rate is sure or in doubt; None when the port cannot do it."""
    baud = search.baud
    try:
        port.baudrate = baud
    except (ValueError, OSError):
        search.turn(time.monotonic())
        return None
    port.reset_input_buffer()
    search.wait_again(time.monotonic())
    data = bytearray()
    while True:
        look_at = time.monotonic() + POLL_S
        while time.monotonic() < look_at:
            data += port.read(max(1, port.in_waiting))
        one = Heard(baud, len(data), *understood(bytes(data), recognisers))
        if one.is_sure:
            search.understand(time.monotonic())
            return one
        if search.in_doubt(time.monotonic()):
            search.turn(time.monotonic())
            return one
