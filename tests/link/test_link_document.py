"""docs/link.md is true: its byte tables, lengths, example and CAN table against what the code does."""

import re
from pathlib import Path

import cantools
import pytest

from firmware.link import frames
from firmware.nav.attitude.flags import NOTICE_NAMES, SATURATION_NAMES
from firmware.nav.flags import FLAG_NAMES, MODE_NAMES
from host.link import messages as msg
from host.link.decoder import LinkDecoder

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "link.md").read_text()
SIZES = {"u8": 1, "u16": 2, "i16": 2, "u32": 4, "u64": 8, "i32": 4, "i64": 8, "f32": 4}
CODES = {"u8": "B", "u16": "H", "i16": "h", "u32": "I", "u64": "Q", "i32": "i", "i64": "q", "f32": "f"}
TYPES = {
    "SOLUTION": msg.Solution,
    "STATUS": msg.Status,
    "GNSS": msg.Gnss,
    "SENSOR": msg.Sensor,
    "FILTER": msg.FilterState,
}


def table(heading: str) -> list[list[str]]:
    """Cells of the first table behind a heading, without its two head lines."""
    section = TEXT.split(f"{heading}\n", 1)[1]
    rows = re.search(r"(?:^\|.*\n)+", section, re.M)[0].splitlines()
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows[2:]]


@pytest.mark.parametrize("kind", list(frames.PAYLOADS))
def test_byte_tables(kind):
    heading = re.search(rf"^### 0x{kind:02X} (\w+)$", TEXT, re.M)
    layout, offset, fields = "<", 0, []
    for place, kind_of_number, names, _ in table(heading[0]):
        code, _, count = kind_of_number.partition(" × ")
        assert int(place) == offset, names
        offset += SIZES[code] * int(count or 1)
        layout += CODES[code] * int(count or 1)
        fields += names.split(", ")
    expanded = re.sub(r"(\d+)(\w)", lambda m: m[2] * int(m[1]), frames.PAYLOADS[kind].format)
    assert layout == expanded
    if heading[1] in TYPES:
        assert tuple(fields) == TYPES[heading[1]]._fields


def test_types_and_lengths():
    section = TEXT[TEXT.index("| type | name | length | when |") :]
    cells = (row.strip("|").split("|") for row in section.splitlines()[2:14])
    rows = {int(kind, 16): (name.strip(), length.strip()) for kind, name, length, _ in cells}
    assert all(getattr(frames, name) == kind for kind, (name, _) in rows.items())
    lengths = {kind: str(layout.size) for kind, layout in frames.PAYLOADS.items()}
    lengths[frames.TASKS] = f"{frames.LIST_HEAD.size} + {frames.TASK_ROW.size} n"
    lengths[frames.SATELLITES] = f"{frames.SATELLITE_HEAD.size} + {frames.SATELLITE_ROW.size} n"
    lengths[frames.TEXT] = "any"
    assert {kind: length for kind, (_, length) in rows.items()} == lengths
    assert f"At most {frames.TASK_ROWS_A_FRAME} rows a frame" in TEXT
    assert f"At most {frames.SATELLITES_A_FRAME} rows a frame" in TEXT


def test_the_example():
    example = bytes.fromhex(re.search(r"```\n([0-9a-f \n]+)```", TEXT)[1])
    assert f"with sequence 1, {len(example)} bytes" in TEXT
    assert f"The CRC is 0x{example[-1]:02X}{example[-2]:02X}." in TEXT
    ((kind, solution),) = LinkDecoder().feed(example)
    assert kind == frames.SOLUTION
    assert example[4] == 1
    assert solution == (
        61_000_000, (9 * 3600 + 27 * 60 + 25) * 1000, 16_140, 3, 0x0200, 50_502_057_500, -4_259_053_500,
        135.5, 10, -0.25, 0.125, 1.5, 0.0625, -0.03125, 0, 0.0078125, 0.25, 0.5, 0.5, 1, 0.0625, 0.0625,
        0.125, 0.0078125, 0.0078125, 0.015625,
    )  # fmt: skip
    writer = frames.FrameWriter()
    writer.text("")
    assert writer.pack(frames.SOLUTION, *solution) == example


def test_modes_and_flags():
    flat = " ".join(TEXT.split())
    assert f"Flags, from bit 0: {', '.join(FLAG_NAMES)} (`firmware.nav.flags`)" in flat
    assert f"Flags, from bit 0: {', '.join(NOTICE_NAMES)} (`firmware.nav.attitude.flags`)" in flat
    assert [name for name in msg.Sensor._fields if name in NOTICE_NAMES] == list(NOTICE_NAMES)
    assert msg.Sensor._fields[-8:] == tuple(f"saturated_{name}" for name in SATURATION_NAMES)
    assert ", ".join(f"{number} {name}" for number, name in enumerate(MODE_NAMES)) in flat


def test_can_table():
    database = cantools.database.load_file(ROOT / "boards" / "car_mems" / "car_mems.dbc")
    told: dict[int, list[int]] = {}
    identifier = 0
    for first, places, *_ in table("## CAN"):
        identifier = int(first, 16) if first else identifier
        told.setdefault(identifier, []).append(int(places.split("–")[0]))
    for message in database.messages:
        starts = {signal.start // 8 for signal in message.signals}
        assert set(told[message.frame_id]) <= starts
    assert set(told) == {message.frame_id for message in database.messages}
    mode = database.get_message_by_name("NAV_STATUS").get_signal_by_name("mode")
    modes = {value: str(name) for value, name in mode.choices.items()}
    assert modes == {number: name.replace(" ", "_") for number, name in enumerate(MODE_NAMES)}
