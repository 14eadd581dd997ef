"""Access sequences of public C drivers, replayed by hand on the wire: what they rely on must come out.

Written from what the drivers of analogdevicesinc/no-OS, the Linux kernel (drivers/iio/accel/adxl345_core.c)
and Arduino libraries are known to do.
"""

from __future__ import annotations

from itertools import pairwise
from struct import unpack
from typing import Any

import pytest
from adxl345_rig import MS, US, G, Rig, rising


def spinning(t: Any) -> dict[str, Any]:
    return {"fx": 0.2 * G + 0.0 * t, "fy": -0.1 * G, "fz": 0.97 * G}


def counts(data: bytes) -> list[int]:
    return list(unpack(f"<{len(data) // 2}h", data))


def test_no_os_spi() -> None:
    """Set-up by read-modify-write, words read by bursts, all three or each alone."""
    rig = Rig(spinning)

    def set_bits(register: int, mask: int, value: int) -> None:
        rig.spi(bytes((register, rig.spi(bytes((0x80 | register, 0)))[1] & ~mask | value)))

    assert rig.spi(b"\x80\x00")[1] == 0xE5
    rig.spi(b"\x2d\x00")
    set_bits(0x31, 0x0B, 0x00 | 0x08)
    set_bits(0x2D, 0x08, 0x08)
    rig.wait(30 * MS)
    assert counts(rig.spi(b"\xf2" + bytes(6))[1:]) == [51, -26, 248]
    for register, expected in ((0xF2, 51), (0xF4, -26), (0xF6, 248)):
        assert counts(rig.spi(bytes((register, 0, 0)))[1:]) == [expected]
    set_bits(0x31, 0x0B, 0x03)
    rig.wait(20 * MS)
    assert counts(rig.spi(b"\xf2" + bytes(6))[1:]) == [6, -3, 31]
    assert rig.chip.reports == []


def test_linux_iio_stream() -> None:
    """Every read sets the multi-byte bit; the FIFO in stream mode at 5 MHz with 3 µs of delay between its
    reads, and what a transfer takes to be set up."""
    rig = Rig(lambda t: {"fx": 100.0 * t / 256.0 * G}, listen="INT1", byte_ns=1_600)
    assert rig.spi(b"\xc0\x00")[1] == 0xE5
    for register, value in ((0x2D, 0x00), (0x38, 0x00), (0x31, 0x0B), (0x2C, 0x0A), (0x2E, 0x00)):
        rig.spi(bytes((register, value)))
    rig.spi(bytes((0x38, 0x80 | 15)))
    rig.spi(b"\x2f\x00")
    rig.spi(b"\x2e\x02")
    rig.spi(b"\x2d\x08")
    got: list[int] = []
    for _ in range(5):
        while not rig.nets["INT1"].level:
            rig.wait(100 * US)
        source = rig.spi(b"\xf0\x00")[1]
        assert source & 0x82 == 0x82
        assert not source & 0x01
        entries = rig.spi(b"\xf9\x00")[1] & 0x3F
        assert entries >= 15
        for _ in range(entries):
            got += counts(rig.spi(b"\xf2" + bytes(6))[1:3])
            rig.wait(3 * US)
        assert not rig.nets["INT1"].level
    steps = {b - a for a, b in pairwise(got)}
    assert steps == {1}
    assert rig.chip.reports == []


def test_linux_iio_overrun_is_mended_by_a_flush() -> None:
    rig = Rig(byte_ns=1_600)
    for register, value in ((0x31, 0x0B), (0x38, 0x80 | 15), (0x2E, 0x02), (0x2D, 0x08)):
        rig.spi(bytes((register, value)))
    rig.wait(2_000 * MS)
    assert rig.spi(b"\xf0\x00")[1] & 0x01
    for register, value in ((0x2D, 0x00), (0x38, 0x00), (0x38, 0x80 | 15), (0x2D, 0x08)):
        rig.spi(bytes((register, value)))
    assert rig.spi(b"\xf0\x00")[1] & 0x83 == 0
    assert rig.spi(b"\xf9\x00")[1] == 0


@pytest.mark.parametrize("address_first", [True, False])
def test_arduino_i2c(address_first: bool) -> None:
    """POWER_CTL 0, 16, 8 one after the other; then six bytes, or one after the other."""
    rig = Rig(spinning)
    face = rig.chip.i2c

    def write(*data: int) -> None:
        rig.wait(1 * MS)
        assert face.write(bytes(data), rig.time.now) == len(data)

    def read(register: int, count: int) -> bytes:
        write(register)
        rig.wait(100 * US)
        return face.read(count, rig.time.now)

    for value in (0, 16, 8):
        write(0x2D, value)
    rig.wait(30 * MS)
    data = read(0x32, 6) if address_first else b"".join(read(0x32 + k, 1) for k in range(6))
    assert counts(data) == [51, -26, 248]
    assert rig.chip.reports == []


def test_arduino_tap_interrupt_on_int1() -> None:
    """The tutorial: taps on z, 3.1 g, 31.25 ms, both interrupts on INT1, INT_SOURCE read in the loop."""
    rig = Rig(lambda t: {"fz": G + 5.0 * G * ((t > 0.5) & (t < 0.51))}, listen="INT1")
    for register, value in (
        (0x2D, 0x08), (0x2A, 0x01), (0x1D, 50), (0x21, 50), (0x22, 80), (0x23, 200), (0x2F, 0), (0x2E, 0x60),
    ):  # fmt: skip
        rig.write(register, value)
    rig.wait(1_000 * MS)
    (when,) = rising(rig.edges["INT1"])
    assert when == pytest.approx(510 * MS + 350 * MS, abs=1 * MS)  # the window of a double tap is over
    assert rig.byte(0x30) & 0x60 == 0x40
    assert not rig.nets["INT1"].level


def test_sequence_of_the_sheet_for_the_self_test() -> None:
    """Full resolution, 16 g, 100 Hz; means of 0.1 s before and after."""
    rig = Rig(spinning)
    for register, value in ((0x31, 0x0B), (0x2C, 0x0A), (0x2D, 0x08), (0x2E, 0x80)):
        rig.write(register, value)

    def mean() -> list[float]:
        total = [0, 0, 0]
        for _ in range(10):
            while not rig.byte(0x30) & 0x80:
                rig.wait(200 * US)
            total = [a + b for a, b in zip(total, rig.xyz(), strict=True)]
        return [value / 10 for value in total]

    mean()
    before = mean()
    rig.write(0x31, 0x8B)
    for _ in range(4):
        rig.wait(10 * MS)
    rig.xyz()
    x, y, z = (b - a for a, b in zip(before, mean(), strict=True))
    assert 50 <= x <= 540
    assert -540 <= y <= -50
    assert 75 <= z <= 875
