"""Campaigns, sweeps and fault sheets of a board of one's own: no receiver, an attitude only."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from campaign_rig import navtwin

from host.campaign.quantities import quantity
from host.new_board.writing import write_board
from host.record.errors import UserError


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the skeleton's board."""
    folder = tmp_path_factory.mktemp("own")
    write_board("sweep_unit", folder)
    return folder / "sweep_unit"


def test_sweep_of_a_receiver_that_is_not_there_is_one_message(board: Path, tmp_path: Path) -> None:
    result = navtwin("sweep", board, "-k", "gnss-latency", "--seeds", "1", "--out", tmp_path / "s", "-q")
    assert result.exit_code == 2
    assert "has no GNSS receiver" in result.stderr
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "s").exists()


def test_sample_clock_error_of_the_skeleton_can_be_swept(board: Path) -> None:
    found = quantity(str(board), "sample-clock-error")
    assert found is not None
    assert found.key == "board.chips.U2.parameters.clock_error_ppm"
    with pytest.raises(UserError, match="no chip U9"):
        quantity(str(board), "sample-clock-error:U9")


def test_figures_of_an_attitude_unit_are_in_its_reports(board: Path, tmp_path: Path) -> None:
    result = navtwin(
        *("campaign", board, "--set", "duration_s=90", "--set", "expect={cpu.mcu.load=0.9}"),
        *("--set", "gnss.latency_s=0.1,0.2", "--seeds", "1", "-j", 1, "--out", tmp_path / "c"),
    )
    assert "roll, °" in result.output, result.output
    page = (tmp_path / "c" / "report.html").read_text()
    assert page.count("cpu.mcu.load") >= 4, "expectations, side by side, differences, spread"
    assert '"roll, \\u00b0"' in page or '"roll, °"' in page


SPEAKING = """
from firmware.link.frames import FrameWriter


def program(io, profile, installation):
    return Speaking(io)


class Speaking:
    def __init__(self, io):
        self.io = io

    def main(self):
        io, link = self.io, FrameWriter()
        while True:
            io.cpu.delay(100_000_000)
            asked = bytearray(2)
            asked[0] = 0x80
            io.spi["imu"].transaction(asked)
            if asked[1] != 0xD1:
                io.uart["host"].write(link.text("sensor lost"))

    def spoil(self):
        pass

    def memory(self):
        return b""
"""


def test_a_board_that_sends_words_only_tells_of_a_fault_in_time(tmp_path: Path) -> None:
    write_board("word_unit", tmp_path)
    board = tmp_path / "word_unit"
    (board / "program.py").write_text(SPEAKING)
    result = navtwin(
        *("faults", board, "--only", "chip-off", "--at", "3.05", "--for", "2", "--set", "duration_s=20"),
        *("--set", "expect={}", "-j", 1, "--out", tmp_path / "sheet"),
    )
    assert result.exit_code in (0, 1), result.output
    with (tmp_path / "sheet" / "faults.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert all(row.values()), "no cell is empty, though the board has no CAN and no solution"
    assert row["said"] == "sensor lost"
    assert float(row["detected_after_s"]) < 0.12, "the board looks ten times a second"
    assert 2.0 <= float(row["recovered_after_s"]) < 2.12, row
