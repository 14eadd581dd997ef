"""A reader of the inertial unit as others write it, from the table of its frame.

A CRC bit by bit, a byte at a time, lost bytes, and what it found summed up to angles and velocities.
"""

from __future__ import annotations

from math import cos, pi, sin
from random import Random

import numpy as np
import pytest
from serial_imu_rig import MS, Motion, Rig

G = 9.80665


def crc(data: bytes) -> int:
    """CRC-16/CCITT-FALSE as the textbook has it."""
    value = 0xFFFF
    for byte in data:
        for bit in range(8):
            top = (value >> 15 ^ byte >> (7 - bit)) & 1
            value = value << 1 & 0xFFFF
            value ^= 0x1021 * top
    return value


def number(data: bytes) -> int:
    value = data[0] | data[1] << 8 | data[2] << 16 | data[3] << 24
    return value - (1 << 32 if value >> 31 else 0)


class Reader:
    """Looks for AA 55 in a window of 32 bytes that moves on by one byte until the CRC is right."""

    def __init__(self) -> None:
        self.window = bytearray()
        self.counters: list[int] = []
        self.angle = np.zeros(3)
        self.velocity = np.zeros(3)

    def take(self, byte: int) -> None:
        window = self.window
        window.append(byte)
        while len(window) >= 32:
            good = window[:2] == b"\xaa\x55" and crc(window[2:30]) == window[30] | window[31] << 8
            if good:
                self.counters.append(window[2] | window[3] << 8)
                self.angle += [number(window[k : k + 4]) * 1e-9 for k in (4, 8, 12)]
                self.velocity += [number(window[k : k + 4]) * 1e-8 for k in (16, 20, 24)]
            del window[: 32 if good else 1]


def swinging() -> Motion:
    return Motion(
        fx=lambda t: 2.0 * np.cos(2 * pi * t), fz=lambda t: -G + 0.0 * t,
        wy=lambda t: -0.4 * np.sin(pi * t), wz=lambda t: 0.3 + 0.0 * t,
    )  # fmt: skip


def test_what_it_sums_up_is_the_motion() -> None:
    """From 0.495 s, when the first period begins, to the end of the last frame found."""
    rig, reader = Rig(swinging()), Reader()
    rig.wait(3_000 * MS)
    for data, _ in rig.chunks:
        for byte in data:
            reader.take(byte)
    begin, end = 0.495, 0.495 + 0.005 * len(reader.counters)
    assert reader.counters == list(range(500))
    assert reader.angle == pytest.approx(
        [0.0, 0.4 / pi * (cos(pi * end) - cos(pi * begin)), 0.3 * (end - begin)], abs=1e-6
    )
    assert reader.velocity == pytest.approx(
        [(sin(2 * pi * end) - sin(2 * pi * begin)) / pi, 0.0, -G * (end - begin)], abs=2e-5
    )


def test_bytes_lost_on_the_way_cost_their_frames_and_no_other() -> None:
    rig, reader, chance = Rig(swinging()), Reader(), Random(4)
    rig.wait(3_000 * MS)
    hurt = set()
    for frame, (data, _) in enumerate(rig.chunks):
        for byte in data:
            if chance.random() < 0.002:
                hurt.add(frame)
            else:
                reader.take(byte)
    assert len(hurt) > 10
    # A frame behind a hurt one goes too where the hurt one's beginning swallows it.
    lost = set(range(500)) - set(reader.counters)
    assert hurt <= lost
    assert lost - hurt <= {frame + 1 for frame in hurt}
