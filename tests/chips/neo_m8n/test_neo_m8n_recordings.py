"""Real M8N logs printed again from their own values and compared byte for byte."""

import math
import os
import re
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from neo_m8n_rig import EPOCH, Rig, lines, ubx_messages

from boards.chips.world import GnssEpoch, Satellite
from hal.emulated.virtual_time import SECOND

DATA = os.environ.get("NAVTWIN_DATA")
pytestmark = [
    pytest.mark.recording,
    pytest.mark.skipif(not DATA, reason="NAVTWIN_DATA is not set: no real receiver logs"),
]
GPS_EPOCH = datetime(1980, 1, 6)


class ReplayWorld:
    """Gives the recorded epochs one after the other, the first one also for the look at the clock."""

    def __init__(self, epochs: list[GnssEpoch]) -> None:
        self.epochs = epochs
        self.calls = 0

    def epoch(self, time_ns: int) -> GnssEpoch:
        """The world face."""
        index = max(self.calls - 1, 0)
        self.calls += 1
        epoch = self.epochs[min(index, len(self.epochs) - 1)]
        return replace(epoch, gps_time_ns=epoch.gps_time_ns - SECOND + time_ns) if self.calls == 1 else epoch


def recorded(name: str) -> Path:
    return Path(DATA or "") / "gnss" / name


def sets_of_log(path: Path) -> Iterator[list[str]]:
    """Sentences of each epoch, which begins with RMC; incomplete first and last sets are left out."""
    sentences = re.findall(r"\$G[A-Z0-9,.*\-]+", path.read_text(encoding="latin1"))
    starts = [index for index, text in enumerate(sentences) if "RMC" in text]
    for start, end in pairwise(starts):
        yield sentences[start:end]


def angle(text: str, hemisphere: str) -> float:
    degrees, minutes = divmod(float(text), 100.0)
    return math.radians((degrees + minutes / 60.0) * (-1 if hemisphere in "SW" else 1))


def speed_between(knots: str, kilometres_per_hour: str) -> float:
    """A speed that rounds to both printed values."""
    low = max((float(knots) - 0.0005) / 1.943844492, (float(kilometres_per_hour) - 0.0005) / 3.6)
    high = min((float(knots) + 0.0005) / 1.943844492, (float(kilometres_per_hour) + 0.0005) / 3.6)
    assert low < high
    return (low + high) / 2


def epoch_of(sentences: list[str]) -> GnssEpoch:
    rmc, vtg, gga = (sentences[index].split("*")[0].split(",") for index in range(3))
    used = {number for text in sentences if "GSA" in text for number in text.split(",")[3:15] if number}
    dops = next(text for text in sentences if "GSA" in text).split("*")[0].split(",")[15:18]
    satellites = []
    for text in sentences:
        if "GSV" in text:
            blocks = text.split("*")[0].split(",")[4:]
            for number, elevation, azimuth, cn0 in zip(*[iter(blocks)] * 4, strict=True):
                system = "GLONASS" if text.startswith("$GL") else "GPS" if int(number) <= 32 else "SBAS"
                angles = math.radians(float(elevation)), math.radians(float(azimuth))
                satellites.append(Satellite(system, int(number), *angles, float(cn0 or 0), number in used))
    instant = datetime.strptime(rmc[9] + rmc[1][:6], "%d%m%y%H%M%S")
    speed = speed_between(vtg[5], vtg[7])
    return replace(
        EPOCH,
        gps_time_ns=(int((instant - GPS_EPOCH).total_seconds()) + 16) * SECOND,
        leap_seconds=16,
        latitude=angle(rmc[3], rmc[4]),
        longitude=angle(rmc[5], rmc[6]),
        height=float(gga[9]) + float(gga[11]),
        geoid_separation=float(gga[11]),
        velocity_ned=(speed, 0.0, 0.0),
        s_acc=0.2,
        **dict(zip(("pdop", "hdop", "vdop"), map(float, dops), strict=True)),
        satellites=tuple(satellites),
    )


def test_every_set_of_a_real_log_is_printed_as_the_receiver_did() -> None:
    sets = list(sets_of_log(recorded("neo-m8n.log")))
    assert len(sets) >= 20
    rig = Rig(world=ReplayWorld([epoch_of(sentences) for sentences in sets]))
    rig.run_to(SECOND)
    printed = lines(rig.run(len(sets)))
    position = 0
    for sentences in sets:
        mine = printed[position : position + len(sentences)]
        position += len(sentences)
        for ours, real in zip(mine, sentences, strict=True):
            if "GSA" in real:  # the order of the slots is the receiver's channels
                assert sorted(ours.split("*")[0].split(",")) == sorted(real.split("*")[0].split(","))
            else:
                assert ours == real


def test_nav_pvt_of_a_real_log_is_packed_as_the_receiver_did() -> None:
    raw = recorded("ublox-neo-m8n.log").read_bytes()
    stream = raw[raw.index(b"\xb5\x62") :]  # its last frame is cut off
    messages = [m for m in ubx_messages(stream, broken=0) if m.identity == "NAV-PVT"]
    assert len(messages) >= 20
    rig = Rig(world=ReplayWorld([epoch_of_pvt(message) for message in messages]))
    rig.run(0.3)
    rig.say("B5 62 06 01 03 00 01 07 01 13 51")
    rig.say("B5 62 06 08 06 00 C8 00 01 00 01 00 DE 6A")
    ours = [m for m in ubx_messages(rig.run(12.0)) if m.identity == "NAV-PVT" and m.fixType == 3]
    by_time = {message.iTOW: message for message in ours}
    compared = 0
    for real in messages:
        mine = by_time.get(real.iTOW)
        if mine is None:
            continue  # before the hot start's first fix
        compared += 1
        assert masked(mine) == masked(real)
        assert abs(mine.gSpeed - real.gSpeed) <= 1
        assert mine.tAcc in range(1, 10)
    assert compared >= 15


def epoch_of_pvt(pvt: Any) -> GnssEpoch:
    instant = datetime(pvt.year, pvt.month, pvt.day, pvt.hour, pvt.min, pvt.second)
    seconds = int((instant - GPS_EPOCH).total_seconds())
    satellites = tuple(Satellite("GPS", n + 1, 0.5, 0.5, 40.0, True) for n in range(pvt.numSV))
    return replace(
        EPOCH,
        gps_time_ns=(seconds + 18) * SECOND + pvt.nano,
        latitude=math.radians(pvt.lat),
        longitude=math.radians(pvt.lon),
        height=pvt.height / 1e3,
        geoid_separation=(pvt.height - pvt.hMSL) / 1e3,
        velocity_ned=(pvt.velN / 1e3, pvt.velE / 1e3, pvt.velD / 1e3),
        h_acc=pvt.hAcc / 1e3,
        v_acc=pvt.vAcc / 1e3,
        s_acc=pvt.sAcc / 1e3,
        pdop=pvt.pDOP,
        satellites=satellites,
    )


def masked(pvt: Any) -> bytes:
    """The payload without what this sky does not hold: time accuracy, DGPS and other flags, frozen course,
    reserved bytes."""
    payload = bytearray(pvt.payload)
    for begin, end in ((12, 16), (21, 23), (60, 68), (72, 76), (78, 92)):
        payload[begin:end] = bytes(end - begin)
    payload[11] &= 0x0F  # the recorder's firmware also sets undocumented bits of `valid`
    return bytes(payload)
