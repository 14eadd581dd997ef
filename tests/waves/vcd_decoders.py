"""Decoders of line levels, written from the protocols' definitions alone: what a logic analyser would see."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

Changes = list[tuple[int, str]]
"""(time in ns, level) of a line, the first of them its level at the beginning."""


def read_vcd(path: Path) -> dict[str, Changes]:
    """The changes of every line of a VCD file of scalars. Times that go back are an error."""
    names: dict[str, str] = {}
    lines: dict[str, Changes] = {}
    now = None
    for row in path.read_text("ascii").splitlines():
        words = row.split()
        if words[:1] == ["$var"]:
            names[words[3]] = words[4]
            lines[words[4]] = []
        elif row.startswith("#"):
            assert now is None or int(row[1:]) > now
            now = int(row[1:])
        elif row[:1] in "01xz" and row:
            assert now is not None
            lines[names[row[1:]]].append((now, row[0]))
    return lines


class Probe:
    """Levels of one line at rising instants."""

    def __init__(self, changes: Changes) -> None:
        self._changes = changes
        self._place = 0

    def at(self, time_ns: int) -> str:
        """Level just behind `time_ns`; times must not go back."""
        while self._place + 1 < len(self._changes) and self._changes[self._place + 1][0] <= time_ns:
            self._place += 1
        return self._changes[self._place][1]


@dataclass(frozen=True)
class Exchange:
    start_ns: int
    end_ns: int
    mosi: bytes
    miso: bytes


def _events(lines: list[Changes]) -> list[tuple[int, int, str, str]]:
    """(time, line, level before, level behind) of all changes in order of time."""
    events = []
    for number, changes in enumerate(lines):
        for (_, before), (time_ns, after) in pairwise(changes):
            events.append((time_ns, number, before, after))
    return sorted(events)


def decode_spi(sck: Changes, mosi: Changes, miso: Changes, select: Changes, mode: int) -> list[Exchange]:
    """Bytes between the edges of a chip select. A bit is sampled where the clock leaves its idle level
    (CPHA 0) or comes back to it (CPHA 1); its data must have been there before and stay behind."""
    idle, late = str(mode >> 1), mode & 1
    out, back = Probe(mosi), Probe(miso)
    steps = [(t, was, now) for (_, was), (t, now) in pairwise(sck) if was != now]
    samples = [t for t, _, now in steps if (now == idle) == late]
    found = []
    place = 0
    falls = [t for t, level in select if level == "0"]
    rises = [t for t, level in select[1:] if level == "1"]
    for start, end in zip(falls, rises, strict=False):
        bits: list[tuple[str, str]] = []
        while place < len(samples) and samples[place] < end:
            if samples[place] > start:
                levels = out.at(samples[place] - 1), back.at(samples[place] - 1)
                assert levels == (out.at(samples[place]), back.at(samples[place]))
                bits.append(levels)
            place += 1
        assert len(bits) % 8 == 0
        found.append(Exchange(start, end, _bytes([b[0] for b in bits]), _bytes([b[1] for b in bits])))
    return found


def _bytes(bits: list[str]) -> bytes:
    return bytes(int("".join(bits[k : k + 8]), 2) for k in range(0, len(bits), 8))


@dataclass
class Conversation:
    """From a start condition to a stop condition. `parts`: after each (repeated) start the bytes with their
    acknowledges; `end_ns` None: no stop condition came."""

    start_ns: int
    parts: list[list[tuple[int, bool]]]
    end_ns: int | None = None
    longest_low_ns: int = 0


def decode_i2c(scl: Changes, sda: Changes) -> list[Conversation]:
    """SDA falls or rises while SCL is high: start and stop; bits where SCL rises."""
    found: list[Conversation] = []
    levels = {0: scl[0][1], 1: sda[0][1]}
    bits: list[str] = []
    low_since = 0
    for time_ns, line, before, after in _events([scl, sda]):
        levels[line] = after
        if line == 0 and after == "0":
            low_since = time_ns
        if line == 0 and after == "1" and found and found[-1].end_ns is None:
            found[-1].longest_low_ns = max(found[-1].longest_low_ns, time_ns - low_since)
            bits.append(levels[1])
            if len(bits) == 9:
                found[-1].parts[-1].append((int("".join(bits[:8]), 2), bits[8] == "0"))
                bits = []
        if line == 1 and levels[0] == "1" and before != after:
            if after == "0" and found and found[-1].end_ns is None:
                found[-1].parts.append([])
            elif after == "0":
                found.append(Conversation(time_ns, [[]]))
            elif found and found[-1].end_ns is None:
                found[-1].end_ns = time_ns
            bits = []
    return found


def decode_uart(line: Changes, baud: int, from_ns: int = 0) -> list[tuple[int, int]]:
    """(falling edge of the start bit, byte): sampled in the middle of the bits; the stop bit must be high."""
    found = []
    free = from_ns
    probe = Probe(line)
    for time_ns, level in line:
        if level == "0" and time_ns >= free:
            samples = [probe.at(time_ns + (2 * k + 1) * 10**9 // (2 * baud)) for k in range(10)]
            assert samples[0] == "0"
            assert samples[9] == "1"
            found.append((time_ns, sum(int(samples[k + 1]) << k for k in range(8))))
            free = time_ns + 19 * 10**9 // (2 * baud)
    return found


@dataclass(frozen=True)
class Frame:
    end_ns: int
    identifier: int
    extended: bool
    data: bytes
    acknowledged: bool


def decode_can(line: Changes, bitrate: int) -> list[Frame]:
    """Frames with their stuff bits taken out, CRC and form checked; end: of the last bit."""
    found = []
    free = -1
    probe = Probe(line)
    for time_ns, level in line[1:]:
        if level == "0" and time_ns >= free:
            sampled = [int(probe.at(time_ns + (2 * k + 1) * 10**9 // (2 * bitrate))) for k in range(175)]
            frame, length = _frame(sampled)
            free = time_ns + length * 10**9 // bitrate
            found.append(Frame(free, *frame))
            probe = Probe(line)
    return found


def _frame(sampled: list[int]) -> tuple[tuple[int, bool, bytes, bool], int]:
    place, run, last = 0, 0, 1
    content: list[int] = []

    def take(count: int) -> int:
        nonlocal place, run, last
        value = 0
        for _ in range(count):
            bit = sampled[place]
            place += 1
            run = run + 1 if bit == last else 1
            last = bit
            content.append(bit)
            value = value << 1 | bit
            if run == 5:
                assert sampled[place] != last, "six equal bits"
                last, run = sampled[place], 1
                place += 1
        return value

    assert take(1) == 0
    identifier = take(11)
    take(1)
    extended = bool(take(1))
    if extended:
        identifier = identifier << 18 | take(18)
        assert take(1) == 0, "a remote frame"
        take(1)
    take(1)
    data = bytes([take(8) for _ in range(take(4))])
    checked = list(content)
    crc = take(15)
    remainder = 0
    for bit in [*checked, *[0] * 15]:  # x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1
        remainder = remainder << 1 | bit
        if remainder >> 15:
            remainder ^= 0b1100_0101_1001_1001
    assert remainder == crc, "CRC"
    assert sampled[place] == 1, "CRC delimiter"
    acknowledged = sampled[place + 1] == 0
    assert sampled[place + 2 : place + 10] == [1] * 8, "acknowledge delimiter, end of frame"
    return (identifier, extended, data, acknowledged), place + 10
