"""FPGA and DSP while they solve: whatever is lost, the result is that of a quiet line, or a word."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware.apps.gfsins.positions import COUNTS, NAMES
from firmware.apps.gfsins.settings_packet import (
    POSITION_VALUES,
    Answer,
    Request,
    Result,
    What,
    open_answer,
    open_request,
    pack_answer,
    pack_request,
)
from firmware.apps.gfsins.solver import Solver
from firmware.apps.gfsins.solver_dialogue import SolverDialogue
from firmware.nav.gyro_free.config import GyroFreeConfig
from hal.board_io import BoardIo
from hal.errors import BusError, ErrorKind

MS = 1_000_000
DEVIATION = (0.02, -0.08, 0.05, 0.03, -0.015)


class Line:
    """Both processors and what lies between; `spoil` says what becomes of each message."""

    def __init__(self, spoil: Callable[[bytes], bytes | None]) -> None:
        self.spoil = spoil
        self.now_ns = 0
        self.dialogue = SolverDialogue(cast(Any, SimpleNamespace(send=self.send)))
        self.says: list[str] = []
        self.restart()

    def restart(self) -> None:
        cpu = SimpleNamespace(spend=lambda cycles: None, cost=lambda work: 1)
        bus = SimpleNamespace(transaction=self.transaction)
        io = cast(BoardIo, SimpleNamespace(cpu=cpu, command_buses={"commands": bus}))
        self.solver = Solver(io, GyroFreeConfig(), self.says.append)

    def send(self, data: bytes) -> bool:
        arrived = self.spoil(data)
        if arrived is not None:
            self.solver.on_packet(arrived)
        return True

    def transaction(self, address: int, write: bytes, read: int = 0) -> bytes:
        arrived = self.spoil(write)
        if arrived is None:
            raise BusError(ErrorKind.ADDRESS_NACK, "nobody there")
        self.dialogue.on_answer(arrived)
        return b""

    def run(self, seconds: float, event: Callable[[int], None] | None = None) -> None:
        for step in range(round(20 * seconds)):
            self.now_ns += 50 * MS
            if event is not None:
                event(step)
            self.dialogue.service(self.now_ns)
            self.solver.look()
            if self.dialogue.result is not None or self.dialogue.failure:
                return


def headings(seed: int) -> list[list[int]]:
    """24 positions as the FPGA collects them."""
    rng = np.random.default_rng(seed)
    a, b, c, d, e = DEVIATION
    rows = []
    for k in range(24):
        true = math.radians(15.0 * k)
        shown = true
        for _ in range(50):
            s, o = math.sin(shown), math.cos(shown)
            shown = true + a + b * s + c * o + d * 2.0 * s * o + e * (o * o - s * s)
        tenths = math.degrees(shown) * 10.0 + rng.normal(0.0, 1.0)
        rows.append([round(tenths * 65536), *[0] * (POSITION_VALUES - 1)])
    return rows


def solved(spoil: Callable[[bytes], bytes | None], event: Callable[[Line, int], None] | None = None) -> Line:
    line = Line(spoil)
    line.dialogue.begin(NAMES.index("compass"), (0, 0, 0), headings(1), 10)
    line.run(120.0, None if event is None else lambda step: event(line, step))
    return line


@pytest.fixture(scope="module")
def quiet() -> tuple[float, ...]:
    result = solved(lambda data: data).dialogue.result
    assert result is not None
    return result


def test_a_quiet_line_gives_the_deviation_that_was_there(quiet: tuple[float, ...]) -> None:
    assert np.all(np.abs(np.subtract(quiet[:5], DEVIATION)) < 4.0 * np.array(quiet[5:]))


@pytest.mark.parametrize("share", [0.1, 0.15])
def test_lost_and_spoilt_messages_cost_time_only(quiet: tuple[float, ...], share: float) -> None:
    rng = np.random.default_rng(3)

    def spoil(data: bytes) -> bytes | None:
        if rng.random() < share:
            return None
        if rng.random() < share:
            wrong = bytearray(data)
            wrong[rng.integers(0, len(wrong))] ^= 1 << rng.integers(0, 8)
            return bytes(wrong)
        return data

    line = solved(spoil)
    assert line.dialogue.result == quiet
    assert line.dialogue.repeated > 3


@pytest.mark.parametrize("step", [3, 30, 54])
def test_a_dsp_that_begins_anew_is_told_all_again(quiet: tuple[float, ...], step: int) -> None:
    def event(line: Line, now: int) -> None:
        if now == step:
            line.restart()

    assert solved(lambda data: data, event).dialogue.result == quiet


def test_a_dsp_that_stays_away_is_told_and_solving_can_be_tried_again(quiet: tuple[float, ...]) -> None:
    away = [True]
    line = solved(lambda data: None if away[0] else data)
    assert line.dialogue.failure == "DSP does not answer"
    assert line.now_ns < 5_000 * MS
    away[0] = False
    line.dialogue.begin(NAMES.index("compass"), (0, 0, 0), headings(1), 10)
    line.run(60.0)
    assert line.dialogue.result == quiet


def test_positions_that_do_not_tell_are_told() -> None:
    line = Line(lambda data: data)
    alike = [headings(1)[0]] * COUNTS["compass"]
    line.dialogue.begin(NAMES.index("compass"), (0, 0, 0), alike, 10)
    line.run(60.0)
    assert line.dialogue.failure == "positions too alike"
    assert "not solved" in line.says[-1]


values = st.lists(st.integers(-(1 << 31) + 1, (1 << 31) - 1), max_size=20).map(tuple)


@given(st.integers(0, 0xFFFF), st.sampled_from(What), st.integers(0, 9), st.integers(0, 99), values)
def test_requests_come_back_and_a_wrong_bit_is_none(
    number: int, what: What, procedure: int, index: int, told: tuple[int, ...]
) -> None:
    request = Request(number, what, procedure, index, told)
    data = pack_request(request)
    assert len(data) == 96
    assert open_request(data) == request
    wrong = bytearray(data)
    wrong[number % 96] ^= 1 << number % 8
    assert open_request(bytes(wrong)) is None


@given(
    st.integers(0, 0xFFFF),
    st.sampled_from(Result),
    st.lists(st.floats(width=32, allow_nan=False), max_size=12).map(tuple),
)
def test_answers_come_back_and_a_wrong_bit_is_none(
    number: int, result: Result, told: tuple[float, ...]
) -> None:
    answer = Answer(number, result, told)
    data = pack_answer(answer)
    assert open_answer(data) == answer
    wrong = bytearray(data)
    wrong[number % len(wrong)] ^= 1 << number % 8
    assert open_answer(bytes(wrong)) is None
    assert open_answer(data[:-1]) is None
    assert open_answer(b"") is None
