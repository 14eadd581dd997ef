"""Scenarios with an operator: what they may say and what they leave in the folder."""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from boards.places import board_folder
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.runner import run
from host.run.screen_text import text_lines
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import load_scenario

STATIC = board_folder("gfsins") / "scenarios" / "static.toml"


def pixels(file: Path) -> np.ndarray:
    """Of a grey PNG without filters, checked chunk by chunk."""
    data = file.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, place = {}, 8
    while place < len(data):
        length, kind = struct.unpack_from(">I4s", data, place)
        body = data[place + 8 : place + 8 + length]
        assert struct.unpack_from(">I", data, place + 8 + length)[0] == zlib.crc32(kind + body)
        chunks[kind] = body
        place += 12 + length
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    width, height, bits, colour, *_ = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert (bits, colour) == (8, 0)
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, width + 1)
    assert not rows[:, 0].any()
    return rows[:, 1:]


def test_the_scenario_leaves_its_screens(tmp_path: Path) -> None:
    """Its first eight seconds; a second run in the same folder leaves no screen of the first."""
    folder = tmp_path / "out"
    short = ("duration_s=8.0", 'segment=[{kind="rest",duration_s=8.0}]', "expect={}")
    result = run(RunRequest("gfsins", "settings", overrides=short, out_dir=folder, capture=False))
    files = sorted(folder.glob("screen-*.png"))
    titles = [text_lines((pixels(file)[::4, ::4] // 17).astype(np.uint8))[0].split("  ")[0] for file in files]
    assert titles[0] == "gfsins settings mode"
    pages = ("STATUS", "Scale, offset", "Accelerometer A2")
    assert list(dict.fromkeys(title for title in titles if title in pages)) == list(pages)
    report = (folder / "report.html").read_text()
    assert report.count('<img alt="display"') == len(files) == len(result.data.screens)  # type: ignore[union-attr]
    still = ("duration_s=1.0", 'segment=[{kind="rest",duration_s=1.0}]', "expect={}")
    run(RunRequest("gfsins", "static", overrides=still, out_dir=folder, capture=False))
    assert not list(folder.glob("screen-*.png"))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ('panel.keys=[[-1, "OK"]]', "entry 1, [-1, 'OK']: the time must be a number of seconds in 0 … 1e+07"),
        ('panel.keys=[["a", "OK"]]', "the time must be a number of seconds"),
        ('panel.keys=[[nan, "OK"]]', "the time must be a number of seconds"),
        ('panel.keys=[[true, "OK"]]', "the time must be a number of seconds"),
        ('panel.keys=[[1.0, "OK", 0]]', "it must be held for a number of seconds in 0.001"),
        ("panel.keys=[[1.0]]", "must be [second, key] or [second, key, held for s]"),
        ("panel.keys=[[1.0, 5]]", "the key must be a text"),
        ("panel.keys=7", "must be a list of"),
        ('panel.keys=[[2.0, "OK"], [1.0, "OK", 2.0]]', "goes down at 2 s while it is held from 1 to 3 s"),
        ("panel.mode=3", 'must be a valid string; for example mode = "settings"'),
        ("panel.keyes=[]", "did you mean 'keys'?"),
    ],
)
def test_what_no_operator_can_do_is_told(change: str, told: str) -> None:
    with pytest.raises(ScenarioError, match=re.escape(told)):
        load_scenario(STATIC, [change])


@pytest.mark.parametrize(
    ("board", "change", "told"),
    [
        ("gfsins", "panel.mode=setings", "the switch has no such position; did you mean 'settings'?"),
        ("gfsins", 'panel.keys=[[1.0, "OKAY"]]', "entry 1: there is no key 'OKAY'"),
        ("car_mems", "panel.mode=settings", "board car_mems has no mode switch"),
        ("car_mems", 'panel.keys=[[1.0, "OK"]]', "board car_mems has no keys"),
        ("gfsins", 'board.chips.U10.world="imu"', 'a SSD1325 feels "none"'),
        ("gfsins", 'board.chips.U8.world="none"', 'a HMC6343 feels "compass"'),
        ("gfsins", 'board.chips.S2.parameters.position="up"', "there is no position 'up'"),
        ("gfsins", "board.chips.S2.parameters.positions={ a = [0, 2] }", "each needs as many levels 0 or 1"),
        ("gfsins", 'board.chips.S1.pins.ESC="KEY_ESC"', "a keypad has the pins UP, DOWN"),
        ("gfsins", 'fault=[{kind="chip-off", target="S1", at_s=1.0}]', "a keypad cannot have this fault"),
        ("gfsins", 'fault=[{kind="sensor-frozen", target="U10", at_s=1.0}]', "is no sensor"),
    ],
)
def test_what_the_board_does_not_have_is_told(board: str, change: str, told: str) -> None:
    with pytest.raises(UserError, match=re.escape(told)):
        run(RunRequest(board, "static", overrides=("duration_s=5", change), capture=False))
