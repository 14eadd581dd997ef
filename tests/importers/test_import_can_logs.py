"""CAN logs that python-can writes, in all its formats; signals by a DBC; damaged lines."""

from itertools import pairwise

import can
import cantools
import pytest
from imports import imported, kinds, navtwin, refused, rows

from host.capture.blocks import CanMessage
from host.capture.reader import CaptureReader

START = 1_707_192_000.0
"""2024-02-06 04:00:00 UTC."""


def frames(count=40, start=START):
    return [
        can.Message(
            timestamp=round(start + 0.01 * k, 6),
            arbitration_id=0x18FF0000 + k if k % 3 else 0x100 + k,
            is_extended_id=bool(k % 3),
            data=bytes(range(k % 9)),
            channel=k % 2,
        )
        for k in range(count)
    ]


def written(path, messages):
    with can.Logger(path) as logger:
        for message in messages:
            logger.on_message_received(message)
    return path


@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf", ".trc", ".csv"])
def test_frames_of_every_format_come_back(tmp_path, suffix):
    sent = frames()
    if suffix == ".trc":
        sent = [one for one in sent if one.channel == 0]
    if suffix == ".csv":
        for one in sent:
            one.channel = None
    log = written(tmp_path / f"x{suffix}", sent)
    report, capture = imported(tmp_path, "can", log)
    found = [one for one in CaptureReader(capture) if isinstance(one, CanMessage)]
    found.sort(key=lambda one: one.end_ns)
    assert [(one.identifier, one.extended, one.data) for one in found] == [
        (one.arbitration_id, one.is_extended_id, bytes(one.data)) for one in sent
    ]
    steps = [b.end_ns - a.end_ns for a, b in pairwise(found)]
    wanted = [round((b.timestamp - a.timestamp) * 1e9) for a, b in pairwise(sent)]
    assert steps == pytest.approx(wanted, abs=2_000_000 if suffix == ".trc" else 20_000)
    if suffix in (".log", ".csv"):
        assert report["begins"] == "2024-02-06T04:00:00Z"
    assert report["findings"] == []


def test_a_capture_gives_the_log_back(tmp_path):
    log = written(tmp_path / "x.log", frames())
    _, capture = imported(tmp_path, "can", log)
    navtwin("capture", "export", capture, "-f", "candump", "-o", tmp_path / "again.log")
    with can.LogReader(tmp_path / "again.log") as reader:
        again = sorted(reader, key=lambda one: one.timestamp)
    assert [bytes(one.data) for one in again] == [bytes(one.data) for one in frames()]


DATABASE = """VERSION ""
NS_ :
BS_:
BU_: ecu
BO_ 256 Motion: 8 ecu
 SG_ Speed : 0|16@1+ (0.01,0) [0|300] "km/h" ecu
 SG_ YawRate : 16|16@1- (0.005,0) [-100|100] "deg/s" ecu
"""


def test_signals_are_decoded_by_a_database(tmp_path):
    (tmp_path / "x.dbc").write_text(DATABASE)
    database = cantools.database.load_file(tmp_path / "x.dbc")
    sent = []
    for k in range(20):
        data = database.encode_message(
            "Motion", {"Speed": 10.0 + k, "YawRate": -2.5 if k else 150.0}, strict=False
        )
        sent.append(can.Message(timestamp=START + k, arbitration_id=256, is_extended_id=False, data=data))
    sent.append(can.Message(timestamp=START + 20, arbitration_id=256, is_extended_id=False, data=b"\x01"))
    sent.append(
        can.Message(timestamp=START + 21, arbitration_id=256, is_extended_id=False, is_remote_frame=True)
    )
    log = written(tmp_path / "x.log", sent)
    report, capture = imported(tmp_path, "can", log, options=["--dbc", tmp_path / "x.dbc"])
    signals = rows(capture, "/signals/Motion")
    assert signals[3] == {"t_s": 3.0, "Speed_km_h": 13.0, "YawRate_deg_s": -2.5}
    found = kinds(report)
    assert found[("implausible value", "Motion.YawRate")] == 1
    assert found[("note", "remote frames")] == 1
    (tmp_path / "bad.dbc").write_text("BO_ what")
    assert "cannot be read as a CAN database" in refused(
        tmp_path, "can", log, options=["--dbc", tmp_path / "bad.dbc"]
    )


def test_lines_that_cannot_be_read_are_told_by_number(tmp_path):
    lines = written(tmp_path / "x.log", frames()).read_text().splitlines()
    lines[7] = lines[7][:20]
    lines[9] = "(not a number) can0 123#00"
    lines[30] = lines[30].replace("#", "?")
    (tmp_path / "y.log").write_text("\n".join(lines) + "\n")
    report, capture = imported(tmp_path, "can", tmp_path / "y.log")
    (finding,) = report["findings"]
    assert (finding["kind"], finding["count"]) == ("unreadable", 3)
    assert [one["place"] for one in finding["examples"]] == ["line 8", "line 10", "line 31"]
    assert sum(isinstance(one, CanMessage) for one in CaptureReader(capture)) == 37


def test_frames_that_cannot_be_are_left_out(tmp_path):
    log = written(tmp_path / "x.csv", [can.Message(timestamp=START + k, arbitration_id=5) for k in range(9)])
    lines = log.read_text().splitlines()
    lines[3] = lines[3].replace("0x5", "0x123456789AB")
    log.write_text("\n".join(lines) + "\n")
    report, capture = imported(tmp_path, "can", log)
    assert kinds(report) == {("implausible value", "frame"): 1}
    assert sum(isinstance(one, CanMessage) for one in CaptureReader(capture)) == 8


def test_other_files_are_refused(tmp_path):
    (tmp_path / "x.txt").write_text("hello")
    assert "the name does not tell the format" in refused(tmp_path, "can", tmp_path / "x.txt")
    for suffix in (".log", ".asc", ".blf", ".trc", ".csv", ".mf4", ".db"):
        (tmp_path / f"y{suffix}").write_bytes(b"hello, world\n" * 30)
        assert "no CAN frame in it" in refused(tmp_path, "can", tmp_path / f"y{suffix}")
