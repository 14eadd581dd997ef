"""Receiver logs: real ones against what gpsd makes of them, and written ones with known content."""

import json
import random
import struct

import pytest
from imports import imported, kinds, navtwin, recording, refused, rows
from pynmeagps import NMEAMessage
from pyubx2 import GET, UBXMessage

from host.capture.blocks import UartChunk
from host.capture.reader import CaptureReader


def raw_bytes(capture):
    return b"".join(one.data for one in CaptureReader(capture) if isinstance(one, UartChunk))


def gpsd_positions(path):
    """(lat, lon) of gpsd's fixes."""
    lines = [json.loads(line) for line in path.read_text().splitlines() if line.startswith("{")]
    return {(one["lat"], one["lon"]) for one in lines if one["class"] == "TPV" and "lat" in one}


@pytest.mark.parametrize(("kind", "name"), [("nmea", "neo-m8n"), ("ubx", "ublox-neo-m8n"), ("nmea", "rst39")])
def test_real_logs_have_the_positions_that_gpsd_sees(tmp_path, kind, name):
    log = recording(f"gnss/{name}.log")
    _, capture = imported(tmp_path, kind, log)
    told = gpsd_positions(recording(f"gnss/{name}.log.chk"))
    here = [(row["latitude_deg"], row["longitude_deg"]) for row in rows(capture, "/gnss") if row["fix"]]
    assert len(here) > 10
    for latitude, longitude in told:
        assert any(abs(a - latitude) < 2e-8 and abs(b - longitude) < 2e-8 for a, b in here)
    assert raw_bytes(capture) == log.read_bytes()


def test_a_real_log_of_ubx_tells_velocity_accuracy_and_satellites(tmp_path):
    report, capture = imported(tmp_path, "ubx", recording("gnss/ublox-neo-m8n.log"))
    assert report["begins"] == "2017-07-19T08:50:00Z"
    first = rows(capture, "/gnss")[0]
    assert first["t_s"] == 0.8
    assert first["v_north_mps"] == -0.01
    assert first["h_acc_m"] == 1.132
    assert first["geoid_separation_m"] == -3.471
    assert len(rows(capture, "/satellites")) == 140
    assert kinds(report) == {("note", "bytes"): 2, ("cut off", ""): 1}


def test_angles_of_proprietary_sentences_are_kept(tmp_path):
    _, capture = imported(tmp_path, "nmea", recording("gnss/rst39.log"))
    first, second = rows(capture, "/attitude")[:2]
    assert (first["yaw_deg"], first["pitch_deg"], first["roll_deg"]) == (10.51, -0.79, 0.39)
    assert second["t_s"] - first["t_s"] == pytest.approx(0.04)


def pvt(k, *, fix=3, valid=1, tow0=187_200_000, lat=47.0, second=None):
    """NAV-PVT, k s behind 2024-02-06 03:59:42 UTC."""
    s = 42 + k if second is None else second
    return UBXMessage(
        *("NAV", "NAV-PVT", GET),
        iTOW=tow0 + 1000 * k,
        year=2024,
        month=2,
        day=6 if s < 72_060 else 7,
        hour=(3 + (59 * 60 + s) // 3600) % 24,
        min=(59 * 60 + s) // 60 % 60,
        second=s % 60,
        validDate=valid,
        validTime=valid,
        fixType=fix,
        gnssFixOk=int(fix == 3),
        lat=lat,
        lon=8.5 + 1e-5 * k,
        height=480_000,
        hMSL=432_500,
        hAcc=900,
        vAcc=1500,
        sAcc=60,
        velN=1000,
        velE=-2000,
        velD=300,
        numSV=11,
    ).serialize()


def sentence(talker, kind, **fields):
    return NMEAMessage(talker, kind, 0, **fields).serialize()


def test_a_written_log_of_ubx_with_sentences_in_between(tmp_path):
    sat = UBXMessage(
        *("NAV", "NAV-SAT", GET),
        iTOW=187_201_000,
        version=1,
        numSvs=2,
        gnssId_01=0,
        svId_01=7,
        cno_01=44,
        elev_01=60,
        azim_01=120,
        svUsed_01=1,
        gnssId_02=2,
        svId_02=3,
        cno_02=0,
        elev_02=-91,
        azim_02=0,
    ).serialize()
    rawx = UBXMessage(
        *("RXM", "RXM-RAWX", GET),
        rcvTow=187_201.002,
        week=2300,
        leapS=18,
        numMeas=1,
        prMes_01=21_000_000.25,
        cpMes_01=1.1e8,
        doMes_01=-512.5,
        gnssId_01=0,
        svId_01=7,
        sigId_01=0,
        cno_01=44,
    ).serialize()
    text = b"$GNGGA,035943.00,4700.0,N,00830.0,E,1,11,0.8,432.5,M,47.5,M,,*5F\r\n"
    log = pvt(0) + pvt(1) + sat + text + rawx + pvt(2, fix=0) + pvt(3)
    (tmp_path / "x.ubx").write_bytes(log)
    report, capture = imported(tmp_path, "ubx", tmp_path / "x.ubx")
    assert report["begins"] == "2024-02-06T03:59:42Z"
    epochs = rows(capture, "/gnss")
    assert [row["t_s"] for row in epochs] == [0.0, 1.0, 2.0, 3.0]
    assert [row["fix"] for row in epochs] == [1, 1, 0, 1]
    assert epochs[2]["latitude_deg"] is None
    one = epochs[1]
    assert (one["longitude_deg"], one["height_m"], one["v_east_mps"]) == (8.50001, 480.0, -2.0)
    assert (one["h_acc_m"], one["s_acc_mps"], one["satellites"]) == (0.9, 0.06, 11)
    first, other = rows(capture, "/satellites")
    assert first == {
        "t_s": 1.0,
        "system": 0,
        "number": 7,
        "elevation_deg": 60.0,
        "azimuth_deg": 120.0,
        "cn0_dbhz": 44.0,
        "used": 1,
    }
    assert other["elevation_deg"] is None
    (observation,) = rows(capture, "/observations")
    assert observation["pseudorange_m"] == 21_000_000.25
    assert observation["t_s"] == pytest.approx(1.002, abs=1e-6)
    assert raw_bytes(capture) == log


def test_a_log_of_raw_measurements_alone_keeps_its_bytes(tmp_path):
    measured = {
        "prMes_01": 2.1e7,
        "cpMes_01": 1.1e8,
        "doMes_01": -5.5,
        "gnssId_01": 6,
        "svId_01": 7,
        "cno_01": 40,
    }
    log = b"".join(
        UBXMessage(
            *("RXM", "RXM-RAWX", GET),
            rcvTow=187_200.0 + k,
            week=2300,
            leapS=18,
            numMeas=1,
            sigId_01=0,
            **measured,
        ).serialize()
        for k in range(7)
    )
    (tmp_path / "x.ubx").write_bytes(log)
    report, capture = imported(tmp_path, "ubx", tmp_path / "x.ubx")
    assert report["topics"] == {"/observations": 7, "/uart/gnss/rx": 7}
    assert report["begins"] == "2024-02-06T03:59:42Z"
    assert raw_bytes(capture) == log


def esf(tag, values):
    """ESF-MEAS with (type, raw value) pairs."""
    data = b"".join(struct.pack("<I", (value & 0xFFFFFF) | kind << 24) for kind, value in values)
    payload = struct.pack("<IHH", tag, len(values) << 11, 0) + data
    return UBXMessage("ESF", "ESF-MEAS", GET, payload=payload).serialize()


def test_inertial_samples_of_the_receiver_are_laid_on_its_clock(tmp_path):
    log = b""
    for k in range(30):
        for ms in range(0, 1000, 20):
            gyro = [(14, 4096 * 2), (13, -4096), (5, round(4096 * 0.5))]
            accel = [(16, 1024), (17, 0), (18, -round(9.8 * 1024))]
            log += esf(5_000_000 + 1000 * (k - 1) + ms + 50, [*gyro, *accel, (12, 2350)])
        log += pvt(k)
    (tmp_path / "x.ubx").write_bytes(log)
    report, capture = imported(tmp_path, "ubx", tmp_path / "x.ubx")
    samples = rows(capture, "/imu/esf")
    assert len(samples) == 1500
    assert samples[0]["rate_x_dps"] == 2.0
    assert samples[0]["rate_y_dps"] == -1.0
    assert samples[0]["force_z_mps2"] == pytest.approx(-9.8, abs=1e-3)
    assert samples[0]["temperature_degc"] == 23.5
    assert samples[50]["t_s"] - samples[0]["t_s"] == pytest.approx(1.0)
    # How long behind its epoch the solution came is not known: the last sample before it gets its time.
    assert samples[-1]["t_s"] == pytest.approx(rows(capture, "/gnss")[-1]["t_s"], abs=1e-6)
    assert any(one["kind"] == "note" and "1 ms" in one["text"] for one in report["findings"])
    assert any("physical replay" in use for use in report["uses"])


def test_damage_is_told_and_the_rest_is_read(tmp_path):
    good = [pvt(k) for k in range(20)]
    broken = bytearray(good[5])
    broken[30] ^= 1
    length = bytearray(good[9])
    length[5] = 0x20  # 8 KiB and more to come
    log = b"".join(good[:5]) + broken + b"".join(good[6:9]) + length + b"".join(good[10:]) + good[3][:40]
    (tmp_path / "x.ubx").write_bytes(log)
    report, capture = imported(tmp_path, "ubx", tmp_path / "x.ubx")
    assert len(rows(capture, "/gnss")) == 18
    found = kinds(report)
    assert found[("checksum error", "UBX")] >= 2
    assert found[("cut off", "")] == 1
    assert found[("gap", "/gnss")] == 2
    assert raw_bytes(capture) == log
    places = [e["place"] for f in report["findings"] if f["kind"] == "checksum error" for e in f["examples"]]
    assert places[0] == f"byte {5 * len(good[0])}"


def nmea_log(times, date="060224", talker="GN", with_date=True):
    """RMC (every fifth with a date when asked for) and GGA at UTC times of day in s."""
    lines = []
    for n, t in enumerate(times):
        hms = f"{int(t) // 3600 % 24:02d}{int(t) // 60 % 60:02d}{t % 60:05.2f}"
        day = date if t < 86_400 else f"{int(date[:2]) + 1:02d}{date[2:]}"
        bodies = [f"{talker}GGA,{hms},4700.6000,N,00830.3000,E,1,11,0.8,432.5,M,47.5,M,,"]
        if with_date and n % 5 == 2:
            bodies.append(f"{talker}RMC,{hms},A,4700.6000,N,00830.3000,E,19.438,90.0,{day},,,A")
        for body in bodies:
            total = 0
            for letter in body.encode():
                total ^= letter
            lines.append(f"${body}*{total:02X}\r\n")
    return "".join(lines).encode()


def test_sentences_go_on_behind_midnight(tmp_path):
    (tmp_path / "x.nmea").write_bytes(nmea_log([86_390.0 + k for k in range(20)]))
    report, capture = imported(tmp_path, "nmea", tmp_path / "x.nmea")
    epochs = rows(capture, "/gnss")
    assert [row["t_s"] for row in epochs] == [float(k) for k in range(20)]
    assert report["begins"] == "2024-02-06T23:59:50Z"
    assert epochs[0]["height_m"] == 480.0
    assert epochs[2]["v_east_mps"] == pytest.approx(10.0, abs=1e-3)
    assert kinds(report) == {}


def test_a_date_may_be_stated_and_a_rolled_over_week_set_right(tmp_path):
    (tmp_path / "none.nmea").write_bytes(nmea_log([100.0 + k for k in range(5)], with_date=False))
    assert "--date 2018-09-07" in refused(tmp_path, "nmea", tmp_path / "none.nmea")
    report, _ = imported(tmp_path, "nmea", tmp_path / "none.nmea", options=["--date", "2024-02-06"])
    assert report["begins"] == "2024-02-06T00:01:40Z"
    (tmp_path / "old.nmea").write_bytes(nmea_log([86_395.0 + k for k in range(12)], date="230604"))
    report, _ = imported(
        tmp_path, "nmea", tmp_path / "old.nmea", name="b.mcap", options=["--date", "2024-02-06"]
    )
    assert report["begins"] == "2024-02-06T23:59:55Z"
    assert report["duration_s"] == 11.0
    assert "is not a date" in refused(tmp_path, "nmea", tmp_path / "old.nmea", options=["--date", "6.2.2024"])


def test_time_faults_of_a_log_are_told(tmp_path):
    times = [100.0 + k for k in range(40)]
    times[10:12] = [105.0, 106.0]  # goes back
    times[20] = times[19]
    del times[30:33]
    lines = nmea_log(times, with_date=False)
    (tmp_path / "x.nmea").write_bytes(nmea_log([99.0, 99.2, 99.4]) + lines)
    report, capture = imported(tmp_path, "nmea", tmp_path / "x.nmea")
    found = kinds(report)
    assert found[("time goes back", "/gnss")] == 2
    assert found[("gap", "/gnss")] >= 2
    steps = [row["t_s"] for row in rows(capture, "/gnss")]
    assert steps == sorted(set(steps))


def test_wrong_kinds_and_files_are_told(tmp_path):
    (tmp_path / "x.nmea").write_bytes(nmea_log([1.0, 2.0, 3.0]))
    assert "no UBX frame in it; there are others: navtwin import nmea" in refused(
        tmp_path, "ubx", tmp_path / "x.nmea"
    )
    (tmp_path / "noise").write_bytes(random.Random(1).randbytes(5000))
    assert "no NMEA sentence" in refused(tmp_path, "nmea", tmp_path / "noise")
    assert "cannot be read: No such file" in refused(tmp_path, "nmea", tmp_path / "gone")
    assert "did you mean 'nmea'?" in refused(tmp_path, "nmae", tmp_path / "x.nmea")
    assert "takes one file, not 2" in refused(tmp_path, "nmea", tmp_path / "x.nmea", tmp_path / "noise")
    assert "may be stated of: nothing" in refused(
        tmp_path, "nmea", tmp_path / "x.nmea", options=["--unit", "gyro=deg/s"]
    )
    (tmp_path / "there.mcap").write_text("mine")
    outcome = navtwin("import", "nmea", tmp_path / "x.nmea", "-o", tmp_path / "there.mcap")
    assert outcome.exit_code == 2
    assert (tmp_path / "there.mcap").read_text() == "mine"


def test_what_can_be_done_without_inertial_samples_is_said(tmp_path):
    (tmp_path / "x.nmea").write_bytes(nmea_log([1.0 + k for k in range(20)]))
    report, capture = imported(tmp_path, "nmea", tmp_path / "x.nmea")
    assert "no physical replay: there are no inertial samples in it" in report["uses"]
    outcome = navtwin("replay", capture, "--board", "car_mems", "--mode", "physical")
    assert outcome.exit_code == 2
    assert "it holds no inertial samples" in outcome.stderr
    outcome = navtwin("capture", "export", capture, "-f", "nmea", "-o", tmp_path / "again.nmea")
    assert outcome.exit_code == 0
    assert (tmp_path / "again.nmea").read_bytes() == (tmp_path / "x.nmea").read_bytes()
