"""Strict replay: what was captured repeats to the bit, faults and all; whatever does not is shown."""

import json

import pytest
from replay_captures import FAULTS, captured, in_older_format, tampered
from typer.testing import CliRunner

from boards.places import board_folder
from host.capture.blocks import LinePiece, SpiTransaction, UartChunk
from host.capture.cutting import cut
from host.capture.reader import CaptureReader
from host.cli.main import app
from host.record.errors import UserError
from host.replay.request import ReplayRequest
from host.replay.run_difference import compare_runs
from host.replay.strict import replay_strict


def navtwin(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def unchanged(_message, _number, _time_ns, record):
    return record


@pytest.mark.parametrize("profile", ["full-rate", "thesis"])
def test_a_run_with_every_kind_of_fault_replays_to_its_state_hash(profile):
    capture, run = captured(profile, "duration_s=100", FAULTS)
    assert all(fault.fired for fault in run.faults)
    replayed = replay_strict(ReplayRequest(capture))
    assert replayed.difference is None
    assert replayed.state_hash == run.state_hash == replayed.recorded_state_hash
    assert replayed.ok
    assert replayed.duration_s == 100.0
    read = sum(isinstance(record, SpiTransaction) for record in CaptureReader(capture))
    assert replayed.transactions == read > 9000


def test_what_the_run_changed_of_board_scenario_and_profile_is_in_its_capture():
    changes = (
        "duration_s=12",
        "board.pins.timepulse.wired=false",
        "profile.aiding=false",
        "gnss.latency_s=0.2",
    )
    capture, run = captured("full-rate", *changes, seed=5)
    assert replay_strict(ReplayRequest(capture)).state_hash == run.state_hash


def test_the_command_prints_the_hash_and_writes_json(tmp_path):
    capture, run = captured("full-rate", "duration_s=12")
    outcome = navtwin("replay", capture.parent, "--json", tmp_path / "x.json")
    assert outcome.exit_code == 0, outcome.output
    assert run.state_hash in outcome.output
    document = json.loads((tmp_path / "x.json").read_text())
    assert document["mode"] == "strict"
    assert document["ok"] is True
    assert document["state_hash"] == run.state_hash
    assert document["difference"] is None


def test_another_profile_differs_at_the_first_transaction_that_it_does_otherwise():
    capture, _ = captured("full-rate", "duration_s=12")
    outcome = navtwin("replay", capture, "--profile", "thesis")
    assert outcome.exit_code == 1
    assert "first difference at 0.102041517 s on /spi/spi1.imu" in outcome.output
    assert "MOSI 53 0a" in outcome.output  # the data-ready pin is switched on
    assert "MOSI 53 00" in outcome.output
    assert "does not repeat" in outcome.output


def test_a_changed_transaction_is_shown_with_both_sides(tmp_path):
    capture, _ = captured("full-rate", "duration_s=12")
    sent = [record for record in CaptureReader(capture) if isinstance(record, SpiTransaction)]

    def change(message, number, _time_ns, record):
        wrong = message.topic == "/spi/spi1.imu" and number == 700
        return record[:16] + b"\x99" + record[17:] if wrong else record

    result = replay_strict(ReplayRequest(tampered(capture, tmp_path / "x.mcap", change)))
    difference = result.difference
    assert not result.ok
    assert result.state_hash is None
    assert (difference.time_ns, difference.wire) == (sent[700].start_ns, "/spi/spi1.imu")
    assert "MOSI 99" in difference.recorded
    assert f"MOSI {sent[700].mosi[:1].hex()}" in difference.replayed


def test_a_changed_output_is_shown_with_the_byte(tmp_path):
    capture, _ = captured("full-rate", "duration_s=12")
    chunks = [
        record for record in CaptureReader(capture) if isinstance(record, UartChunk) and record.port == "host"
    ]

    def change(message, number, _time_ns, record):
        wrong = message.topic == "/uart/host/tx" and number == 100
        return record[:-1] + bytes([record[-1] ^ 0xFF]) if wrong else record

    difference = replay_strict(ReplayRequest(tampered(capture, tmp_path / "x.mcap", change))).difference
    assert (difference.time_ns, difference.wire) == (chunks[100].end_ns, "/uart/host/tx")
    assert chunks[100].data[-8:].hex(" ") in difference.replayed
    assert chunks[100].data[-8:].hex(" ") not in difference.recorded


def test_a_sample_that_was_measured_otherwise_shows_in_the_output(tmp_path):
    """The answers really come from the capture: one acceleration more, and the solution is another one."""
    capture, _ = captured("full-rate", "duration_s=12")

    def change(message, number, _time_ns, record):
        wrong = message.topic == "/spi/spi1.imu" and number == 900 and len(record) == 48
        return record[:-5] + bytes([record[-5] ^ 0x10]) + record[-4:] if wrong else record

    result = replay_strict(ReplayRequest(tampered(capture, tmp_path / "x.mcap", change)))
    assert result.difference is not None
    assert result.difference.wire != "/spi/spi1.imu"


def test_firmware_that_reads_more_than_was_recorded(tmp_path):
    capture, _ = captured("full-rate", "duration_s=12")

    def change(message, number, _time_ns, record):
        return b"" if message.topic == "/spi/spi1.imu" and number >= 800 else record

    difference = replay_strict(ReplayRequest(tampered(capture, tmp_path / "x.mcap", change))).difference
    assert difference.recorded == "nothing more"
    assert difference.wire == "/spi/spi1.imu"


def test_firmware_that_reads_less_than_was_recorded(tmp_path):
    capture, _ = captured("full-rate", "duration_s=12")
    last = [record for record in CaptureReader(capture) if isinstance(record, SpiTransaction)][-1]

    def change(message, _number, _time_ns, record):
        is_last = message.topic == "/spi/spi1.imu" and record[:8] == last.start_ns.to_bytes(8, "little")
        later = (last.start_ns + 10).to_bytes(8, "little") + record[8:]
        return record + later if is_last else record

    difference = replay_strict(ReplayRequest(tampered(capture, tmp_path / "x.mcap", change))).difference
    assert difference.replayed == "nothing"
    assert difference.time_ns == last.start_ns + 10


def test_what_is_left_of_a_capture_that_was_cut_off_replays(tmp_path):
    capture, _ = captured("full-rate", "duration_s=12")
    whole = capture.read_bytes()
    reached = []
    for share in (0.2, 0.35, 0.5):
        path = tmp_path / "run.mcap.part"
        path.write_bytes(whole[: int(share * len(whole))])
        result = replay_strict(ReplayRequest(path))
        assert result.ok
        assert not result.capture_complete
        assert result.recorded_state_hash is None
        reached.append(result.duration_s)
    assert 0.0 < reached[0] < reached[1] < reached[2] < 12.0


def test_a_stretch_from_the_beginning_replays_another_one_does_not(tmp_path):
    capture, _ = captured("full-rate", "duration_s=12")
    cut(CaptureReader(capture), tmp_path / "begin.mcap", 0.0, 7.0)
    assert replay_strict(ReplayRequest(tmp_path / "begin.mcap")).ok
    cut(CaptureReader(capture), tmp_path / "middle.mcap", 3.0, 7.0)
    outcome = navtwin("replay", tmp_path / "middle.mcap")
    assert outcome.exit_code == 2
    assert "begins at 3 s" in outcome.output


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a capture of navtwin"),
        (b"PK\x03\x04 something else entirely", "not a capture of navtwin"),
        (b"\x89MCAP0\r\n", "not a capture of navtwin"),
    ],
)
def test_a_foreign_file_is_told_in_one_line(tmp_path, content, message):
    (tmp_path / "x.mcap").write_bytes(content)
    outcome = navtwin("replay", tmp_path / "x.mcap")
    assert outcome.exit_code == 2
    assert message in outcome.output
    assert "Traceback" not in outcome.output


def test_a_capture_of_an_older_format_is_told(tmp_path):
    capture, _ = captured("full-rate", "duration_s=12")
    old = tampered(capture, tmp_path / "x.mcap", unchanged, form="navtwin-capture-1")
    with pytest.raises(
        UserError, match=r"its format is navtwin-capture-1; a strict replay needs navtwin-capture-4"
    ):
        replay_strict(ReplayRequest(old))


@pytest.mark.parametrize("number", [2, 3])
def test_captures_of_formats_2_and_3_replay_as_before(number, tmp_path):
    capture, result = captured("full-rate", "duration_s=12")
    old = in_older_format(capture, tmp_path / "x.mcap", number)
    replayed = replay_strict(ReplayRequest(old))
    assert replayed.ok
    assert replayed.state_hash == result.state_hash
    chunks = [one for one in CaptureReader(old) if isinstance(one, UartChunk)]
    assert {one.baud for one in chunks} == {None}
    assert compare_runs(capture, old).same


def test_what_a_board_sent_tells_its_rate(tmp_path):
    """9600 baud to the receiver until it is configured, then the faster rate of the board's driver."""
    capture, _ = captured("full-rate", "duration_s=12")
    board = [one for one in CaptureReader(capture) if isinstance(one, UartChunk)]
    assert {one.baud for one in board if one.port == "host"} == {230_400}
    rates = [one.baud for one in board if one.port == "gnss"]
    told = [one.baud for one in CaptureReader(capture) if isinstance(one, LinePiece) and one.port == "gnss"]
    assert rates[0] == 9600
    assert rates[-1] == told[-1] > 9600


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "car_mems"', 'name = "car_other"', "it is of the board 'car_mems', not 'car_other'"),
        ("IMU_INT1", "IMU_DRDY", "only the board has /pin/IMU_DRDY"),
        ("can.can1", "can.can2", "only the board has /can/can2"),
    ],
)
def test_a_capture_of_another_board_is_told(tmp_path, old, new, message):
    capture, _ = captured("full-rate", "duration_s=12")
    text = (board_folder("car_mems") / "board.toml").read_text()
    assert old in text
    (tmp_path / "board.toml").write_text(text.replace(old, new))
    outcome = navtwin("replay", capture, "--board", tmp_path)
    assert outcome.exit_code == 2, outcome.output
    assert message in " ".join(outcome.output.split())


def test_a_profile_that_does_not_exist_is_told():
    capture, _ = captured("full-rate", "duration_s=12")
    outcome = navtwin("replay", capture, "-p", "full-rte")
    assert outcome.exit_code == 2
    assert "did you mean 'full-rate'?" in outcome.output
