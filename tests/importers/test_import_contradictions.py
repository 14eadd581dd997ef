"""What contradicts itself between files, options and the length that a file should have."""

from functools import reduce
from operator import xor

import can
import numpy as np
import pytest
from circle_drive import write_kf_gins
from imports import imported, kinds, navtwin, refused, rows


def sentence(text):
    return f"${text}*{reduce(xor, text.encode()):02X}\r\n".encode()


def rmc(clock, date="311216"):
    return sentence(f"GNRMC,{clock},A,4800.00000,N,01100.00000,E,10.0,45.0,{date},,,A")


def test_clocks_that_differ_between_files_are_told(tmp_path):
    imu, gnss, truth = write_kf_gins(tmp_path)
    table = np.loadtxt(gnss)
    table[:, 0] += 3600.0
    np.savetxt(gnss, table, fmt="%.9f")
    report, capture = imported(tmp_path, "kf-gins", imu, gnss, truth)
    assert kinds(report) == {("no time in common", "/gnss"): 1}
    assert not any("navtwin replay" in use for use in report["uses"])
    outcome = navtwin("replay", capture, "--board", "car_mems", "--mode", "physical", "-q")
    assert outcome.exit_code == 2
    assert "no receiver epoch with a fix" in outcome.stderr
    outcome = navtwin("diff", capture, capture)
    assert outcome.exit_code == 2
    assert "nothing in them can be compared" in outcome.stderr


def test_increments_in_degrees_contradict_the_course_of_the_reference(tmp_path):
    """Receiver epochs without velocity tell no course."""
    imu, gnss, truth = write_kf_gins(tmp_path)
    assert np.loadtxt(gnss).shape[1] == 7
    table = np.loadtxt(imu)
    table[:, 1:4] = np.degrees(table[:, 1:4])
    np.savetxt(imu, table, fmt="%.12f")
    bends = np.loadtxt(truth)
    assert np.ptp(bends[:, 10]) > 20.0
    assert "it looks like deg/s" in refused(tmp_path, "kf-gins", f"imu={imu}", gnss, truth)


@pytest.mark.parametrize(
    ("kind", "option", "known"),
    [
        ("nmea", ("--week", "2300"), "only to kf-gins"),
        ("broad", ("--leap-seconds", "18"), "only to ubx, nmea"),
        ("kf-gins", ("--date", "2020-01-01"), "only to nmea, ubx"),
        ("can", ("--accuracy", "1,1,1"), "only to"),
    ],
)
def test_an_option_of_another_kind_is_refused(tmp_path, kind, option, known):
    (tmp_path / "x.log").write_bytes(rmc("120000.00"))
    assert known in refused(tmp_path, kind, tmp_path / "x.log", options=option)


def test_a_file_that_the_mapping_does_not_use_is_told(tmp_path):
    for name in ("imu.csv", "left_over.csv"):
        (tmp_path / name).write_text("t,x,y,z\n0,0,0,9.8\n")
    mapping = tmp_path / "map.toml"
    mapping.write_text(
        'skip_lines = 0\n[time]\ncolumn = "t"\n[imu]\nfile = "imu.csv"\n'
        'gyro = { columns = ["x", "x", "x"], unit = "deg/s" }\n'
        'accel = { columns = ["x", "y", "z"], unit = "m/s2" }\n'
    )
    files = (tmp_path / "imu.csv", tmp_path / "left_over.csv")
    assert "left_over.csv is used by no section" in refused(
        tmp_path, "csv", *files, options=["--map", mapping]
    )
    mapping.write_text(mapping.read_text().replace("skip_lines = 0", "skip_lines = 1000000000"))
    said = refused(tmp_path, "csv", files[0], options=["--map", mapping])
    assert "skip_lines = 1000000000, but it has only 2 lines" in said
    files[0].write_bytes(b"")
    mapping.write_text(mapping.read_text().replace("skip_lines = 1000000000", "skip_lines = 0"))
    assert "it is empty" in refused(tmp_path, "csv", files[0], options=["--map", mapping])


def test_the_second_before_a_leap_second_keeps_its_name(tmp_path):
    (tmp_path / "x.nmea").write_bytes(b"".join(rmc(f"2359{s:02d}.00") for s in range(50, 60)))
    report, _ = imported(tmp_path, "nmea", tmp_path / "x.nmea")
    assert report["begins"] == "2016-12-31T23:59:50Z"


def test_a_blf_log_that_is_too_short_for_its_header_is_told(tmp_path):
    path = tmp_path / "x.blf"
    with can.Logger(path) as logger:
        for k in range(500):
            logger.on_message_received(can.Message(timestamp=1.7e9 + k, arbitration_id=k, data=b"\1\2"))
    whole = path.read_bytes()
    report, _ = imported(tmp_path, "can", path)
    assert report["findings"] == []
    path.write_bytes(whole[: len(whole) * 2 // 3])
    report, _ = imported(tmp_path, "can", path, name="cut.mcap")
    assert 0 < sum(report["topics"].values()) < 500
    assert kinds(report) == {("cut off", ""): 1}
    assert f"{len(whole):,} bytes" in report["findings"][0]["examples"][0]["value"]


def test_a_candump_log_may_begin_with_a_byte_order_mark(tmp_path):
    lines = "".join(f"(1700000000.{k:06d}) can0 123#{k:02X}\n" for k in range(20))
    (tmp_path / "x.log").write_text(lines, encoding="utf-8-sig")
    report, _ = imported(tmp_path, "can", tmp_path / "x.log")
    assert report["topics"] == {"/can/can0": 20}
    assert report["findings"] == []


def test_bytes_of_nothing_are_counted_and_one_wrong_time_does_not_carry_the_others_away(tmp_path):
    log = [rmc(f"1000{s:02d}.00") for s in range(40)]
    log[10] = b"\x00\x01garbage!" + rmc("170000.00")
    (tmp_path / "x.nmea").write_bytes(b"".join(log))
    report, capture = imported(tmp_path, "nmea", tmp_path / "x.nmea")
    assert kinds(report)[("note", "bytes")] == 10
    assert report["duration_s"] == 39.0
    export = tmp_path / "again.nmea"
    assert navtwin("capture", "export", capture, "--format", "nmea", "-o", export).exit_code == 0
    assert export.read_bytes() == b"".join(log).replace(b"\x00\x01garbage!", b"")
    assert [row["t_s"] for row in rows(capture, "/gnss")][9:12] == [9.0, 11.0, 12.0]


def test_figures_that_could_not_be_written_are_told_before_the_import(tmp_path):
    (tmp_path / "x.nmea").write_bytes(rmc("120000.00"))
    figures = tmp_path / "nowhere" / "found.json"
    said = refused(tmp_path, "nmea", tmp_path / "x.nmea", options=["--json", figures])
    assert f"--json {figures}: the folder {figures.parent} does not exist" in said
