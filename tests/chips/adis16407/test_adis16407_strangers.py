"""Sequences of public drivers, written down from what they send, not from our driver.

The register access of Linux' adis library (two transfers with a chip-select change and 50 µs, both bytes of a
register by two writes, self-test through MSC_CTRL and DIAG_STAT), a burst as one transfer of 30 bytes without
pauses, and a polling loop that sends the next request with each answer.
"""

from __future__ import annotations

import pytest
from adis16407_rig import MS, START_UP, US, G, Rig


class LinuxAdis:
    """Read: word with the address, 50 µs, empty word. Write: low byte, 50 µs, high byte, 50 µs. 2 MHz."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig

    def transfer(self, mosi: bytes) -> bytes:
        now = self.rig.time.now
        miso = self.rig.chip.transaction(mosi, now, now + 8 * US)
        self.rig.until(now + 58 * US)
        return miso

    def read_16(self, register: int) -> int:
        self.transfer(bytes((register, 0)))
        return int.from_bytes(self.transfer(bytes(2)), "big")

    def write_16(self, register: int, value: int) -> None:
        self.transfer(bytes((0x80 | register, value & 0xFF)))
        self.transfer(bytes((0x80 | register + 1, value >> 8)))


@pytest.fixture
def rig() -> Rig:
    return Rig(lambda t: {"wx": 10.0, "fz": -G}, strict=True)


def test_linux_initial_setup(rig: Rig) -> None:
    linux = LinuxAdis(rig)
    control = linux.read_16(0x38)
    linux.write_16(0x38, control | 0x0400)  # self-test
    rig.wait(35 * MS)
    assert linux.read_16(0x40) == 0
    assert linux.read_16(0x38) & 0x0400 == 0
    linux.write_16(0x38, control & ~0x0004 | 0x0002)  # data ready off until asked for
    product = linux.read_16(0x56)
    assert product == 16407
    assert linux.read_16(0x3A) == 1  # 819.2 SPS, so that 2 MHz may stay
    linux.write_16(0x3C, linux.read_16(0x3C) & ~0x07 | 3)
    linux.write_16(0x38, control | 0x0004)
    rig.wait(20 * MS)
    assert linux.read_16(0x04) & 0x3FFF == 200
    linux.transfer(bytes((0xC2, 0x80)))  # software reset
    rig.wait(START_UP)
    assert linux.read_16(0x3C) == 0x0402


def test_one_transfer_of_30_bytes_at_900_khz(rig: Rig) -> None:
    miso = rig.spi(b"\x42\x00" + bytes(28), 240 * 1_000_000 // 900)
    assert miso[4:6] == (200 | 0x8000).to_bytes(2, "big")
    assert miso[14:16] == (-300 & 0x3FFF | 0x8000).to_bytes(2, "big")


def test_requests_and_answers_interleaved(rig: Rig) -> None:
    registers = [0x04, 0x06, 0x08, 0x0A, 0x0C, 0x0E]
    answers = [rig.word(register << 8) for register in (*registers, 0x56)][1:]
    assert [answer & 0x3FFF for answer in answers] == [200, 0, 0, 0, 0, -300 & 0x3FFF]


def test_small_processor_that_holds_chip_select_over_two_words() -> None:
    """100 kHz, no pause between the words, the same request twice; a write sends the high byte first."""
    rig = Rig(lambda t: {"wx": 10.0, "fz": -G})

    def pair(first: int, second: int) -> int:
        miso = rig.spi(first.to_bytes(2, "big") + second.to_bytes(2, "big"), 320 * US)
        rig.wait(5 * US)
        return int.from_bytes(miso[2:], "big")

    def read(register: int) -> int:
        return pair(register << 8, register << 8)

    def write(register: int, value: int) -> None:
        pair(0x8000 | register + 1 << 8 | value >> 8, 0x8000 | register << 8 | value & 0xFF)
        rig.wait(2 * MS)

    assert read(0x56) == 16407
    assert read(0x04) & 0x3FFF == 200
    write(0x1E, -800 & 0x3FFF)  # of 0.0125 deg/s: 10 deg/s
    rig.wait(50 * MS)
    assert read(0x04) & 0x3FFF == 0
    assert read(0x1E) & 0x1FFF == -800 & 0x1FFF
    assert {report.kind.value for report in rig.chip.reports} <= {"timing rule broken", "reserved bits set"}
