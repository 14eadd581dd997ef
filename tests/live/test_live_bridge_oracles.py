"""The emulated bridge in front of a client that nobody here wrote: flashrom, where it is installed."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from emulated_bus_pirate import EmulatedBusPirate
from pty_port import PtyPort

FLASHROM = shutil.which("flashrom") or shutil.which("flashrom", path="/usr/sbin")


class SerialFlash:
    """A Winbond W25X10: 128 KiB, JEDEC id EF 30 11."""

    def __init__(self) -> None:
        random = np.random.Generator(np.random.PCG64(3))
        self.data = random.integers(0, 256, 128 * 1024, np.uint8).tobytes()

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        command, length = mosi[0], len(mosi)
        if command == 0x9F:
            answer = b"\xff\xef\x30\x11"
        elif command == 0x03 and length > 4:
            address = int.from_bytes(mosi[1:4], "big")
            answer = b"\xff" * 4 + self.data[address : address + length - 4]
        elif command == 0x05:
            answer = b"\xff" + bytes(length - 1)
        else:
            answer = b""
        return (answer + b"\xff" * length)[:length]


def flashrom(bridge: EmulatedBusPirate, folder: Path, *more: str) -> str:
    assert FLASHROM is not None
    with PtyPort(folder / "ttyBRIDGE", bridge.feed) as port:
        where = f"buspirate_spi:dev={port.path},spispeed=2M,serialspeed=115200"
        done = subprocess.run(
            [FLASHROM, "-p", where, "-c", "W25X10", "-V", *more],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.skipif(FLASHROM is None, reason="flashrom is not installed")
def test_flashrom_reads_a_chip_by_write_then_read(tmp_path: Path) -> None:
    flash = SerialFlash()
    told = flashrom(EmulatedBusPirate(spi=flash), tmp_path, "-r", str(tmp_path / "chip.bin"))
    assert "SPI command set v2" in told
    assert (tmp_path / "chip.bin").read_bytes() == flash.data


@pytest.mark.skipif(FLASHROM is None, reason="flashrom is not installed")
def test_flashrom_finds_a_chip_by_bulk_transfers(tmp_path: Path) -> None:
    """What it does with older firmware is what our client does."""
    bridge = EmulatedBusPirate(spi=SerialFlash(), firmware="v5.0")
    told = flashrom(bridge, tmp_path)
    assert "does not support fast SPI access" in told
    assert "id1 0xef, id2 0x3011" in told
    assert bridge.transfers[0] == (b"\x9f\x00\x00\x00", b"\xff\xef\x30\x11")
