"""The image navigates by itself on the raw frames of a run; its solutions and its memory are the twin's."""

import pytest
from pil_tools import needs_processor

from boards.description import load_board
from firmware.link.raw_frames import INPUTS, RAW_EPOCH
from hal.live.serial_link import SerialLink
from host.pil.board_kernels import target_kernel
from host.pil.stand_alone import NO_LOOP, loop_source, stand_alone_of
from host.pil.stand_alone_run import run_stand_alone
from host.record.errors import UserError
from host.record.result import RunRequest

DRIVE = ("duration_s=35",)


def test_the_table_of_a_loop_holds_the_configured_state():
    board = load_board("car_mems")
    loop = stand_alone_of(board, board.profiles["thesis"])
    from firmware.numerics.dialect import registered_kernels

    kernels = [
        target_kernel(number, kernel)
        for number, kernel in enumerate(one for one in registered_kernels() if one.signature is not None)
    ]
    text = loop_source(loop, kernels)
    assert ".each_sample = 0," in text
    assert f".floats = {loop.floats.size}," in text
    assert f".told = {(INPUTS[RAW_EPOCH].size - 16) // 8}," in text
    words = sum(line.split("= {")[1].count("0x") for line in text.splitlines() if "uint32_t run_" in line)
    assert words >= (loop.floats.view("u4") != 0).sum() + (loop.integers.view("u4") != 0).sum()


def test_a_board_without_such_a_loop_is_one_message():
    board = load_board("uav_ahrs")
    assert stand_alone_of(board, board.profiles["float32"]) is None
    assert loop_source(None, []) == NO_LOOP
    with pytest.raises(UserError, match="no module stand_alone"):
        run_stand_alone(RunRequest("uav_ahrs"), "/dev/ttyS99", lambda _: None)


@pytest.mark.soak
@needs_processor
def test_solutions_and_memory_are_those_of_the_twin_though_bytes_are_lost(monkeypatch):
    """Every 40th piece of the line to the board misses a byte; the board asks for it again."""
    write, pieces, lost = SerialLink.write, [0], [0]

    def losing(self, data):
        pieces[0] += 1
        if pieces[0] % 40 or len(data) < 20:
            return write(self, data)
        lost[0] += 1
        write(self, data[:11] + data[12:])
        return len(data)

    monkeypatch.setattr(SerialLink, "write", losing)
    result = run_stand_alone(RunRequest("car_mems", "town-open", overrides=DRIVE), None, lambda _: None)
    assert lost[0] > 10
    assert result.inputs_repeated > lost[0]
    assert result.inputs_taken == result.inputs > 3000
    assert result.is_equal
    assert result.solutions_equal > 200
    assert result.copies_equal >= 1
