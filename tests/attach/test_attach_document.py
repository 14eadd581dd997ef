"""The raw frames of docs/link.md are those of the code."""

import re
from pathlib import Path

import pytest

from firmware.link import raw_frames

TEXT = (Path(__file__).parents[2] / "docs" / "link.md").read_text(encoding="utf-8")
SECTION = TEXT.split("## Raw frames\n", 1)[1].split("\n## ", 1)[0]
SIZES = {"u8": 1, "u16": 2, "u32": 4, "i64": 8, "f64": 8}
CODES = {"u8": "B", "u16": "H", "u32": "I", "i64": "q", "f64": "d"}


def table(text):
    rows = re.search(r"(?:^\|.*\n)+", text, re.M)[0].splitlines()
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows[2:]]


def test_types_and_lengths():
    rows = {int(kind, 16): (f"RAW_{name}", length) for kind, name, length, _ in table(SECTION)}
    assert all(getattr(raw_frames, name) == kind for kind, (name, _) in rows.items())
    lengths = {kind: str(layout.size) for kind, layout in raw_frames.INPUTS.items()}
    lengths[raw_frames.RAW_WANTED] = str(raw_frames.WANTED.size)
    lengths[raw_frames.RAW_STATE] = f"{raw_frames.SLICE_HEAD.size} + n"
    assert {kind: length for kind, (_, length) in rows.items()} == lengths


@pytest.mark.parametrize("kind", [*raw_frames.INPUTS, raw_frames.RAW_STATE])
def test_byte_tables(kind):
    layout, offset = "<", 0
    for place, number, _name, _ in table(SECTION.split(f"### 0x{kind:02X} ", 1)[1]):
        code, _, count = number.partition(" × ")
        assert int(place) == offset
        offset += SIZES[code] * int(count or 1)
        layout += CODES[code] * int(count or 1)
    told = raw_frames.SLICE_HEAD if kind == raw_frames.RAW_STATE else raw_frames.INPUTS[kind]
    expanded = re.sub(r"(\d+)(\w)", lambda m: ("B" if m[2] == "s" else m[2]) * int(m[1]), told.format)
    assert layout == expanded
