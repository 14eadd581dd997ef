"""Properties: whatever the sky says is printed so that it reads back, whatever the host says is survived."""

import math
from dataclasses import replace
from datetime import datetime, timedelta

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from neo_m8n_rig import (
    EPOCH,
    SKY,
    BenchWorld,
    Rig,
    line,
    lines,
    nmea,
    nmea_messages,
    quiet_rig,
    ubx,
    ubx_messages,
)

from boards.chips.world import Satellite
from hal.emulated.virtual_time import SECOND

ONE_MINUTE_DIGIT = 1e-5 / 60
FAST_PORT = ubx(6, 0, bytes.fromhex("01000000d0080000000e0e000700030000000000"))
RATES = b"".join(
    ubx(6, 1, bytes((c, i, 1))) for c, i in ((1, 7), (1, 6), (0xF0, 7), (0xF0, 8), (0xF0, 13), (0xF1, 0))
)


class Bench:
    """One running receiver that prints each example as its next epoch."""

    def __init__(self) -> None:
        self.world = BenchWorld()
        self.rig = Rig(world=self.world)
        self.rig.run(0.3)
        self.rig.say(FAST_PORT)
        self.rig.run(0.7)
        self.rig.say(RATES)
        self.rig.run(1.9)

    def printed(self, **changes: object) -> tuple[list, bytes]:
        """UBX messages and sentences of one epoch with these changes to the sky."""
        self.world.now = replace(EPOCH, **changes)
        data = self.rig.run(1.0)
        start = 0
        while data[start : start + 2] == b"\xb5\x62":
            start += 8 + int.from_bytes(data[start + 4 : start + 6], "little")
        return ubx_messages(data[:start]), data[start:]


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench()


@settings(max_examples=60, deadline=None)
@given(
    latitude=st.floats(-90.0, 90.0),
    longitude=st.floats(-180.0, 180.0),
    height=st.floats(-500.0, 50_000.0),
    separation=st.floats(-110.0, 90.0),
)
def test_positions_read_back_within_half_a_unit_of_the_last_digit(
    bench: Bench, latitude: float, longitude: float, height: float, separation: float
) -> None:
    messages, sentences = bench.printed(
        latitude=math.radians(latitude),
        longitude=math.radians(longitude),
        height=height,
        geoid_separation=separation,
    )
    for parsed in nmea_messages(sentences):
        if hasattr(parsed, "lat"):
            assert parsed.lat == pytest.approx(latitude, abs=0.5001 * ONE_MINUTE_DIGIT)
            assert parsed.lon == pytest.approx(longitude, abs=0.5001 * ONE_MINUTE_DIGIT)
        if parsed.msgID in ("GGA", "GNS"):
            assert parsed.alt == pytest.approx(height - separation, abs=0.05001)
            assert parsed.sep == pytest.approx(separation, abs=0.05001)
    pvt = next(message for message in messages if message.identity == "NAV-PVT")
    assert pvt.lat == pytest.approx(latitude, abs=0.5001e-7)
    assert pvt.lon == pytest.approx(longitude, abs=0.5001e-7)
    assert pvt.height == pytest.approx(height * 1e3, abs=0.501)
    assert "60.0000" not in sentences.decode()


@settings(max_examples=60, deadline=None)
@given(speed=st.floats(0.0, 500.0), course=st.floats(0.0, 360.0), s_acc=st.floats(0.01, 1.0))
def test_speeds_and_courses_read_back(bench: Bench, speed: float, course: float, s_acc: float) -> None:
    angle = math.radians(course)
    messages, sentences = bench.printed(
        velocity_ned=(speed * math.cos(angle), speed * math.sin(angle), 0.5), s_acc=s_acc
    )
    parsed = {message.msgID: message for message in nmea_messages(sentences)}
    assert parsed["RMC"].spd == pytest.approx(speed * 3600 / 1852, abs=0.000501)
    assert parsed["VTG"].sogk == pytest.approx(speed * 3.6, abs=0.000501)
    pvt = next(message for message in messages if message.identity == "NAV-PVT")
    assert pvt.gSpeed == pytest.approx(speed * 1e3, abs=0.501)
    assert (pvt.velN, pvt.velE) == pytest.approx(
        (speed * math.cos(angle) * 1e3, speed * math.sin(angle) * 1e3), abs=0.501
    )
    if speed < 0.0999 or speed < s_acc * 0.999:
        assert parsed["RMC"].cog == parsed["VTG"].cogt == ""
    elif speed > 0.1001 and speed > s_acc * 1.001:
        assert 0.0 <= parsed["RMC"].cog < 360.0
        assert abs((parsed["RMC"].cog - course + 180.0) % 360.0 - 180.0) <= 0.00501
        assert parsed["VTG"].cogt == parsed["RMC"].cog
        assert abs((pvt.headMot - course + 180.0) % 360.0 - 180.0) <= 1e-5


@settings(max_examples=60, deadline=None)
@given(
    seconds=st.integers(0, 3_000_000_000), leap=st.integers(0, 37), nanoseconds=st.integers(0, 999_999_999)
)
def test_times_read_back(seconds: int, leap: int, nanoseconds: int) -> None:
    """Any time of the years 1980 to 2075, at any offset of the epoch's clock."""
    world = BenchWorld(gps_time_ns=seconds * SECOND + nanoseconds, leap_seconds=leap)
    rig = Rig(world=world)
    rig.run_to(250_000_000)
    rig.say(FAST_PORT)
    rig.say(RATES)
    last_epoch = 3 * SECOND - nanoseconds
    data = rig.run_to(last_epoch + SECOND // 2)
    assert max(world.asked) == last_epoch
    exact_ns = seconds * SECOND + nanoseconds + last_epoch
    utc = datetime(1980, 1, 6) + timedelta(seconds=exact_ns // SECOND - leap)
    zda = nmea_messages(nmea(line(data[data.rindex(b"$GNRMC") :], "ZDA")[1:-3]))[0]
    assert (zda.year, zda.month, zda.day) == (utc.year, utc.month, utc.day)
    assert (zda.time.hour, zda.time.minute, zda.time.second) == (utc.hour, utc.minute, utc.second)
    pvt = [message for message in ubx_messages(data) if message.identity == "NAV-PVT"][-1]
    assert (pvt.year, pvt.month, pvt.day) == (utc.year, utc.month, utc.day)
    assert (pvt.hour, pvt.min, pvt.second, pvt.nano) == (utc.hour, utc.minute, utc.second, 0)
    assert pvt.iTOW == exact_ns // 1_000_000 % 604_800_000


@settings(max_examples=40, deadline=None)
@given(
    sky=st.lists(
        st.builds(
            Satellite,
            system=st.sampled_from(["GPS", "GLONASS", "SBAS"]),
            number=st.integers(1, 32),
            elevation=st.floats(-0.1, math.pi / 2),
            azimuth=st.floats(-7.0, 7.0),
            cn0_dbhz=st.floats(0.0, 120.0),
            used=st.booleans(),
        ),
        max_size=40,
    )
)
def test_skies_read_back(bench: Bench, sky: list[Satellite]) -> None:
    numbered = {"GPS": 0, "SBAS": 32, "GLONASS": 64}
    satellites = tuple(replace(sat, number=sat.number + numbered[sat.system]) for sat in sky)
    _, sentences = bench.printed(satellites=satellites)
    seen: list[tuple] = []
    for message in nmea_messages(sentences):
        if message.msgID == "GSV":
            wanted = [sat for sat in satellites if (sat.system == "GLONASS") is (message.talker == "GL")]
            assert message.numSV == len(wanted)
            assert message.numMsg == max(1, math.ceil(len(wanted) / 4))
            seen += [
                tuple(getattr(message, f"{name}_0{index}") for name in ("svid", "elv", "az", "cno"))
                for index in range(1, 5)
                if hasattr(message, f"svid_0{index}")
            ]
    assert len(seen) == len(satellites)
    ordered = [sat for sat in satellites if sat.system != "GLONASS"] + [
        sat for sat in satellites if sat.system == "GLONASS"
    ]
    for (number, elevation, azimuth, cn0), satellite in zip(seen, ordered, strict=True):
        assert number == satellite.number
        assert 0 <= elevation <= 90
        assert abs(elevation - max(math.degrees(satellite.elevation), 0.0)) <= 0.5001
        assert abs((azimuth - math.degrees(satellite.azimuth) + 180.0) % 360.0 - 180.0) <= 0.5001
        assert cn0 == "" if satellite.cn0_dbhz < 0.5 else abs(cn0 - min(satellite.cn0_dbhz, 99)) <= 0.5001


PIECES = st.one_of(
    st.binary(max_size=40),
    st.sampled_from(
        [
            b"\xb5\x62",
            b"$PUBX,",
            b"$",
            b"\r\n",
            b"\xb5\x62\x06\x00\xff\xff",
            ubx(6, 8)[:-1],
            ubx(6, 8, b"\0" * 6),
            nmea("PUBX,41,1,0007,0003,19200,0"),
            nmea("PUBX,40,ZDA,1,1,1,1,1,1"),
            nmea("PUBX,04"),
            b"$PUBX,00*FF\r\n",
        ]
    ),
    st.builds(
        lambda i, p: ubx(6, i, p),
        st.sampled_from([0, 1, 2, 4, 8, 9, 0x17, 0x24, 0x31, 0x3E]),
        st.binary(max_size=64),
    ),
)


@settings(max_examples=150, deadline=None)
@given(pieces=st.lists(PIECES, max_size=12))
def test_nothing_the_host_sends_breaks_the_receiver(pieces: list[bytes]) -> None:
    rig = Rig()
    rig.run(1.3)
    for piece in pieces:
        rig.say(piece)
        rig.run(0.05)
    rig.run(1.0)
    assert all(data for _, data in rig.host.chunks)


@settings(max_examples=60, deadline=None)
@given(garbage=st.binary(max_size=60), data=st.data())
def test_messages_are_found_between_garbage_and_in_any_pieces(garbage: bytes, data: st.DataObject) -> None:
    rig = quiet_rig()
    stream = garbage.replace(b"\xb5", b"").replace(b"$", b"") + ubx(6, 8) + nmea("PUBX,04") + ubx(0x0A, 4)
    while stream:
        count = data.draw(st.integers(1, len(stream)))
        rig.say(stream[:count])
        stream = stream[count:]
    heard = rig.run(0.9)
    assert [m.identity for m in ubx_messages(heard)] == ["CFG-RATE", "ACK-ACK", "MON-VER"]
    assert b"$PUBX,04," in heard


@pytest.mark.parametrize(
    "junk",
    [
        ubx(6, 8)[:-1] + b"\x00",  # a wrong checksum
        ubx(6, 8)[:5],  # cut off
        b"\xb5\x62\x06\x08\xff\xff",  # absurd length
        b"\xb5\xb5",
        b"$PUBX,00*34\r\n",
        b"$PUBX,00",  # cut off
        b"$" * 300,
        b"$GPGGA," + b"x" * 400,
    ],
)
def test_search_goes_on_right_behind_a_false_start(junk: bytes) -> None:
    rig = quiet_rig()
    rig.say(junk + ubx(6, 8))
    assert [m.identity for m in ubx_messages(rig.run(0.9))] == ["CFG-RATE", "ACK-ACK"]


def test_two_runs_are_equal_byte_for_byte() -> None:
    heard = []
    for _ in range(2):
        rig = Rig(start_state="cold", listen=True)
        rig.run(20.0)
        rig.say("B5 62 06 01 03 00 01 07 01 13 51")
        rig.run(15.0)
        heard.append((rig.host.chunks, rig.edges))
    assert heard[0] == heard[1]
    assert len(lines(heard[0][0][0][1])) == 15
    assert SKY[0].used
