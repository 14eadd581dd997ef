"""A transcript of the wire, kept as text: every byte and every edge of INT1 must come again.

A line of the transcript is `time_ns MOSI -> MISO`, or `time_ns INT1 level` for an edge; `#` comments. The
world is deterministic: a slow swing. When a change of the model is meant, replace the file by what the
assertion shows and review the difference.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from bmi160_rig import BYTE_NS, G, Rig

TRANSCRIPT = Path(__file__).with_name("bmi160_golden.txt")


def swing(t: np.ndarray) -> dict[str, Any]:
    """1 Hz in yaw with its centripetal and a tilt of 30 mg; warming by 0.1 °C a second."""
    angle = 2.0 * np.pi * t
    return {
        "fx": 0.03 * G + 0.2 * np.cos(angle),
        "fy": -0.1 * np.sin(angle),
        "fz": G,
        "wx": 0.01 * np.sin(2.0 * angle),
        "wz": 1.5 * np.sin(angle),
        "temperature": 24.0 + 0.1 * t,
    }


def test_transcript() -> None:
    expected = TRANSCRIPT.read_text().splitlines()
    rig = Rig(swing, listen="INT1", clock_error_ppm=5000.0)
    lines: list[str] = []
    seen = 0

    def note_edges() -> None:
        nonlocal seen
        for when, level in rig.edges["INT1"][seen:]:
            lines.append(f"{when} INT1 {int(level)}")
        seen = len(rig.edges["INT1"])

    for line in expected:
        if line.startswith("#") or not line.strip():
            lines.append(line)
            continue
        if " INT1 " in line:
            continue
        when, mosi = int(line.split()[0]), bytes.fromhex(line.split()[1])
        rig.until(when)
        note_edges()
        miso = rig.chip.transaction(mosi, when, when + len(mosi) * BYTE_NS)
        lines.append(f"{when} {mosi.hex()} -> {miso.hex()}")
        note_edges()
        rig.until(when + len(mosi) * BYTE_NS)
    note_edges()
    assert lines == expected
