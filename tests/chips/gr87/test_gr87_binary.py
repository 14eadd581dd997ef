"""The GR-87 in SiRF binary: messages by the places of their bytes, commands, and gpsd's decoder."""

from __future__ import annotations

import json
import shutil
import subprocess

import pymap3d
import pytest
from gr87_rig import Rig, lines
from hypothesis import given, settings
from hypothesis import strategies as st

LATITUDE, LONGITUDE, HEIGHT = 50.0 + 30.12345 / 60, -(4.0 + 15.54321 / 60), 87.44 + 48.1
WEEK, TOW_S = 2305, 5 * 86_400 + 9 * 3600 + 27 * 60 + 25 + 18


def frame(payload: bytes) -> bytes:
    size, total = len(payload).to_bytes(2, "big"), (sum(payload) & 0x7FFF).to_bytes(2, "big")
    return b"\xa0\xa2" + size + payload + total + b"\xb0\xb3"


def payloads(data: bytes) -> list[bytes]:
    """Of whole frames that follow one another; AssertionError for anything else."""
    found = []
    while data:
        length = int.from_bytes(data[2:4], "big")
        assert frame(data[4 : 4 + length]) == data[: length + 8]
        found.append(data[4 : 4 + length])
        data = data[length + 8 :]
    return found


def number(payload: bytes, at: int, size: int, signed: bool = False) -> int:
    return int.from_bytes(payload[at : at + size], "big", signed=signed)


@pytest.fixture
def rig() -> Rig:
    rig = Rig()
    rig.wait(3.0)
    rig.say("PSRF100,0,38400,8,1,0")
    rig.wait(1.5)
    return rig


def test_a_set_by_the_places_of_its_bytes(rig: Rig) -> None:
    """Valid at 4 s of the run: 1 s after the last full second before."""
    navigation, tracker, geodetic = payloads(rig.wait(1.0))
    assert [len(navigation), len(tracker), len(geodetic)] == [41, 188, 91]
    assert [navigation[0], tracker[0], geodetic[0]] == [2, 4, 41]

    assert [number(navigation, at, 4, True) for at in (1, 5, 9)] == [
        round(one) for one in pymap3d.geodetic2ecef(LATITUDE, LONGITUDE, HEIGHT)
    ]
    east_north_up = (4.0, 3.0, 0.25)
    assert [number(navigation, at, 2, True) / 8 for at in (13, 15, 17)] == pytest.approx(
        pymap3d.enu2uvw(*east_north_up, LATITUDE, LONGITUDE), abs=0.07
    )
    tow_s = TOW_S + 5
    assert (navigation[19] & 7, number(navigation, 22, 2), number(navigation, 24, 4)) == (
        4,
        WEEK % 1024,
        tow_s * 100,
    )
    assert (navigation[28], sorted(navigation[29:41])) == (4, [0] * 8 + [1, 3, 4, 11])

    assert tracker[7] == 12
    channels = [tracker[8 + 15 * k : 23 + 15 * k] for k in range(12)]
    assert [one[0] for one in channels] == [1, 3, 4, 8, 11, 12, 0, 0, 0, 0, 0, 0]
    assert (channels[1][1] * 1.5, channels[1][2] / 2, set(channels[1][5:])) == (301.5, 29.0, {24})

    assert (number(geodetic, 1, 2), number(geodetic, 3, 2) & 7) == (0, 4)
    assert (number(geodetic, 5, 2), number(geodetic, 7, 4)) == (WEEK, tow_s * 1000)
    assert [number(geodetic, 11, 2), *geodetic[13:17], number(geodetic, 17, 2)] == [
        2024,
        3,
        15,
        9,
        27,
        30_000,
    ]
    assert number(geodetic, 19, 4) == 1 << 0 | 1 << 2 | 1 << 3 | 1 << 10
    angles = [number(geodetic, at, 4, True) * 1e-7 for at in (23, 27)]
    assert angles == pytest.approx([LATITUDE, LONGITUDE], abs=1e-7)
    assert [number(geodetic, at, 4, True) for at in (31, 35)] == [13_554, 8744]
    assert [geodetic[39], number(geodetic, 40, 2), number(geodetic, 42, 2)] == [21, 500, 5313]
    assert number(geodetic, 46, 2, True) == 25


def test_without_a_fix_it_says_so() -> None:
    rig = Rig(start_state="cold")
    rig.wait(1.0)
    rig.say("PSRF100,0,38400,8,1,0")
    rig.wait(1.5)
    navigation, _, geodetic = payloads(rig.wait(1.0))
    assert (navigation[1:20], navigation[28]) == (bytes(19), 0)
    assert number(geodetic, 1, 2) & 1 == 1
    assert geodetic[23:39] == bytes(16)


def test_commands_and_back_to_sentences(rig: Rig) -> None:
    """Sentences are not heard; 132 tells the version, 166 sets rates and asks once, 134 the bit rate."""
    rig.say("PSRF100,1,4800,8,1,0")
    for number_of in (2, 4, 41):
        rig.chip.receive(frame(bytes((166, 0, number_of, 0, 0, 0, 0, 0))), rig.time.now)
    assert payloads(rig.wait(1.05)) == [b"\x0b\xa6"] * 3
    assert payloads(rig.wait(3.0)) == []
    rig.chip.receive(frame(b"\x84\x00") + frame(bytes((166, 1, 41, 1, 0, 0, 0, 0))), rig.time.now)
    told = payloads(rig.wait(0.5))
    assert [one[0] for one in told] == [11, 6, 11, 41]
    assert told[1].endswith(b"\0")
    rig.chip.receive(frame(b"\x86" + (9600).to_bytes(4, "big") + b"\x08\x01\x00\x00"), rig.time.now)
    assert payloads(rig.wait(0.5)) == [b"\x0b\x86"]
    assert rig.chip.baud == 9600
    rig.chip.receive(frame(b"\xfe\x00"), rig.time.now)
    assert payloads(rig.wait(0.2)) == [b"\x0c\xfe"]
    back = frame(bytes([0x81, 2, 1, 1] + [0, 1] * 3 + [1, 1] + [0, 1] * 5) + (4800).to_bytes(2, "big"))
    rig.chip.receive(b"\xa0\xa2\xff" + back[:10], rig.time.now)
    rig.chip.receive(back[10:], rig.time.now)
    rig.wait(1.05)
    assert [line[:6] for line in lines(rig.wait(1.0))] == ["$GPGGA", "$GPRMC"]
    assert rig.chip.baud == 4800


@settings(max_examples=25, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=40).map(frame), st.binary(max_size=30)), max_size=8))
def test_whatever_comes_in_only_whole_frames_or_sentences_leave(said: list[bytes]) -> None:
    rig = Rig(baud=38_400)
    told = rig.wait(1.0)
    rig.say("PSRF100,0,38400,8,1,0")
    for data in said:
        rig.chip.receive(data, rig.time.now)
        told += rig.wait(0.7)
    told += rig.wait(1.0)
    while told:
        if told[:2] == b"\xa0\xa2":
            end = 8 + int.from_bytes(told[2:4], "big")
            assert len(told) < end or frame(told[4 : end - 4]) == told[:end]
        else:
            end = told.find(b"\r\n") + 2
            assert told[:1] == b"$"
            assert b"*" in told[:end] or end == 1
        told = told[end:] if end > 1 else b""


@pytest.mark.skipif(shutil.which("gpsdecode") is None, reason="gpsdecode (gpsd) is not installed")
def test_gpsd_reads_the_binary_messages(rig: Rig) -> None:
    done = subprocess.run(["gpsdecode"], input=rig.wait(4.0), capture_output=True, timeout=20, check=True)
    told = [json.loads(line) for line in done.stdout.splitlines()]
    fixes = [one for one in told if one["class"] == "TPV" and one.get("mode") == 3]
    assert fixes[-1]["time"] == "2024-03-15T09:27:33.000Z"
    assert fixes[-1]["lat"] == pytest.approx(LATITUDE, abs=5e-6)
    assert fixes[-1]["lon"] == pytest.approx(LONGITUDE, abs=8e-6)
    assert fixes[-1]["altHAE"] == pytest.approx(HEIGHT, abs=1.0)
    assert fixes[-1]["speed"] == pytest.approx(5.0, abs=0.1)
