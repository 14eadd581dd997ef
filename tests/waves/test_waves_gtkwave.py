"""GTKWave's own converters read the files: every change of every line comes back out of its database."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from vcd_decoders import read_vcd
from wave_captures import PORT, bus_table, capture, finish, processor, waves

from hal.emulated.spi import EmulatedSpiBus, SpiTiming


class Inverting:
    """Answers every byte with its complement."""

    def transaction(self, mosi, start_ns, end_ns):
        return bytes(byte ^ 0xFF for byte in mosi)


@pytest.mark.skipif(
    shutil.which("vcd2fst") is None or shutil.which("fst2vcd") is None, reason="GTKWave is not installed"
)
def test_gtkwave_reads_every_change(tmp_path: Path) -> None:
    cpu = processor()
    bus = EmulatedSpiBus(cpu, SpiTiming(5_250_000), "spi9")
    writer = capture(tmp_path / "a.mcap", bus_table("spi9", "spi", 5_250_000, 3) + PORT)
    device = bus.device(Inverting(), "plain")
    device.observer = writer.spi_recorder("spi9.plain")
    told = writer.line_recorder("p")
    for k in range(20):
        told(cpu.time.now, cpu.time.now, 0, 115_200, bytes((k, 255 - k)), k % 3)
        device.transaction(bytearray(bytes((k, 0x55, 0xAA))))
        cpu.time.now += 400_000
    source, database, back = tmp_path / "a.vcd", tmp_path / "a.fst", tmp_path / "b.vcd"
    assert waves(finish(writer, cpu.time.now + 1), "-o", source).exit_code == 0
    subprocess.run(["vcd2fst", str(source), str(database)], check=True, capture_output=True, timeout=60)
    done = subprocess.run(["fst2vcd", str(database)], check=True, capture_output=True, timeout=60)
    back.write_bytes(done.stdout)
    lines = read_vcd(source)
    assert sum(len(changes) for changes in lines.values()) > 500
    assert read_vcd(back) == lines
