"""One transcript of the wire pins driver and model: here the model answers, in tests/drivers the driver asks.

The world: x grows by one count of 3.9 mg in 10 ms, y is −0.25 g, z 1 g; the clock is 5 MHz. When a change
is meant, replace the file by what the assertion shows and review the difference.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from adxl345_rig import G, Rig

TRANSCRIPT = Path(__file__).with_name("adxl345_golden.txt")
BYTE_NS = 1_600


def growing(t: Any) -> dict[str, Any]:
    return {"fx": 100.0 * t / 256.0 * G, "fy": -0.25 * G, "fz": G}


def test_model_answers_the_transcript() -> None:
    expected = TRANSCRIPT.read_text().splitlines()
    rig = Rig(growing)
    lines: list[str] = []
    for line in expected:
        words = line.split()
        if words[0] == "delay":
            rig.wait(int(words[1]))
        elif words[0] == "spi":
            mosi = bytes.fromhex(line.split("->")[0].split("adxl")[1])
            now = rig.time.now
            miso = rig.chip.transaction(mosi, now, now + len(mosi) * BYTE_NS)
            rig.wait(len(mosi) * BYTE_NS)
            line = f"spi adxl {mosi.hex(' ')} -> {miso.hex(' ')}"
        lines.append(line)
    assert lines == expected
    assert rig.chip.reports == []
