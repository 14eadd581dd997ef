"""One transcript of the wire pins driver and model: here the model answers, in tests/drivers the driver asks.

The body turns by 10° a second, pitched by 5°, rolled by −12°. When a change is meant, replace the file by
what the assertion shows and review the difference.
"""

from __future__ import annotations

from pathlib import Path

from hmc6343_rig import Rig

TRANSCRIPT = Path(__file__).with_name("hmc6343_golden.txt")


def test_model_answers_the_transcript() -> None:
    expected = TRANSCRIPT.read_text().splitlines()
    rig = Rig(lambda t: (10.0 * t % 360.0, 5.0, -12.0))
    lines: list[str] = []
    for line in expected:
        words = line.partition("->")[0].split()
        if words[0] == "delay":
            rig.wait(int(words[1]))
        elif "write" in words:
            rig.bus.transaction(int(words[2], 16), bytes.fromhex("".join(words[4:])))
        elif "read" in words:
            data = rig.bus.transaction(int(words[2], 16), b"", int(words[4]))
            line = f"{' '.join(words)} -> {data.hex(' ')}"
        lines.append(line)
    assert lines == expected
    assert rig.chip.reports == []
