"""Attitude sentences of two-antenna receivers: by hand, by pynmeagps, and two real logs against gpsd."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pynmeagps
import pytest
from hypothesis import given
from hypothesis import strategies as st
from receiver_line import ReceiverLine, epoch_of, sentence

from firmware.drivers import gnss_epoch as ge

ATTITUDE = ge.HAS_HEADING | ge.HAS_PITCH | ge.HAS_ROLL
PASHR = "PASHR,092725.000,123.45,T,-1.23,+0.56,+0.00,0.020,0.030,0.100,1,4"
KNOT = 1852 / 3600


def angles(epoch: dict[str, int]) -> tuple[int, int, int]:
    return epoch["heading_e5deg"], epoch["pitch_e5deg"], epoch["roll_e5deg"]


def test_pashr() -> None:
    sample = PASHR.replace("0.030", "0.020")
    assert sentence(sample).endswith(b"*30\r\n"), "as the fact sheet has it"
    epoch = epoch_of(PASHR)
    assert angles(epoch) == (12_345_000, 56_000, -123_000)
    sigmas = [epoch[f"{name}_sigma_e5deg"] for name in ("roll", "pitch", "heading")]
    assert sigmas == [2_000, 3_000, 10_000]
    assert epoch["flags"] == ge.HAS_TIME | ATTITUDE | ge.HAS_ATTITUDE_ACCURACY
    assert epoch["time_of_day_ms"] == ((9 * 60 + 27) * 60 + 25) * 1000


@pytest.mark.parametrize(
    "body",
    [
        "PASHR,092725.000,123.45,T,-1.23,+0.56,+0.00,0.020,0.030,0.100,2",
        "PASHR,092725.000,123.45,T,-1.23,+0.56,+0.00,0.020,0.030,0.100",
        "PASHR,092725.000,123.45,T,-1.23,+0.56",
        "PASHR,092725.000,123.450,,-1.23,0.56,1.25,,,,5,0",
    ],
)
def test_pashr_with_fields_missing(body: str) -> None:
    assert angles(epoch_of(body)) == (12_345_000, 56_000, -123_000)


def test_pashr_hpr() -> None:
    body = "PASHR,HPR,092725.00,359.99,-04.30,{roll},0.0012,0.0010,{ambiguity},0,1.000,1.6"
    epoch = epoch_of(body.format(roll="", ambiguity=0))
    assert angles(epoch) == (35_999_000, -430_000, 0)
    assert epoch["flags"] == ge.HAS_TIME | ge.HAS_HEADING | ge.HAS_PITCH
    assert epoch_of(body.format(roll="1.0", ambiguity=1))["flags"] == ge.HAS_TIME, "ambiguities not fixed"


def test_psat_hpr() -> None:
    body = "PSAT,HPR,092725.00,10.51,2.25,-0.75,{kind}"
    assert angles(epoch_of(body.format(kind="N"))) == (1_051_000, 225_000, -75_000)
    assert epoch_of(body.format(kind="G"))["flags"] == ge.HAS_TIME, "from the gyro, no measurement"
    assert epoch_of("PSAT,HPR,092725.00,,,,N")["flags"] == ge.HAS_TIME


def test_gphpr() -> None:
    body = "GPHPR,092725.00,10.5132,-2.2544,000.0000,{quality},20,1.00,0999"
    assert angles(epoch_of(body.format(quality=4))) == (1_051_320, -225_440, 0)
    assert epoch_of(body.format(quality=0))["flags"] == ge.HAS_TIME
    assert angles(epoch_of("GPHPR,092725.00,10.51,-2.25,0.00,4")) == (1_051_000, -225_000, 0)


@pytest.mark.parametrize("quality", [0, 6])
def test_pashr_without_measurement_says_nothing_about_the_position(quality: int) -> None:
    gga = "GPGGA,092725.00,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,"
    epoch = epoch_of(gga, PASHR.replace(",1,4", f",{quality},0"))
    assert epoch["flags"] & ge.HAS_POSITION
    assert not epoch["flags"] & (ATTITUDE | ge.HAS_ATTITUDE_ACCURACY)
    assert angles(epoch) == (0, 0, 0)


def test_attitude_survives_the_loss_of_the_position() -> None:
    epoch = epoch_of("GPGGA,092725.00,,,,,0,00,,,M,,M,,", PASHR)
    assert epoch["flags"] == ge.HAS_TIME | ATTITUDE | ge.HAS_ATTITUDE_ACCURACY


def test_the_attitude_sentence_goes_before_hdt() -> None:
    for bodies in ((PASHR, "GPHDT,123.5,T"), ("GPHDT,123.5,T", PASHR)):
        assert epoch_of(*bodies)["heading_e5deg"] == 12_345_000


@pytest.mark.parametrize(
    "body",
    [
        PASHR.replace("123.45", "361.00"),
        PASHR.replace("-1.23", "-181.0"),
        PASHR.replace("+0.56", "+91.0"),
        PASHR.replace(",T,", ",M,"),
        PASHR.replace("092725.000", "999999.000"),
        PASHR.replace("0.100", "-0.1"),
        "GPHPR,10.5,4,2.0,1.0",
        "PSAT,HPR,092725.00,10.5,2.2.5,0,N",
    ],
)
def test_wrong_fields_spoil_the_sentence(body: str) -> None:
    line = ReceiverLine()
    line.send(sentence(body))
    line.silence()
    assert (line.stream.statistics().malformed, line.epochs) == (1, [])


@pytest.mark.parametrize("body", ["PSAT,ATT,1,2,3", "PSAT", "PASH,1", "PSAT,HP,1,2", "PASHR,LTN,3"])
def test_other_sentences_of_these_makers_are_left_alone(body: str) -> None:
    line = ReceiverLine()
    line.send(sentence(body))
    line.silence()
    assert [epoch["flags"] & ATTITUDE for epoch in line.epochs] in ([], [0])


@given(st.integers(0, 35_999), st.integers(-9_000, 9_000), st.integers(-18_000, 18_000))
def test_every_angle_comes_through(heading: int, pitch: int, roll: int) -> None:
    printed = f"{heading / 100:06.2f},T,{roll / 100:+06.2f},{pitch / 100:+06.2f}"
    body = f"PASHR,092725.000,{printed},+00.00,0.1,0.1,0.1,1,0"
    told = pynmeagps.NMEAReader.parse(sentence(body))
    epoch = epoch_of(body)
    assert angles(epoch) == (heading * 1000, pitch * 1000, roll * 1000)
    assert epoch["heading_e5deg"] == round(told.trueHdg * 1e5)


# -- real logs -------------------------------------------------------------------------------------


def recorded(name: str) -> list[str]:
    folder = os.environ.get("NAVTWIN_DATA")
    path = Path(folder or "/nowhere") / "gnss" / name
    if not folder or not path.is_file():
        pytest.skip(f"no {name} in NAVTWIN_DATA")
    return path.read_text().splitlines()


def read(lines: list[str], name: str) -> tuple[ReceiverLine, list[dict[str, int]]]:
    """The log as it came: a pause before the first sentence of each epoch."""
    line = ReceiverLine()
    first = "$GPHDT" if name == "hemi.log" else ""
    time = ""
    for text in lines:
        if not text.startswith("$"):
            continue
        told = text.split(",")[1][:9]
        timed = len(told) == 9 and not text.startswith("$GPHDT")
        starts = text.startswith(first) if first else timed and told != time
        if starts:
            line.silence()
        time = told if timed else time
        line.send(text.encode() + b"\r\n")
    line.silence()
    return line, line.epochs


def clock(epoch: dict[str, int]) -> str:
    seconds, ms = divmod(epoch["time_of_day_ms"], 1000)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}.{ms:03d}Z"


@pytest.mark.recording
@pytest.mark.parametrize(("name", "fixes"), [("hemi.log", 6), ("rst39.log", 43)])
def test_the_logs_give_what_gpsd_makes_of_them(name: str, fixes: int) -> None:
    """Position, mode, altitude over the sea, speed and track of every report of gpsd, to its digits.

    Not compared, since gpsd works them out itself: altHAE and geoidSep without a printed separation, climb,
    ept, eph, magvar and magtrack, the speed of a report without a printed one, and rst39's year (2033).
    """
    _, epochs = read(recorded(name), name)
    by_time = {clock(epoch): epoch for epoch in epochs if epoch["flags"] & ge.HAS_POSITION}
    lines = recorded(name + ".chk")
    compared = 0
    for at, text in enumerate(lines):
        if not text.startswith("{"):
            continue
        told: dict[str, Any] = json.loads(text)
        if told["class"] != "TPV" or "lat" not in told:
            continue
        epoch = by_time[told["time"].split("T")[1]]
        assert epoch["lat_nanodeg"] == round(told["lat"] * 1e9)
        assert epoch["lon_nanodeg"] == round(told["lon"] * 1e9)
        height = bool(epoch["flags"] & ge.HAS_HEIGHT_MSL)
        assert told["mode"] == 2 + height
        if height:
            assert epoch["height_msl_mm"] == round(told["altMSL"] * 1e3)
        printed = [line for line in lines[max(0, at - 4) : at] if line.startswith("$GPRMC")]
        if "track" in told:
            assert printed
            assert epoch["course_e5deg"] == round(told["track"] * 1e5)
            assert epoch["speed_mmps"] == round(told["speed"] * 1e3)
        compared += 1
    assert compared == fixes


@pytest.mark.recording
@pytest.mark.parametrize("name", ["hemi.log", "rst39.log"])
def test_headings_are_those_of_gpsd(name: str) -> None:
    """HDT: in the log's order, as gpsd's ATT has them where it gives them."""
    lines = recorded(name)
    printed = [
        round(float(text.split(",")[1]) * 1e5)
        for text in lines
        if text.startswith("$GPHDT,") and text[7] != ","
    ]
    told = [json.loads(text) for text in recorded(name + ".chk") if text.startswith('{"class":"ATT"')]
    assert told
    _, epochs = read(lines, name)
    seen = [e["heading_e5deg"] for e in epochs if e["flags"] & ge.HAS_HEADING]
    wanted = [round(att["heading"] * 1e5) for att in told]
    if name == "hemi.log":
        assert seen == printed == wanted
    else:
        without_pashr = [text for text in lines if not text.startswith("$PASHR")]
        _, alone = read(without_pashr, name)
        from_hdt = [e["heading_e5deg"] for e in alone if e["flags"] & ge.HAS_HEADING]
        assert from_hdt == printed
        assert set(wanted) <= set(from_hdt)


@pytest.mark.recording
def test_dates_and_attitudes_are_those_of_pynmeagps() -> None:
    lines = recorded("rst39.log")
    _, epochs = read(lines, "rst39.log")
    by_time = {epoch["time_of_day_ms"]: epoch for epoch in epochs}
    compared = 0
    for text in lines:
        if not text.startswith("$PASHR"):
            continue
        told = pynmeagps.NMEAReader.parse(text.encode() + b"\r\n")
        ms = (
            (told.utctime.hour * 60 + told.utctime.minute) * 60 + told.utctime.second
        ) * 1000 + told.utctime.microsecond // 1000
        expected = tuple(round(value * 1e5) for value in (told.trueHdg, told.pitch, told.roll))
        assert angles(by_time[ms]) == expected
        compared += 1
    assert compared == 100
    assert {e["date_days"] for e in epochs if e["flags"] & ge.HAS_DATE} == {12_463}, "2014-02-19"
