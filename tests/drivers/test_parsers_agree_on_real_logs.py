"""Real receivers' output: every sentence and frame gives the values that pynmeagps and pyubx2 find in it."""

import datetime
import io
import os
from pathlib import Path

import pynmeagps
import pytest
import pyubx2
from receiver_line import ReceiverLine, epochs_of

from firmware.drivers import gnss_epoch as ge
from firmware.drivers.receiver_stream import ReceiverStream

LOGS = {"neo-m8n.log": 293, "hemi.log": 753, "rst39.log": 152}
DAY_ZERO = datetime.date(1980, 1, 6)
READ_TYPES = ("GGA", "RMC", "GLL", "VTG", "GSA", "GSV", "HDT", "ZDA")

pytestmark = pytest.mark.recording


def log(name: str) -> bytes:
    folder = os.environ.get("NAVTWIN_DATA")
    if not folder:
        pytest.skip("NAVTWIN_DATA is not set: no real receiver logs")
    path = Path(folder) / "gnss" / name
    if not path.is_file():
        pytest.skip(f"no {name} in NAVTWIN_DATA")
    return path.read_bytes()


def sentences(data: bytes) -> list[bytes]:
    lines = [line.strip() + b"\r\n" for line in data.split(b"\n")]
    return [line for line in lines if line.startswith(b"$") and b"*" in line]


def milliseconds(time: datetime.time) -> int:
    return ((time.hour * 60 + time.minute) * 60 + time.second) * 1000 + time.microsecond // 1000


def compare(epoch: dict[str, int], told: pynmeagps.NMEAMessage) -> None:
    """`epoch` of one sentence against the oracle's reading of it."""
    fix = getattr(told, "quality", 1) != 0 and getattr(told, "posMode", "A") not in ("N", "E")
    scaled = {
        "lat_nanodeg": ("lat", 1e9),
        "lon_nanodeg": ("lon", 1e9),
        "height_msl_mm": ("alt", 1e3),
        "speed_mmps": ("spd", 1852 / 3.6),
        "course_e5deg": ("cog", 1e5),
        "satellites": ("numSV", 1),
        "hdop_centi": ("HDOP", 100),
        "vdop_centi": ("VDOP", 100),
        "pdop_centi": ("PDOP", 100),
        "fix_type": ("navMode", 1),
        "heading_e5deg": ("headingT", 1e5),
        "fix_quality": ("quality", 1),
    }
    for field, (attribute, unit) in scaled.items():
        value = getattr(told, attribute, "")
        if attribute in ("spd", "cog") and told.msgID == "VTG":
            value = getattr(told, {"spd": "sogn", "cog": "cogt"}[attribute])
        if value != "" and fix:
            assert epoch[field] == pytest.approx(value * unit, abs=0.51), (field, told)
        elif field in ("lat_nanodeg", "lon_nanodeg", "speed_mmps", "course_e5deg", "heading_e5deg"):
            assert epoch[field] == 0
    if isinstance(getattr(told, "time", ""), datetime.time):
        assert epoch["time_of_day_ms"] == milliseconds(told.time)
    if isinstance(getattr(told, "date", ""), datetime.date):
        assert epoch["date_days"] == (told.date - DAY_ZERO).days
    if told.msgID == "ZDA":
        assert epoch["date_days"] == (datetime.date(told.year, told.month, told.day) - DAY_ZERO).days
    if getattr(told, "alt", "") != "" and told.sep != "":
        assert epoch["height_mm"] == pytest.approx((told.alt + told.sep) * 1e3, abs=0.51)
    assert bool(epoch["flags"] & ge.HAS_POSITION) == (fix and getattr(told, "lat", "") != "")
    assert bool(epoch["flags"] & ge.HAS_HEADING) == (getattr(told, "headingT", "") != "")


@pytest.mark.parametrize("name", sorted(LOGS))
def test_every_sentence_parses_to_the_same_values(name):
    compared = 0
    for line in sorted(set(sentences(log(name)))):
        told = pynmeagps.NMEAReader.parse(line)
        if told.msgID in READ_TYPES and told.msgID != "GSV":
            (epoch,) = epochs_of(line)
            compare(epoch, told)
            compared += 1
    assert compared > 40


@pytest.mark.parametrize("name", sorted(LOGS))
def test_the_whole_log_is_heard(name):
    data = log(name)
    line = ReceiverLine()
    line.chunks([data[i : i + 200] for i in range(0, len(data), 200)])
    line.silence()
    heard = line.stream.statistics()
    assert heard.sentences == LOGS[name]
    assert (heard.bad_checksums, heard.malformed, heard.overlong) == (0, 0, 0)
    parsed = [pynmeagps.NMEAReader.parse(text) for text in sentences(data)]
    told = {time for s in parsed for key in ("time", "utctime") if (time := getattr(s, key, "")) != ""}
    assert {e["time_of_day_ms"] for e in line.epochs if e["flags"] & ge.HAS_TIME} == set(
        map(milliseconds, told)
    )


def test_satellites_in_view_are_those_of_the_log():
    data = log("neo-m8n.log")
    end = data.index(b"$GNRMC,171928")
    line = ReceiverLine()
    line.chunks([data[i : i + 200] for i in range(0, end, 200)])
    told: dict[tuple[str, int], tuple[object, ...]] = {}
    used: set[int] = set()
    for text in sentences(data[data.index(b"$GNRMC,171927") : end]):
        parsed = pynmeagps.NMEAReader.parse(text)
        if parsed.msgID == "GSV":
            system = {"GP": "GPS", "GL": "GLONASS"}[parsed.talker]
            for i in range(1, 5):
                number = getattr(parsed, f"svid_{i:02d}", "")
                if number != "":
                    row = (getattr(parsed, f"{key}_{i:02d}") for key in ("elv", "az", "cno"))
                    told[system, number] = tuple(None if value == "" else value for value in row)
        elif parsed.msgID == "GSA":
            used |= {getattr(parsed, f"svid_{i:02d}") for i in range(1, 13)} - {""}
    seen = line.stream.satellites()
    assert {(s.system, s.number): (s.elevation_deg, s.azimuth_deg, s.cn0_dbhz) for s in seen} == told
    assert {s.number for s in seen if s.used} == used & {number for _, number in told}


def test_every_nav_pvt_frame_gives_the_same_values():
    data = log("ublox-neo-m8n.log")
    line = ReceiverLine(ReceiverStream(baud=115200))
    line.chunks([data[i : i + 100] for i in range(0, len(data), 100)])
    line.silence()
    reader = pyubx2.UBXReader(io.BytesIO(data), protfilter=pyubx2.UBX_PROTOCOL, quitonerror=0)
    told = [message for _, message in reader if message.identity == "NAV-PVT"]
    assert len(told) == len(line.epochs) == 24
    for pvt, epoch in zip(told, line.epochs, strict=True):
        assert epoch["lat_nanodeg"] == round(pvt.lat * 1e7) * 100
        assert epoch["lon_nanodeg"] == round(pvt.lon * 1e7) * 100
        assert (epoch["height_mm"], epoch["height_msl_mm"]) == (pvt.height, pvt.hMSL)
        assert (epoch["vel_n_mmps"], epoch["vel_e_mmps"], epoch["vel_d_mmps"]) == (
            pvt.velN,
            pvt.velE,
            pvt.velD,
        )
        assert (epoch["h_acc_mm"], epoch["v_acc_mm"], epoch["s_acc_mmps"]) == (pvt.hAcc, pvt.vAcc, pvt.sAcc)
        assert (epoch["speed_mmps"], epoch["satellites"]) == (pvt.gSpeed, pvt.numSV)
        assert epoch["course_e5deg"] == round(pvt.headMot * 1e5)
        assert epoch["pdop_centi"] == round(pvt.pDOP * 100)
        assert (epoch["fix_type"], epoch["fix_quality"], epoch["leap_seconds"]) == (3, 2, 18)
        whole = ((pvt.hour * 60 + pvt.min) * 60 + pvt.second) * 1000
        assert epoch["time_of_day_ms"] == whole + round(pvt.nano / 1e6)
        assert epoch["date_days"] == (datetime.date(pvt.year, pvt.month, pvt.day) - DAY_ZERO).days
