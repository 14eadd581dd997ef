"""What a person gets wrong: exit code 2, one message that names it, no traceback, nothing half-written."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from host.cli.main import app

PLACE = "\n[place]\nlatitude_deg = 30.0\nlongitude_deg = 114.0\n"


def _run(folder: Path, *arguments: str) -> tuple[int, str]:
    out = folder / "out"
    result = CliRunner().invoke(app, ["run", *arguments, "-q", "--no-capture", "--out", str(out)])
    text = result.stderr + str(result.exception or "")
    assert "Traceback" not in text
    assert not out.exists()
    return result.exit_code, text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("duration_s = = 3", ["not valid TOML", "line 1"]),
        ("speling = 3" + PLACE, ["unknown key speling = 3"]),
        ("duration_s = -10.0" + PLACE, ["duration_s = -10.0", "greater than 0", "for example"]),
        ("duration_s = nan" + PLACE, ["duration_s = NaN", "finite"]),
        ("duration_ms = 10.0" + PLACE, ["duration_ms", "seconds", "duration_s = 1200.0"]),
        ("duration_s = 10.0\n[expect]\nnosuch = 1" + PLACE, ["nosuch", "no figure named"]),
    ],
)
def test_scenario_file(tmp_path: Path, text: str, words: list[str]) -> None:
    file = tmp_path / "drive.toml"
    file.write_text(text)
    code, message = _run(tmp_path, "car_mems", "-s", str(file))
    assert code == 2
    for word in [*words, "drive.toml"]:
        assert word in message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nosuch"], ["no board 'nosuch'", "car_mems"]),
        (["car_mems", "-s", "nosuch"], ["--scenario nosuch", "town-open"]),
        (["car_mems", "-s", "./nosuch.toml"], ["no such file"]),
        (["car_mems", "-s", ""], ["no such scenario", "town-open"]),
        (["b" * 300], ["File name too long"]),
        (["car_mems", "-p", "nosuch"], ["--profile nosuch", "full-rate"]),
        (["car_mems", "--seed", "-3"], ["--seed -3", "--seed 1"]),
        (["car_mems", "--seed", str(2**32)], ["--seed 4294967296", "4294967295", "--seed 1"]),
        (["car_mems", "--seed", "abc"], ["--seed", "'abc' is not a whole number", "example 1"]),
        (["car_mems", "--set", "nonsense"], ["--set nonsense", "key=value"]),
        (["car_mems", "--set", "gnss.nosuch=3"], ["unknown key gnss.nosuch = 3"]),
        (["car_mems", "--set", "gnss.position_white_m=1e300"], ["position_white_m = 1e+300", "10000", "0.5"]),
        (["car_mems", "--set", "gnss.latency_s=nan"], ["latency_s = NaN", "finite", "0.08"]),
        (
            ["car_mems", "--set", "imu.gyro.bias_dps=[0,-1e9,0]"],
            ["bias_dps", "1000000000.0", "-2000 … 2000"],
        ),
        (["car_mems", "--set", "imu.gyro.turn_on_bias_dps=-1"], ["turn_on_bias_dps = -1", "not be negative"]),
        (["car_mems", "--set", "imu.accelerometer.instability_time_s=inf"], ["instability_time_s", "finite"]),
        (["car_mems", "--set", "start.utc=9999-12-31T23:59:59Z"], ["start.utc", "2099", "2024-05-14"]),
        (["car_mems", "--set", "segment.0.duration_s=-5"], ["segment[1].duration_s = -5"]),
        (["car_mems", "--set", "board.nosuch=3"], ["board.toml", "nosuch"]),
        (["car_mems", "--set", "board.uarts.host.baud=0"], ["uarts.host.baud = 0", "baud = 9600"]),
        (["car_mems", "--set", "board.uarts.host.baud=999999999999"], ["uarts.host.baud = 999", "50000000"]),
        (["car_mems", "--set", "board.buses.spi1.clock_hz=1"], ["clock_hz = 1", "1000", "5250000"]),
        (["car_mems", "--set", "board.can.can1.bitrate=1"], ["bitrate = 1", "5000", "500000"]),
        (["car_mems", "--set", "profile.nosuch=3"], ["'nosuch'", "aiding"]),
        (["car_mems", "--set", "profile.aiding=maybe"], ["aiding = 'maybe'", "True, False"]),
        (["car_mems", "--set", "board.processors.mcu.program=nosuch.module:x"], ["nosuch.module:x"]),
        (["car_mems", "--set", "board.processors.mcu.program=json:nosuch"], ["json:nosuch"]),
        (["car_mems", "--set", "board.chips.U2.model=nosuch:X"], ["nosuch:X", "U2"]),
        (["car_mems", "--set", "board.chips.U2.parameters.nosuch=1"], ["nosuch", "U2"]),
        (["car_mems", "--set", "board.chips.U2.name=foo"], ["a chip called 'imu'", "foo"]),
    ],
)
def test_command_line(tmp_path: Path, arguments: list[str], words: list[str]) -> None:
    code, message = _run(tmp_path, *arguments)
    assert code == 2
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ('kind="nosuch",target="imu",at_s=1.0', ["no kind of fault 'nosuch'", "spi-missing"]),
        (
            'kind="spi-mising",target="imu",at_s=1.0',
            ["did you mean 'spi-missing'?", "docs/scenarios.md"],
        ),
        ('kind="spi-missing",target="nosuch",at_s=1.0', ["no SPI device 'nosuch'", "imu"]),
        ('kind="gnss-time-jump",target="nosuch",at_s=1.0', ["no receiver 'nosuch'", "U3"]),
        (
            'kind="spi-missing",target="imu",at_s=1.0,parameters={nosuch=3}',
            ["parameters.nosuch = 3", "level"],
        ),
        ('kind="spi-bit-errors",target="imu",at_s=1.0,parameters={probability=7}', ["7", "0 … 1"]),
        (
            'kind="spi-bit-errors",target="imu",at_s=1.0,parameters={probability="x"}',
            ["parameters.probability = 'x'", "0.0001"],
        ),
        ('kind="gnss-time-jump",target="U3",at_s=1.0,parameters={offset_s="x"}', ["offset_s = 'x'", "50.0"]),
        ('kind="gnss-time-jump",target="U3",at_s=1.0', ["'gnss-time-jump U3'", "by how much", "offset_s"]),
        (
            'kind="gnss-position-jump",target="U3",at_s=1.0,parameters={north_m=0.0}',
            ["by how much", "down_m"],
        ),
        ('kind="chip-off",target="U2",at_s=-1.0', ["at_s = -1.0", "120.0"]),
        ('kind="chip-off",target="U2",at_s=600.0', ["at_s = 600", "end of the run at 600 s", "at_s = 300"]),
        (
            'kind="chip-off",target="U2",at_s=1.0,name="x"},{kind="uart-cut",target="gnss",at_s=1.0,name="x"',
            ["two faults are called 'x'"],
        ),
        ('kind="chip-off",target="U2",at_s=1.0,duration_s=0.0', ["duration_s = 0.0", "5.0"]),
    ],
)
def test_fault(tmp_path: Path, fault: str, words: list[str]) -> None:
    code, message = _run(tmp_path, "car_mems", "-s", "static", "--set", f"fault=[{{{fault}}}]")
    assert code == 2
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("board.processors.mcu.costs={}", ["processors.mcu.costs 'parse_byte'"]),
        (
            "board.processors.mcu.tasks={x={priority=1}}",
            ["processors.mcu.tasks 'gnss_receive'", "it names: x"],
        ),
        ("board.timers={}", ["timers 'background'"]),
    ],
)
def test_board_without_what_its_program_asks_for(tmp_path: Path, change: str, words: list[str]) -> None:
    code, message = _run(tmp_path, "car_mems", "-s", "static", "--set", change)
    assert code == 2
    for word in ["board.toml", *words]:
        assert word in message


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("board.pins={}", ["GNSS_ENABLE", "no output pin drives"]),
        ('board.logs={"../x"={processor="mcu"}}', ["[logs] '../x'", "letters"]),
        ('board.chips.U2.pins.INT9="X"', ["INT9", "INT1, INT2"]),
        ("board.buses.spi1.mode=1", ["buses.spi1.mode = 1", "0, 3"]),
        ("board.chips.U2.mounting=[[1,0,0],[0,1,0],[0,0,-1]]", ["reflection"]),
        ("board.buses.spi1.kind=i2c", ["buses.spi1.clock_hz", "400_000"]),
        ('profile.acquisition="timer"', ["acquisition", "two-sample"]),
        ("profile.initial_yaw_deg=400", ["initial_yaw_deg", "62.0"]),
    ],
)
def test_what_cannot_be_wired_or_set_is_refused_before_anything_is_written(
    tmp_path: Path, change: str, words: list[str]
) -> None:
    code, message = _run(tmp_path, "car_mems", "-s", "static", "--set", change)
    assert code == 2
    for word in words:
        assert word in message


def test_recording_that_is_missing_or_broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NAVTWIN_DATA", raising=False)
    code, message = _run(tmp_path, "car_mems", "-s", "real-drive")
    assert code == 2
    assert "NAVTWIN_DATA" in message
    data = tmp_path / "data"
    (data / "comma2k19").mkdir(parents=True)
    code, message = _run(tmp_path, "car_mems", "-s", "real-drive", "--data", str(data))
    assert code == 2
    assert "no such file below" in message
    (data / "comma2k19" / "example_1.npz").write_bytes(b"PK\x03\x04 not really")
    code, message = _run(tmp_path, "car_mems", "-s", "real-drive", "--data", str(data))
    assert code == 2
    assert "example_1.npz" in message


def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    result = CliRunner().invoke(app, ["run", "car_mems", "-s", "static", "-q", "--out", str(file)])
    assert result.exit_code == 2
    assert "is a file" in result.stderr


def test_a_figure_that_nobody_knows_is_told_in_a_short_message(tmp_path: Path) -> None:
    change = "expect={yaw_rms_deg='<= zzz'}"
    code, message = _run(tmp_path, "car_mems", "-s", "static", "--set", change)
    assert code == 2
    assert "no figure named 'zzz'; known, " in message
    assert len(message) < 700


def test_a_fault_that_never_fired_is_told(tmp_path: Path) -> None:
    fault = 'fault=[{kind="uart-garbage",target="host",at_s=9.0},{kind="uart-cut",target="host",at_s=9.0}]'
    arguments = ["run", "car_mems", "-s", "static", "-q", "--no-capture", "--set", "duration_s=10"]
    done = CliRunner().invoke(app, [*arguments, "--set", fault, "--out", str(tmp_path / "out")])
    assert "fault 'uart-cut host' never fired" in done.output
    assert "garbage host' never" not in done.output


def test_a_byte_order_mark_is_no_mistake(tmp_path: Path) -> None:
    file = tmp_path / "drive.toml"
    file.write_text("\ufeffduration_s = -10.0" + PLACE, encoding="utf-8")
    code, message = _run(tmp_path, "car_mems", "-s", str(file))
    assert code == 2
    assert "duration_s = -10.0" in message
