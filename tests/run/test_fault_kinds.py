"""Every kind of fault at every place of a board with every chip: it strikes, nothing raises into firmware."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import pytest

from boards.description import load_board
from host.campaign.fault_plan import AT_ONCE, PARAMETERS, TARGETS, strikes
from host.record.command_line import toml
from host.record.errors import UserError
from host.record.result import RunRequest, RunResult
from host.run.fault_kinds import KINDS
from host.run.runner import check, run

BOARD = str(Path(__file__).with_name("every_chip"))
BEGIN_S = 5.0
WINDOW_S, SERIAL_WINDOW_S = 0.5, 1.2
"""A receiver at 1 Hz speaks once in the longer one."""
OFTEN = {"probability": 0.05}


def faults() -> list[dict[str, object]]:
    """All strikes, those on one bus or line one after the other."""
    board = load_board(BOARD)
    free: dict[str, float] = defaultdict(lambda: BEGIN_S)
    listed = []
    wires = {
        name: str(chip.bus or chip.uart) for ref, chip in board.chips.items() for name in (ref, chip.name)
    }
    for strike in strikes(board, 0.0, 1.0):
        if strike.kind not in KINDS or strike.kind in ("cpu-reset", "nav-nan", "log-removed"):
            continue
        line = wires.get(strike.target, strike.target)
        serial = line in board.uarts
        one: dict[str, object] = {"kind": strike.kind, "target": strike.target, "at_s": free[line]}
        if strike.kind not in AT_ONCE:
            one["duration_s"] = SERIAL_WINDOW_S if serial else WINDOW_S
        parameters = dict(PARAMETERS.get(strike.kind, ()))
        if "errors" in strike.kind or "byte" in strike.kind or "overrun" in strike.kind:
            parameters = OFTEN
        if parameters:
            one["parameters"] = {**parameters, **({"length": 200} if strike.kind == "uart-garbage" else {})}
        free[line] += (SERIAL_WINDOW_S if serial else WINDOW_S) + 0.1
        listed.append(one)
    return listed


@pytest.fixture(scope="module")
def struck() -> RunResult:
    wanted = faults()
    end_s = max(float(str(one["at_s"])) for one in wanted) + 3.0
    return run(RunRequest(BOARD, None, None, 1, (f"duration_s={end_s}", f"fault={toml(wanted)}")))


def test_every_fault_strikes(struck: RunResult) -> None:
    silent = [fault.name for fault in struck.faults if not fault.fired]
    assert silent == []
    assert len(struck.faults) > 70
    assert {fault.kind for fault in struck.faults} == set(KINDS) - {
        "cpu-reset", "nav-nan", "log-removed", "can-disturbance",
        "packet-loss", "packet-bit-errors", "packet-word-slip",  # between two processors: tests/gfsins
        "spi-swapped",  # two chips of one part: tests/gfsins
    }  # fmt: skip


def test_the_program_reads_every_chip_to_the_end(struck: RunResult) -> None:
    said = [event.text for event in struck.events if event.source == "board" and "acc=" in event.text]
    counts = [dict(pair.split("=") for pair in text.split()) for text in said[-2:]]
    for chip in ("acc", "adis", "compass", "imu", "dual"):
        assert int(counts[1][chip]) > int(counts[0][chip]), chip


def test_every_kind_has_its_targets() -> None:
    assert set(KINDS) <= set(TARGETS)


def one(kind: str, target: str, **more: object) -> str:
    return f"fault={toml([{'kind': kind, 'target': target, 'at_s': 1.0, **more}])}"


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (one("i2c-nack", "imu"), "no I2C device 'imu'"),
        (one("i2c-stuck", "i2c9"), "no I2C bus 'i2c9'; did you mean 'i2c1'"),
        (one("i2c-stuck", "i2c1", parameters={"line": "mosi"}), "'sda' or 'scl'"),
        (one("i2c-nack", "compass", parameters={"byte": -3}), "refusal from byte -3"),
        (one("i2c-clock-stretch", "compass", parameters={"hold_ms": 0.0}), "clock held for 0.0 ms"),
        (one("spi-word-slip", "adis", parameters={"bits": 0}), "word slip of 0 bits"),
        (one("uart-cut", "imu", parameters={"line": "cts"}), "it is 'rx'"),
        (one("uart-byte-loss", "imu", parameters={"probability": 2.0}), "0 … 1"),
        (one("pin-stuck", "NOWHERE"), "no net 'NOWHERE'"),
        (one("sensor-stuck", "U5"), "U5 is no sensor"),
        (one("sensor-stuck", "U3", parameters={"quantity": "gyro"}), "U3 measures mag, accel, temperature"),
        (one("sensor-drift", "U1", parameters={"axis": "w"}), "axis 'w'"),
        (one("chip-wrong-id", "U5"), "a GR-87 cannot have this fault"),
        (one("chip-wrong-id", "U1", parameters={"id": -1}), "parameters.id = -1"),
        (one("chip-clock", "U1", parameters={"ppm": 1e6}), "parameters.ppm"),
        (one("chip-halt", "U1"), "a ADXL345 cannot have this fault"),
        (one("chip-supply", "U2", parameters={"volts": 12.0}), "supply_v = 12.0"),
        (one("chip-flags", "U2", parameters={"flags": 0}), "parameters.flags = 0"),
        (one("i2c-nack", "compass", parameters={"bite": 1}), "parameters.bite = 1 is unknown"),
    ],
)
def test_what_cannot_be_is_one_message(fault: str, words: str) -> None:
    with pytest.raises(UserError) as told:
        check(RunRequest(BOARD, None, None, 1, (fault,)))
    assert words in str(told.value)
