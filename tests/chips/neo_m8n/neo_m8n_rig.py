"""A receiver on a bench: a sky that the test sets, a real wire, and a host that keeps what it hears."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from typing import Any

from pynmeagps import NMEAReader
from pyubx2 import UBXReader

from boards.chips.neo_m8n import NeoM8n
from boards.chips.world import GnssEpoch, Satellite
from hal.emulated.pins import Net
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import SECOND, VirtualTime

MILLISECOND = 1_000_000
LEAP_SECONDS = 18
WEEK_NS = 604_800 * SECOND
START_GPS_NS = 2305 * WEEK_NS + (5 * 86_400 + 9 * 3600 + 27 * 60 + 25 + LEAP_SECONDS) * SECOND
"""2024-03-15 09:27:25 UTC."""

SKY = tuple(
    Satellite(
        "GPS" if number <= 32 else "SBAS", number, math.radians(elevation), math.radians(azimuth), cn0, used
    )
    for number, elevation, azimuth, cn0, used in (
        (1, 53, 280, 36.2, True),
        (3, 29, 301, 24.0, True),
        (4, 55, 223, 36.6, True),
        (8, 38, 166, 16.0, False),
        (11, 40, 245, 29.0, True),
        (12, 5, 34, 0.0, False),
        (46, 43, 156, 0.0, False),
    )
) + tuple(
    Satellite("GLONASS", number, math.radians(elevation), math.radians(azimuth), cn0, used)
    for number, elevation, azimuth, cn0, used in ((67, 62, 349, 26.0, True), (84, 1, 353, 0.0, False))
)

EPOCH = GnssEpoch(
    fix=True,
    time_known=True,
    gps_time_ns=START_GPS_NS,
    leap_seconds=LEAP_SECONDS,
    latitude=math.radians(50.0 + 30.12345 / 60.0),
    longitude=math.radians(-(4.0 + 15.54321 / 60.0)),
    height=87.4 + 48.1,
    geoid_separation=48.1,
    velocity_ned=(3.0, 4.0, -0.25),
    h_acc=1.2,
    v_acc=2.04,
    s_acc=0.12,
    pdop=1.56,
    hdop=0.95,
    vdop=1.27,
    tdop=0.9,
    satellites=SKY,
    latency_ns=80 * MILLISECOND,
)


class BenchWorld:
    """Every epoch is `now` with the time moved on; a test replaces `now` as it likes."""

    def __init__(self, **changes: Any) -> None:
        self.now = replace(EPOCH, **changes)
        self.asked: list[int] = []

    def set(self, **changes: Any) -> None:
        """Change the sky from now on."""
        self.now = replace(self.now, **changes)

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The world face."""
        self.asked.append(time_ns)
        return replace(self.now, gps_time_ns=self.now.gps_time_ns + time_ns)


class Host:
    """The other end of the wire."""

    def __init__(self) -> None:
        self.chunks: list[tuple[int, bytes]] = []

    def receive(self, data: bytes, time_ns: int) -> None:
        """UART peer."""
        self.chunks.append((time_ns, data))

    @property
    def data(self) -> bytes:
        """Everything heard."""
        return b"".join(data for _, data in self.chunks)


class Rig:
    """Chip, wires and host on one virtual time."""

    def __init__(self, *, start_state: str = "hot", listen: bool = False, **parameters: Any) -> None:
        self.time = VirtualTime()
        self.world = parameters.pop("world", None) or BenchWorld()
        self.wire = UartWire(self.time, 9600, "gnss to host")
        self.command_wire = UartWire(self.time, 9600, "host to gnss")
        self.host = Host()
        self.wire.connect(self.host)
        self.chip = NeoM8n(self.time, self.world, self.wire, start_state=start_state, **parameters)
        self.command_wire.connect(self.chip, rate_of=self.wire)
        self.pulse = Net(self.time, "TIMEPULSE")
        self.chip.pins["TIMEPULSE"] = self.pulse
        self.edges: list[tuple[int, bool]] = []
        if listen:
            self.pulse.listen(lambda level, time_ns: self.edges.append((time_ns, level)))

    def run(self, seconds: float) -> bytes:
        """Let time pass; returns what the host heard meanwhile."""
        return self.run_to(self.time.now + round(seconds * SECOND))

    def run_to(self, time_ns: int) -> bytes:
        """Let time pass until `time_ns`."""
        heard = len(self.host.chunks)
        while self.time.next_due <= time_ns:
            self.time.run_next()
        self.time.now = time_ns
        return b"".join(data for _, data in self.host.chunks[heard:])

    def say(self, data: bytes | str) -> None:
        """The host sends bytes (hex when a string), which are there at once."""
        self.chip.receive(bytes.fromhex(data) if isinstance(data, str) else data, self.time.now)

    def ask(self, data: bytes | str, seconds: float = 0.9) -> list[Any]:
        """Send, wait, and return the UBX messages that came back, parsed."""
        self.say(data)
        return ubx_messages(self.run(seconds))


def quiet_rig(**parameters: Any) -> Rig:
    """A started receiver with a fix whose periodic sentences have been switched off."""
    rig = Rig(**parameters)
    rig.run(3.0)
    for message in range(6):
        rig.say(ubx(0x06, 0x01, bytes((0xF0, message, 0))))
    rig.run(2.0)
    return rig


def ubx(message_class: int, message_id: int, payload: bytes = b"") -> bytes:
    """A frame, built without the model's own code."""
    body = bytes((message_class, message_id)) + len(payload).to_bytes(2, "little") + payload
    ck_a = ck_b = 0
    for byte in body:
        ck_a = (ck_a + byte) & 0xFF
        ck_b = (ck_b + ck_a) & 0xFF
    return b"\xb5\x62" + body + bytes((ck_a, ck_b))


def nmea(body: str) -> bytes:
    """A sentence, built without the model's own code."""
    checksum = 0
    for character in body:
        checksum ^= ord(character)
    return f"${body}*{checksum:02X}\r\n".encode()


def lines(data: bytes) -> list[str]:
    """Sentences in a stream that holds nothing else."""
    return data.decode("ascii").split("\r\n")[:-1]


def line(data: bytes, name: str) -> str:
    """The last sentence of a kind, e.g. "RMC"."""
    return [text for text in lines(data) if text[3:6] == name or text[1:8] == name][-1]


def nmea_messages(data: bytes) -> list[Any]:
    """Sentences parsed by pynmeagps, with checksums checked; anything unparsable raises."""
    return [parsed for _, parsed in NMEAReader(io.BytesIO(data), quitonerror=2, nmeaonly=True)]


def ubx_messages(data: bytes, broken: int = 2) -> list[Any]:
    """UBX messages parsed by pyubx2; sentences in between are skipped, broken frames raise (0: are left)."""
    return [parsed for _, parsed in UBXReader(io.BytesIO(data), protfilter=2, quitonerror=broken)]


def rate_of(rig: Rig) -> int:
    """The measurement period that the receiver answers, ms."""
    return next(m.measRate for m in rig.ask(ubx(6, 8)) if m.identity == "CFG-RATE")
