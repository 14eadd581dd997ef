"""navtwin capture: what is told, cut and exported agrees with what other readers find."""

import errno
import json
import os

import can
import numpy as np
import pynmeagps
import pytest
from pyarrow import parquet
from replay_captures import captured
from typer.testing import CliRunner
from vcd.reader import TokenKind, tokenize

from host.capture.blocks import CanMessage, PinEdge, SpiTransaction
from host.capture.overview import look_over
from host.capture.reader import CaptureReader, Decoded
from host.cli.main import app
from host.record.errors import UserError
from host.replay.request import ReplayRequest
from host.replay.strict import replay_strict

SECOND = 1_000_000_000


def navtwin(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def capture():
    return captured("thesis", "duration_s=12")[0]


def test_info_tells_what_was_captured(capture, tmp_path):
    outcome = navtwin("capture", "info", capture.parent, "--json", "-")
    assert outcome.exit_code == 0
    told = json.loads(outcome.output)
    assert (told["board"], told["profile"], told["duration_s"]) == ("car_mems", "thesis", 12.0)
    assert told["complete"] is True
    records = list(CaptureReader(capture))
    topics = {topic["topic"]: topic for topic in told["topics"]}
    spi = [record for record in records if isinstance(record, SpiTransaction)]
    assert topics["/spi/spi1.imu"]["records"] == len(spi)
    assert topics["/spi/spi1.imu"]["last_s"] == pytest.approx(spi[-1].start_ns / 1e9)
    assert navtwin("capture", "info", capture).output.count("/spi/spi1.imu") == 1


def test_check_finds_nothing_in_a_whole_capture(capture):
    outcome = navtwin("capture", "check", capture)
    assert outcome.exit_code == 0
    assert "whole, 12.000 s recorded" in outcome.output


def test_check_says_what_is_missing(capture, tmp_path):
    whole = capture.read_bytes()
    (tmp_path / "run.mcap.part").write_bytes(whole[: len(whole) * 6 // 10])
    outcome = navtwin("capture", "check", tmp_path)
    assert outcome.exit_code == 1
    assert "cut off or damaged behind byte" in outcome.output
    assert "the run did not reach its end" in outcome.output


def test_damage_is_never_more_than_a_message(capture, tmp_path):
    whole = capture.read_bytes()
    path = tmp_path / "x.mcap"
    noticed = 0
    random = np.random.default_rng(7)
    for place in random.integers(8, len(whole), 60).tolist():
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(random.integers(8))
        path.write_bytes(damaged)
        try:
            noticed += bool(look_over(CaptureReader(path)).findings)
        except UserError:
            noticed += 1
    assert noticed > 20  # the rest lies in the index, which nobody needs


def test_a_cut_holds_exactly_what_lies_in_it(capture, tmp_path):
    outcome = navtwin("capture", "cut", capture, "--from", 4, "--to", 9.5, "-o", tmp_path / "c.mcap")
    assert outcome.exit_code == 0, outcome.output

    def inside(records):
        return [r for r in records if isinstance(r, SpiTransaction) and 4e9 <= r.start_ns < 9.5e9]

    reader = CaptureReader(tmp_path / "c.mcap")
    kept = list(reader)
    assert (
        inside(kept) == [r for r in kept if isinstance(r, SpiTransaction)] == inside(CaptureReader(capture))
    )
    assert reader.manifest["cut"] == {"from_s": 4.0, "to_s": 9.5}
    assert reader.complete
    assert look_over(CaptureReader(tmp_path / "c.mcap")).findings == []


@pytest.mark.parametrize(("begin", "end"), [(5, 5), (-1, 3), (40, 50)])
def test_a_cut_that_makes_no_sense_is_told(capture, tmp_path, begin, end):
    outcome = navtwin("capture", "cut", capture, f"--from={begin}", "--to", end, "-o", tmp_path / "c.mcap")
    assert outcome.exit_code == 2
    assert not (tmp_path / "c.mcap").exists()


def test_a_cut_without_an_end_goes_to_the_end(capture, tmp_path):
    for end in ("inf", "1e300"):
        outcome = navtwin(
            "capture", "cut", capture, "--from", 11, "--to", end, "-o", tmp_path / f"{end}.mcap"
        )
        assert outcome.exit_code == 0, outcome.output
    assert (tmp_path / "inf.mcap").read_bytes() == (tmp_path / "1e300.mcap").read_bytes()


def test_figures_of_a_replay_do_not_take_the_place_of_its_capture(capture):
    before = capture.read_bytes()
    outcome = navtwin("replay", capture, "--json", capture)
    assert outcome.exit_code == 2
    assert "is the file that is read" in outcome.output
    assert capture.read_bytes() == before


def test_messages_are_valid_json_with_and_without_fix_height_or_truth():
    records = [r for r in CaptureReader(captured("thesis", "duration_s=100")[0]) if isinstance(r, Decoded)]
    assert {record.topic for record in records} >= {"/fix/gnss", "/fix/solution", "/imu/U2", "/solution"}


def test_csv_and_parquet_hold_every_row(capture, tmp_path):
    for kind in ("csv", "parquet"):
        outcome = navtwin("capture", "export", capture, "-f", kind, "-o", tmp_path / kind)
        assert outcome.exit_code == 0, outcome.output
    spi = [record for record in CaptureReader(capture) if isinstance(record, SpiTransaction)]
    table = parquet.read_table(tmp_path / "parquet" / "spi-spi1.imu.parquet").to_pydict()
    assert table["miso"] == [record.miso.hex() for record in spi]
    lines = (tmp_path / "csv" / "spi-spi1.imu.csv").read_text().splitlines()
    assert lines[0] == "t_s,duration_s,mosi,miso"
    assert len(lines) == len(spi) + 1
    fixes = parquet.read_table(tmp_path / "parquet" / "fix-gnss.parquet").to_pydict()
    assert fixes["position_covariance_8"] == [0.0] * len(fixes["latitude"])
    assert fixes["timestamp_sec"] == sorted(fixes["timestamp_sec"])
    solution = parquet.read_table(tmp_path / "parquet" / "solution.parquet")
    assert solution.column("t_s").to_pylist()[-1] == pytest.approx(11.8, abs=0.3)


def test_nmea_is_what_another_parser_reads(capture, tmp_path):
    navtwin("capture", "export", capture, "-f", "nmea", "-o", tmp_path / "x.nmea")
    with (tmp_path / "x.nmea").open("rb") as file:
        read = [message for _raw, message in pynmeagps.NMEAReader(file, quitonerror=pynmeagps.ERR_RAISE)]
    assert len(read) == len((tmp_path / "x.nmea").read_bytes().splitlines())
    assert sum(message.msgID == "RMC" for message in read) in (9, 10, 11)


def test_candump_is_what_python_can_reads(capture, tmp_path):
    navtwin("capture", "export", capture, "-f", "candump", "-o", tmp_path / "x.log")
    frames = [record for record in CaptureReader(capture) if isinstance(record, CanMessage)]
    read = list(can.CanutilsLogReader(tmp_path / "x.log"))
    assert [(m.arbitration_id, bytes(m.data)) for m in read] == [(f.identifier, f.data) for f in frames]
    assert [m.timestamp for m in read] == pytest.approx([f.end_ns / 1e9 for f in frames], abs=2e-6)


def test_vcd_is_what_another_parser_reads(tmp_path):
    capture = captured("full-rate", "duration_s=12")[0]
    navtwin("capture", "export", capture, "-f", "vcd", "-o", tmp_path / "x.vcd")
    with (tmp_path / "x.vcd").open("rb") as file:
        tokens = list(tokenize(file))
    names = {token.var.reference: token.var.id_code for token in tokens if token.kind is TokenKind.VAR}
    edges = [r for r in CaptureReader(capture) if isinstance(r, PinEdge) and r.net == "IMU_INT1"]
    changes = [t for t in tokens if t.kind is TokenKind.CHANGE_SCALAR]
    ours = [t.scalar_change.value for t in changes if t.scalar_change.id_code == names["IMU_INT1"]]
    assert ours[1:] == [str(int(edge.level)) for edge in edges]  # the first one is the initial level


def test_an_unknown_format_or_a_place_that_is_taken_is_told(capture, tmp_path):
    outcome = navtwin("capture", "export", capture, "-f", "candunp", "-o", tmp_path / "x")
    assert outcome.exit_code == 2
    assert "did you mean 'candump'?" in outcome.output
    (tmp_path / "x").write_text("mine")
    assert navtwin("capture", "export", capture, "-f", "vcd", "-o", tmp_path / "x").exit_code == 2
    assert (tmp_path / "x").read_text() == "mine"


def test_a_folder_without_a_capture_is_told(tmp_path):
    outcome = navtwin("capture", "info", tmp_path)
    assert outcome.exit_code == 2
    assert "holds no run.mcap" in outcome.output


@pytest.mark.parametrize(
    "command",
    [("cut", "--from", 1, "--to", 11), ("export", "--format", "csv"), ("export", "--format", "candump")],
    ids=["cut", "csv", "candump"],
)
@pytest.mark.parametrize("what", ["full disk", "Ctrl-C"])
def test_what_could_not_be_written_whole_is_not_there(capture, tmp_path, monkeypatch, command, what):
    name, *options = command
    read = CaptureReader._records
    total = sum(1 for _ in CaptureReader(capture).messages())

    def stops(self, file):
        for number, record in enumerate(read(self, file)):
            if number > total // 2:
                if what == "Ctrl-C":
                    raise KeyboardInterrupt
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            yield record

    monkeypatch.setattr(CaptureReader, "_records", stops)
    outcome = navtwin("capture", name, capture, *options, "-o", tmp_path / "made")
    assert list(tmp_path.iterdir()) == []
    assert outcome.output.count("\n") == 1
    if what == "Ctrl-C":
        assert (outcome.exit_code, outcome.output) == (130, "navtwin: interrupted; nothing was written\n")
    else:
        assert outcome.exit_code == 2
        assert f"-o {tmp_path / 'made'}: cannot be written: No space left on device" in outcome.output


def test_a_capture_that_was_cut_off_is_cut_to_its_own_name(capture, tmp_path):
    part, whole = tmp_path / "run.mcap.part", tmp_path / "run.mcap"
    part.write_bytes(capture.read_bytes()[:-2000])
    before = part.read_bytes()
    assert navtwin("capture", "cut", part, "--from", 0, "--to", 5, "-o", whole).exit_code == 0
    assert part.read_bytes() == before
    assert CaptureReader(whole).recorded_s() == pytest.approx(5.0)
    assert sorted(tmp_path.iterdir()) == [whole, part]


def test_an_export_may_go_into_an_empty_folder(capture, tmp_path):
    folder = tmp_path / "tables"
    folder.mkdir()
    assert navtwin("capture", "export", capture, "-f", "csv", "-o", folder, "--topic", "/gnss").exit_code == 0
    assert [path.name for path in tmp_path.rglob("*")] == ["tables", "gnss.csv"]


def test_long_frames_are_exported_as_can_fd(tmp_path):
    with can.Logger(tmp_path / "fd.blf") as logger:
        for k in range(3):
            data = bytes(range(64)) if k else b"\1"
            logger(can.Message(timestamp=1.7e9 + k, arbitration_id=5, is_fd=bool(k), data=data))
    capture, log = tmp_path / "fd.mcap", tmp_path / "fd.log"
    assert navtwin("import", "can", tmp_path / "fd.blf", "-o", capture, "-q").exit_code == 0
    assert navtwin("capture", "export", capture, "-f", "candump", "-o", log).exit_code == 0
    with can.LogReader(log) as reader:
        assert [(one.is_fd, bytes(one.data)) for one in reader] == [
            (False, b"\1"),
            *2 * [(True, bytes(range(64)))],
        ]


def test_a_capture_that_lost_its_last_records_does_not_say_that_the_run_ended(capture, tmp_path):
    """Nor does its replay differ from what is there."""
    data, damaged = capture.read_bytes(), tmp_path / "cut.mcap"
    whole = sum(1 for _ in CaptureReader(capture))
    ended = set()
    for lost in range(1, len(data) // 3, 501):
        damaged.write_bytes(data[:-lost])
        reader = CaptureReader(damaged)
        count = sum(1 for _ in reader)
        assert reader.summary is None or count == whole
        ended.add(reader.summary is None)
    assert ended == {True, False}
    result = replay_strict(ReplayRequest(damaged))
    assert result.difference is None
    assert not result.capture_complete
