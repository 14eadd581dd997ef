"""Raw frames on their way to a board that has no sensors: over a line that loses some, each is taken once."""

import random
import struct

import pytest
from typer.testing import CliRunner

from firmware.link.frames import FrameWriter
from firmware.link.raw_frames import INPUTS, RAW_CLOCK, RAW_IMU, RAW_START, RAW_WANTED
from host.attach.feeding import PATIENCE_S, WINDOW_BYTES, Feeding, inputs_in_order
from host.cli.main import app
from host.link.decoder import LinkDecoder

STEP_S = 0.01


def start():
    return RAW_START, INPUTS[RAW_START].pack(0, 1, 1, 4, 10, 3522, 517, 0, 0)


def sample(number):
    return RAW_IMU, INPUTS[RAW_IMU].pack(number, number * 10_000_000, bytes(15))


def some_inputs(count=400):
    return [start(), *(sample(number) for number in range(1, count))]


class Board:
    """What the image does with inputs (docs/link.md), over lines on which `keep` says what arrives."""

    def __init__(self, keep):
        self.keep, self.decoder, self.writer = keep, LinkDecoder(), FrameWriter()
        self.taken, self.expected, self.asked = [], None, False

    def hear(self, frames):
        said = []
        for line in filter(self.keep, frames):
            for kind, payload in self.decoder.feed_raw(line):
                said += self.take(kind, payload)
        return [one for one in said if self.keep(one)]

    def take(self, kind, payload):
        number = int.from_bytes(payload[:4], "little")
        if kind == RAW_START:
            self.expected, self.taken = 0, []
        if number == self.expected:
            self.taken.append((kind, payload))
            self.expected += 1
            self.asked = False
            return [(kind, payload)]
        late = self.expected is not None and number < self.expected
        if self.asked and not late:
            return []
        self.asked = not late
        return [(RAW_WANTED, struct.pack("<I", self.expected or 0))]


def fed(inputs, board, limit_s=400.0):
    feeding, now_s, most = Feeding(inputs), 0.0, 0
    while not feeding.is_done and now_s < limit_s:
        frames = feeding.due(now_s)
        most = max(most, sum(map(len, frames)))
        now_s += STEP_S
        for kind, payload in board.hear(frames):
            feeding.hear(kind, payload, now_s)
    return feeding, now_s, most


def test_without_losses_everything_goes_once_and_in_windows():
    board = Board(lambda _: True)
    feeding, now_s, most = fed(some_inputs(), board)
    assert feeding.is_done
    assert board.taken == some_inputs()
    assert feeding.repeated == 0
    assert most <= WINDOW_BYTES + 262
    assert now_s < 1.0


@pytest.mark.parametrize("seed", range(6))
def test_what_is_lost_on_either_way_is_sent_again(seed):
    chance = random.Random(seed)
    board = Board(lambda _: chance.random() > 0.05)
    feeding, _, _ = fed(some_inputs(), board)
    assert feeding.is_done
    assert board.taken == some_inputs()
    assert 0 < feeding.repeated < 4000


def test_a_board_that_is_reset_on_the_way_begins_again_at_the_start():
    board = Board(lambda _: True)
    feeding = Feeding(some_inputs(100))
    for step in range(60):
        if step == 2:
            board.__init__(lambda _: True)  # a reset: it knows nothing any more
        for kind, payload in board.hear(feeding.due(step * STEP_S + step * PATIENCE_S)):
            feeding.hear(kind, payload, step * STEP_S + step * PATIENCE_S)
    assert feeding.is_done
    assert board.taken == some_inputs(100)


def test_inputs_begin_with_the_first_start_and_end_where_one_is_missing():
    assert inputs_in_order([sample(4), start(), sample(1), (RAW_CLOCK, b"xx"), sample(2), sample(4)]) == [
        start(),
        sample(1),
        sample(2),
    ]
    assert inputs_in_order([sample(1)]) == []


def test_feeding_wants_a_recording_and_a_port(tmp_path, capfd):
    for feed, port in ((str(tmp_path / "no"), "/dev/ttyS99"), (str(tmp_path), str(tmp_path))):
        result = CliRunner().invoke(app, ["attach", "board", "--port", port, "--feed", feed])
        told = (capfd.readouterr().err + result.stderr).strip()
        assert result.exit_code == 2
        assert len(told.splitlines()) == 1
