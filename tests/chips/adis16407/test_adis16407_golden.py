"""One transcript of the wire pins driver and model: here the model answers, in tests/drivers the driver asks.

The world: x turns faster by 0.1 °/s every 10 ms, y at −0.05, z at 300 °/s; −1 g and 1 g on x and z; 0.2, −0.1
and 0.45 gauss; 35 °C; 1000.0009375 mbar. When a change is meant, replace the file by what the assertion
shows and review the difference.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from adis16407_rig import US, G, Rig

TRANSCRIPT = Path(__file__).with_name("adis16407_golden.txt")


def turning_faster(t: Any) -> dict[str, Any]:
    return {
        "wx": 0.1 * np.floor((t - 0.21) * 100.0), "wy": -0.05, "wz": 300.0, "fx": -G, "fz": G,
        "bx": 0.2, "by": -0.1, "bz": 0.45, "temperature": 35.0, "pressure": 1000.0009375,
    }  # fmt: skip


def test_model_answers_the_transcript() -> None:
    expected = TRANSCRIPT.read_text().splitlines()
    rig = Rig(turning_faster, started=False)
    lines: list[str] = []
    for line in expected:
        words = line.split()
        if words[0] == "delay":
            rig.wait(int(words[1]))
        elif words[0] == "spi":
            mosi = bytes.fromhex(line.split("->")[0].split("imu")[1])
            miso = rig.spi(mosi, 254 * US if len(mosi) == 30 else None)
            line = f"spi imu {mosi.hex(' ')} -> {miso.hex(' ')}"
        lines.append(line)
    assert lines == expected
    assert rig.chip.reports == []
