"""The two-antenna receiver: sentences to the letter, attitude, commands, whatever comes in."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import reduce
from operator import xor
from typing import Any

import pynmea2
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pynmeagps import NMEAReader

from boards.chips.dual_antenna import DualAntennaReceiver
from boards.chips.world import BaselineSolution, GnssEpoch, Satellite
from hal.emulated.uart_wire import UartWire
from hal.emulated.virtual_time import SECOND, VirtualTime

START_GPS_NS = (2305 * 604_800 + 5 * 86_400 + 9 * 3600 + 27 * 60 + 25 + 18) * SECOND
"""2024-03-15 09:27:25 UTC."""
BASELINE = BaselineSolution(
    fix="FIXED", heading=math.radians(123.4564), pitch=math.radians(-1.2344), length=2.0,
    heading_acc=math.radians(0.1), pitch_acc=math.radians(0.17), length_acc=0.005,
)  # fmt: skip
EPOCH = GnssEpoch(
    fix=True, time_known=True, gps_time_ns=START_GPS_NS, leap_seconds=18,
    latitude=math.radians(42.0 + 21.8237733 / 60.0), longitude=math.radians(-(71.0 + 1.9411707 / 60.0)),
    height=10.8351 - 33.32, geoid_separation=-33.32, velocity_ned=(3.0, 4.0, -0.25), h_acc=1.2, v_acc=2.0,
    s_acc=0.1, pdop=1.56, hdop=0.95, vdop=1.27, tdop=0.9,
    satellites=tuple(Satellite("GPS", n, 0.5, 1.0, 40.0, True) for n in range(1, 9)),
    latency_ns=50_000_000, baseline=BASELINE,
)  # fmt: skip
ALL = ["GGA", "RMC", "VTG", "ZDA", "GST", "HDT", "THS", "PASHR", "PASHR,HPR", "PSAT,HPR", "HPR"]


class Rig:
    """Receiver, wire and what came over it; its world is `told` with the time moved on."""

    def __init__(self, told: GnssEpoch = EPOCH, **parameters: Any) -> None:
        self.time = VirtualTime()
        self.told = told
        self.wire = UartWire(self.time, 19_200, "gnss")
        self.heard: list[bytes] = []
        self.wire.connect(self)
        self.chip = DualAntennaReceiver(self.time, self, self.wire, **parameters)

    def epoch(self, time_ns: int) -> GnssEpoch:
        return replace(self.told, gps_time_ns=self.told.gps_time_ns + time_ns)

    def receive(self, data: bytes, time_ns: int) -> None:
        self.heard.append(data)

    def wait(self, seconds: float) -> list[str]:
        """The lines that come in that time."""
        self.heard.clear()
        end = self.time.now + round(seconds * SECOND)
        self.time.at(end, lambda: None)
        while self.time.now < end:
            self.time.run_next()
        return [line for line in b"".join(self.heard).decode().split("\r\n") if line]

    def say(self, text: str) -> None:
        self.chip.receive(text.encode() + b"\r\n", self.time.now)


def body(line: str) -> str:
    text, check = line[1:].rsplit("*", 1)
    assert int(check, 16) == reduce(xor, text.encode(), 0)
    return text


def test_a_set_to_the_letter() -> None:
    rig = Rig(sentences=ALL, baud=115_200)
    rig.wait(14.04)
    assert [body(line) for line in rig.wait(1.0)] == [
        "GPGGA,092739.00,4221.8237733,N,07101.9411707,W,1,08,0.95,10.835,M,-33.320,M,,",
        "GPRMC,092739.00,A,4221.8237733,N,07101.9411707,W,9.719,53.13,150324,,,A",
        "GPVTG,53.13,T,,M,9.719,N,18.000,K,A",
        "GPZDA,092739.00,15,03,2024,00,00",
        "GPGST,092739.00,,,,,0.85,0.85,2.0",
        "GPHDT,123.456,T",
        "GPTHS,123.456,A",
        "PASHR,092739.00,123.456,T,,-1.234,,,0.170,0.100,1,0",
        "PASHR,HPR,092739.00,123.456,-1.234,,,0.0050,0,0,,1.56",
        "PSAT,HPR,092739.00,123.456,-1.234,,N",
        "GPHPR,092739.00,123.456,-1.234,,4,08,,",
    ]


def test_antennas_across_give_the_roll() -> None:
    rig = Rig(sentences=["HDT", "PASHR"], antennas="across")
    rig.wait(14.04)
    assert [body(line) for line in rig.wait(1.0)] == [
        "GPHDT,33.456,T",
        "PASHR,092739.00,33.456,T,1.234,,,0.170,,0.100,1,0",
    ]


def test_real_valued_ambiguities_are_told() -> None:
    rig = Rig(replace(EPOCH, baseline=replace(BASELINE, fix="FLOAT")), sentences=ALL[5:], baud=115_200)
    rig.wait(14.04)
    assert [body(line) for line in rig.wait(1.0)] == [
        "GPHDT,,T",
        "GPTHS,123.456,E",
        "PASHR,092739.00,123.456,T,,-1.234,,,0.170,0.100,1,0",
        "PASHR,HPR,092739.00,123.456,-1.234,,,0.0050,1,0,,1.56",
        "PSAT,HPR,092739.00,,,,N",
        "GPHPR,092739.00,123.456,-1.234,,5,08,,",
    ]


@pytest.mark.parametrize("baseline", [None, replace(BASELINE, fix="NONE")])
def test_without_a_baseline_there_is_no_attitude(baseline: BaselineSolution | None) -> None:
    rig = Rig(replace(EPOCH, baseline=baseline), sentences=ALL[5:], baud=115_200)
    rig.wait(14.04)
    assert [body(line) for line in rig.wait(1.0)] == [
        "GPHDT,,T",
        "GPTHS,,V",
        "PASHR,092739.00,,T,,,,,,,0,0",
        "PASHR,HPR,092739.00,,,,,,9,0,,",
        "PSAT,HPR,092739.00,,,,N",
        "GPHPR,092739.00,,,,0,08,,",
    ]


def test_no_fix_forms_are_those_of_the_real_log() -> None:
    rig = Rig(start_state="cold", sentences=["GGA", "VTG", "HDT", "RMC"])
    rig.wait(5.04)
    told = rig.wait(1.0)
    assert told == [
        "$GPGGA,,,,,,0,,,,M,,M,,*66",
        "$GPRMC,,V,,,,,,,,,,N*53",
        "$GPVTG,,T,,M,,N,,K,N*2C",
        "$GPHDT,,T*1B",
    ]


def test_heading_at_the_turn_of_the_circle() -> None:
    rig = Rig(replace(EPOCH, baseline=replace(BASELINE, heading=math.radians(359.99996))), sentences=["HDT"])
    rig.wait(14.04)
    assert [body(line) for line in rig.wait(1.0)] == ["GPHDT,0.000,T"]


@pytest.mark.parametrize("state", ["cold", "warm", "hot"])
def test_heading_comes_ten_seconds_after_the_fix(state: str) -> None:
    rig = Rig(start_state=state, sentences=["GGA", "HDT"], baud=115_200)
    told = [body(line) for line in rig.wait(60.0)]
    fix = next(k for k, line in enumerate(told) if "GPGGA" in line and ",1,08," in line)
    heading = next(k for k, line in enumerate(told) if line == "GPHDT,123.456,T")
    assert heading - fix == 2 * 10 + 1
    first = told[fix].split(",")[1]
    assert first == {"cold": "092805.00", "warm": "092745.00", "hot": "092726.00"}[state]


def test_rates_of_twenty_and_of_single_sentences() -> None:
    rig = Rig(rate_hz=20, baud=115_200, sentences=["GGA", "HDT"])
    rig.wait(5.04)
    rig.say("$JASC,GPGGA,1")
    rig.say("$JASC,GPHDT,10")
    rig.say("$JASC,PSAT,HPR,2")
    assert rig.wait(0.02) == ["$>", "$>", "$>"]
    rig.wait(1.0)
    told = rig.wait(1.0)
    assert [sum(line.startswith(name) for line in told) for name in ("$GPGGA", "$GPHDT", "$PSAT")] == [
        1,
        10,
        2,
    ]
    rig.say("$JOFF")
    assert rig.wait(0.2)[-1] == "$>"
    assert rig.wait(1.0) == []


def test_bit_rate() -> None:
    rig = Rig()
    rig.wait(3.5)
    rig.say("$JBAUD,115200")
    rig.wait(1.0)
    assert rig.chip.baud == 115_200 == rig.wire.baud
    rig.chip.power(False)
    rig.chip.power(True)
    rig.wait(3.0)
    assert rig.chip.baud == 19_200, "not kept without supply"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("$JASC,GPGGA,3", "protocol"), ("$JASC,GPXXX,1", "protocol"), ("$JASC,GPGGA,x", "protocol"),
        ("$JASC,GPGGA,20", "protocol"), ("$JBAUD,1234", "protocol"), ("$JBAUD,x", "protocol"),
        ("$JBAUD,0000096001", "protocol"), ("$JASC,GPGGA,00005", "protocol"),
        ("$JATT,TILTAID,YES", "not modelled"), ("$JASC", "not modelled"), ("$JBAUD", "not modelled"),
        ("$GPGGA,1", "not modelled"), ("$", "not modelled"),
    ],
)  # fmt: skip
def test_what_it_cannot_is_reported_and_ignored(text: str, kind: str) -> None:
    rig = Rig()
    rig.wait(3.5)
    rig.say(text)
    assert [report.kind.value for report in rig.chip.reports] == [kind]
    assert "$>" not in rig.wait(0.4)


@pytest.mark.parametrize(
    "parameters",
    [{"rate_hz": 3}, {"baud": 1}, {"sentences": ["XYZ"]}, {"antennas": "up"}, {"start_state": "tepid"}],
)
def test_wrong_parameters_are_named(parameters: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(parameters))} = .*possible"):
        Rig(**parameters)


def test_others_read_it() -> None:
    rig = Rig(sentences=ALL, baud=115_200)
    rig.wait(14.04)
    for line in rig.wait(1.0):
        told = NMEAReader.parse(line.encode() + b"\r\n", validate=1)
        if told.identity == "PASHR":
            assert (told.trueHdg, told.pitch, told.pitchAcc, told.hdgAcc) == (123.456, -1.234, 0.17, 0.1)
        if told.msgID == "HDT":
            assert told.headingT == 123.456
    rig.wait(0.5)
    for line in rig.wait(1.0):
        if line.startswith(("$GPGGA", "$GPRMC", "$GPVTG", "$GPZDA", "$GPHDT")):
            told = pynmea2.parse(line)
            if told.sentence_type == "GGA":
                assert told.latitude == pytest.approx(42.0 + 21.8237733 / 60.0, abs=1e-9)
                assert (told.altitude, told.geo_sep) == (10.835, "-33.320")


SAID = st.one_of(
    st.binary(max_size=60),
    st.builds(
        lambda name, fields: f"${name},{','.join(fields)}\r\n".encode(),
        st.sampled_from(["JASC", "JBAUD", "JOFF", "JATT", "JRESET"]),
        st.lists(
            st.sampled_from(["GPGGA", "GPHDT", "PSAT", "HPR", "PASHR", "1", "5", "0", "OTHER", "19200", "x"]),
            max_size=4,
        ),
    ),
    st.just(b"power"),
)


@settings(max_examples=40, deadline=None)
@given(st.lists(SAID, max_size=8))
def test_nothing_raises_and_only_sentences_leave(said: list[bytes]) -> None:
    rig = Rig(rate_hz=5, baud=38_400)
    rig.wait(2.0)
    on = True
    for data in said:
        if data == b"power":
            on = not on
            rig.chip.power(on)
        else:
            rig.chip.receive(data, rig.time.now)
        rig.wait(1.1)
    for line in rig.wait(3.0)[1:-1]:
        assert line == "$>" or body(line)
