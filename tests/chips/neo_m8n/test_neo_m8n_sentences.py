"""What the receiver prints, against the fact sheet's own strings and an independent parser."""

import math
import re
from dataclasses import replace

import pytest
from neo_m8n_rig import EPOCH, SKY, BenchWorld, Rig, line, lines, nmea_messages, ubx

from boards.chips.world import Satellite

ALL_SENTENCES = (0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x07, 0x08, 0x0D)

NO_FIX_TABLE = {
    "RMC": ("$GNRMC,,V,,,,,,,,,,N*4D", 25),
    "VTG": ("$GNVTG,,,,,,,,,N*2E", 21),
    "GGA": ("$GNGGA,,,,,,0,00,99.99,,,,,,*56", 33),
    "GSA": ("$GNGSA,A,1,,,,,,,,,,,,,99.99,99.99,99.99*2E", 45),
    "GLL": ("$GNGLL,,,,,,V,N*7A", 20),
    "ZDA": ("$GNZDA,,,,,00,00*56", 21),
    "GNS": ("$GNGNS,,,,,,NN,00,99.99,,,,*7D", 32),
    "GST": ("$GNGST,,,,,,,,*49", 19),
}


def epoch_text(
    version: int = 0x40, nmea: dict[int, int] | None = None, gnss: bytes = b"", **changes: object
) -> bytes:
    """One set of all sentences: hot start, CFG-NMEA bytes changed, then the second epoch with a fix."""
    world = BenchWorld(**changes)
    rig = Rig(world=world)
    rig.run(0.3)
    rig.say(ubx(6, 0x00, bytes.fromhex("01000000d0080000000e0e000700030000000000")))  # 921600 baud
    payload = bytearray(20)
    payload[1], payload[3], payload[11] = version, 2, 1
    for index, value in (nmea or {}).items():
        payload[index] = value
    rig.run(0.6)
    rig.say(ubx(6, 0x17, bytes(payload)))
    for message in ALL_SENTENCES:
        rig.say(ubx(6, 0x01, bytes((0xF0, message, 1))))
    if gnss:
        rig.say(ubx(6, 0x3E, gnss))
    rig.run_to(2_010_000_000)
    return rig.run(0.9)


@pytest.fixture(scope="module")
def standard() -> bytes:
    return epoch_text()


@pytest.mark.parametrize("name", NO_FIX_TABLE)
def test_no_fix_forms_are_those_of_the_fact_sheet(name: str) -> None:
    text, size = NO_FIX_TABLE[name]
    data = epoch_text(fix=False, time_known=False)
    assert line(data, name) == text
    assert len(text) + 2 == size


def test_no_fix_set_lists_gsa_once_per_system_and_empty_gsv_per_talker() -> None:
    printed = lines(epoch_text(fix=False, time_known=False))
    assert printed.count("$GNGSA,A,1,,,,,,,,,,,,,99.99,99.99,99.99*2E") == 2
    assert [text for text in printed if "GSV" in text] == ["$GPGSV,1,1,00*79", "$GLGSV,1,1,00*65"]


def test_time_fields_fill_before_the_position() -> None:
    data = epoch_text(fix=False)
    assert line(data, "RMC").startswith("$GNRMC,092727.00,V,,,,,,,150324,,,N*")
    assert line(data, "GGA").startswith("$GNGGA,092727.00,,,,,0,00,99.99,,,,,,*")
    assert line(data, "GLL").startswith("$GNGLL,,,,,092727.00,V,N*")
    assert line(data, "ZDA").startswith("$GNZDA,092727.00,15,03,2024,00,00*")
    assert line(data, "GST").startswith("$GNGST,092727.00,,,,,,,*")
    assert line(data, "VTG") == "$GNVTG,,,,,,,,,N*2E"


def test_the_fact_sheets_sample_sentences() -> None:
    satellites = [replace(SKY[0], number=n, used=True) for n in range(1, 7)]
    satellites += [replace(SKY[7], number=n, used=True) for n in (65, 66, 67)]
    data = epoch_text(satellites=tuple(satellites), gps_time_ns=EPOCH.gps_time_ns - 2_000_000_000)
    assert line(data, "GGA") == "$GNGGA,092725.00,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,*6E"


def test_the_fact_sheets_slow_rmc_with_a_frozen_course() -> None:
    course, speed = math.radians(271.30), 0.045 * 1852 / 3600
    world = BenchWorld(gps_time_ns=EPOCH.gps_time_ns - 2_000_000_000)
    world.set(velocity_ned=(math.cos(course), math.sin(course), 0.0))
    rig = Rig(world=world)
    rig.run(0.3)
    rig.say(ubx(6, 0x17, bytes((0x20, 0x40, 0, 2, *(0,) * 7, 1, *(0,) * 8))))
    rig.run_to(1_500_000_000)
    world.set(velocity_ned=(speed * math.cos(course), speed * math.sin(course), 0.0))
    text = line(rig.run_to(2_900_000_000), "RMC")
    assert text == "$GNRMC,092725.00,A,5030.12345,N,00415.54321,W,0.045,271.30,150324,,,A*68"


def test_order_of_an_epoch_is_that_of_real_logs(standard: bytes) -> None:
    names = [text[3:6] for text in lines(standard)]
    kept = [name for index, name in enumerate(names) if index == 0 or names[index - 1] != name]
    assert kept == ["RMC", "VTG", "GNS", "GGA", "GSA", "GSV", "GLL", "GST", "ZDA"]


def test_full_fix_set(standard: bytes) -> None:
    printed = lines(standard)
    assert line(standard, "RMC")[:-3] == (
        "$GNRMC,092727.00,A,5030.12345,N,00415.54321,W,9.719,53.13,150324,,,A"
    )
    assert line(standard, "VTG")[:-3] == "$GNVTG,53.13,T,,M,9.719,N,18.000,K,A"
    assert line(standard, "GNS")[:-3] == (
        "$GNGNS,092727.00,5030.12345,N,00415.54321,W,AA,05,0.95,87.4,48.1,,"
    )
    assert line(standard, "GST")[:-3] == "$GNGST,092727.00,1.3,,,,0.85,0.85,2.0"
    assert [text[:-3] for text in printed if "GSA" in text] == [
        "$GNGSA,A,3,01,03,04,11,,,,,,,,,1.56,0.95,1.27",
        "$GNGSA,A,3,67,,,,,,,,,,,,1.56,0.95,1.27",
    ]
    assert [text[:-3] for text in printed if "GSV" in text] == [
        "$GPGSV,2,1,07,01,53,280,36,03,29,301,24,04,55,223,37,08,38,166,16",
        "$GPGSV,2,2,07,11,40,245,29,12,05,034,,46,43,156,",
        "$GLGSV,1,1,02,67,62,349,26,84,01,353,",
    ]


def test_pynmeagps_agrees_with_what_was_meant(standard: bytes) -> None:
    for message in nmea_messages(standard):
        if hasattr(message, "lat"):
            assert message.lat == pytest.approx(math.degrees(EPOCH.latitude), abs=0.5e-5 / 60)
            assert message.lon == pytest.approx(math.degrees(EPOCH.longitude), abs=0.5e-5 / 60)
        if hasattr(message, "time"):
            assert (message.time.hour, message.time.minute, message.time.second) == (9, 27, 27)
        if message.msgID == "GGA":
            assert (message.alt, message.sep, message.quality, message.numSV) == (87.4, 48.1, 1, 5)
        if message.msgID == "RMC":
            assert (message.date.year, message.date.month, message.date.day) == (2024, 3, 15)


def test_every_sentence_keeps_within_82_characters() -> None:
    crowd = tuple(Satellite("BEIDOU", 401 + n, 1.0, 2.0, 45.0, True) for n in range(30))
    crowd += tuple(Satellite("GPS", 1 + n, 1.0, 2.0, 45.0, True) for n in range(30))
    worst = {
        "satellites": crowd,
        "latitude": -1.5,
        "longitude": -3.1,
        "height": 49_999.9,
        "geoid_separation": -106.9,
        "pdop": 200.0,
        "hdop": 200.0,
        "vdop": 200.0,
        "velocity_ned": (499.9, 0.0, 0.0),
    }
    beidou_too = bytes.fromhex("00202002 06080e0000000101 0308100001000101")
    for version in (0x21, 0x23, 0x40, 0x41):
        data = epoch_text(version, {8: 1}, beidou_too, **worst)
        assert max(len(text) + 2 for text in lines(data)) <= 82
        assert nmea_messages(data)


@pytest.mark.parametrize(
    ("version", "rmc", "vtg", "gsa", "gsv", "gns"),
    [
        (0x21, ",150324,,", ",9.719,N,18.000,K", "1.56,0.95,1.27", ",84,01,353,", ",48.1,,"),
        (0x23, ",150324,,,A", ",18.000,K,A", "1.56,0.95,1.27", ",84,01,353,", ",48.1,,"),
        (0x40, ",150324,,,A", ",18.000,K,A", "1.56,0.95,1.27", ",84,01,353,", ",48.1,,"),
        (0x41, ",150324,,,A,V", ",18.000,K,A", "1.56,0.95,1.27,2", ",84,01,353,,0", ",48.1,,,V"),
    ],
)
def test_fields_that_a_version_adds(version: int, rmc: str, vtg: str, gsa: str, gsv: str, gns: str) -> None:
    data = epoch_text(version)
    for name, ending in (("RMC", rmc), ("VTG", vtg), ("GSA", gsa), ("GSV", gsv), ("GNS", gns)):
        assert line(data, name)[:-3].endswith(ending)
    assert (",AANN," if version == 0x41 else ",AA,") in line(data, "GNS")


def test_a_gps_only_receiver_uses_gp_everywhere() -> None:
    data = epoch_text(gnss=bytes.fromhex("00202001 06080e0000000101"))
    assert {text[1:3] for text in lines(data)} == {"GP"}
    assert sum("GSA" in text for text in lines(data)) == 1
    assert line(data, "GGA").split(",")[7] == "04"  # the GLONASS satellite is not used any more


def test_galileo_and_beidou_numbers_depend_on_version_and_numbering() -> None:
    galileo = bytes.fromhex("00202001 0204080001000101")
    beidou = bytes.fromhex("00202002 06080e0000000101 0308100001000101")
    sky = (
        *SKY,
        Satellite("GALILEO", 305, 0.5, 1.0, 40.0, True),
        Satellite("BEIDOU", 411, 0.5, 1.0, 40.0, True),
    )
    assert line(epoch_text(0x40, {8: 0}, galileo, satellites=sky), "GSV")[:-3] == "$GAGSV,1,1,01,,29,057,40"
    assert (
        line(epoch_text(0x40, {8: 1}, galileo, satellites=sky), "GSV")[:-3] == "$GAGSV,1,1,01,305,29,057,40"
    )
    assert (
        line(epoch_text(0x41, {8: 0}, galileo, satellites=sky), "GSV")[:-3] == "$GAGSV,1,1,01,05,29,057,40,0"
    )
    assert line(epoch_text(0x40, {8: 1}, beidou, satellites=sky), "GSV")[:-3] == "$GBGSV,1,1,01,411,29,057,40"
    legacy = {8: 1, 12: ord("B"), 13: ord("D")}
    assert (
        line(epoch_text(0x41, legacy, beidou, satellites=sky), "GSV")[:-3] == "$BDGSV,1,1,01,11,29,057,40,0"
    )


def test_talker_number_limit_and_filters_of_cfg_nmea() -> None:
    assert {text[1:3] for text in lines(epoch_text(nmea={9: 1, 10: 1}))} == {"GP"}
    shown = [text for text in lines(epoch_text(nmea={0: 0x10})) if "GSV" in text]
    assert shown[-1].startswith("$GLGSV,1,1,00") or all(text.startswith("$GPGSV") for text in shown)
    many = tuple(replace(SKY[0], number=n) for n in range(1, 15))
    assert sum("GPGSV" in text for text in lines(epoch_text(nmea={2: 8}, satellites=many))) == 2


def test_high_precision_mode_and_its_limit() -> None:
    assert ",5030.1234500,N,00415.5432100,W," in line(epoch_text(nmea={3: 0x0A}), "RMC")
    assert ",87.400,M," in line(epoch_text(nmea={3: 0x0A}), "GGA")
    assert ",5030.12345,N," in line(epoch_text(nmea={3: 0x0E}), "RMC")


def position_fields(latitude_deg: float, longitude_deg: float) -> str:
    text = line(epoch_text(latitude=math.radians(latitude_deg), longitude=math.radians(longitude_deg)), "GLL")
    return ",".join(text.split(",")[1:5])


@pytest.mark.parametrize(
    ("latitude", "longitude", "printed"),
    [
        (59.9999999999, 29.99999999999, "6000.00000,N,03000.00000,E"),  # 59.999999994 minutes carry
        (-12.9999999999, -179.9999999999, "1300.00000,S,18000.00000,W"),
        (-1e-12, -1e-12, "0000.00000,N,00000.00000,E"),  # never −0.0
        (-1.2e-7, 1.2e-7, "0000.00001,S,00000.00001,E"),
        (90.0, 180.0, "9000.00000,N,18000.00000,E"),
        (-90.0, -180.0, "9000.00000,S,18000.00000,W"),
        (89.99999999, 0.0, "9000.00000,N,00000.00000,E"),
        (10.0, 190.0, "1000.00000,N,17000.00000,W"),  # a longitude beyond ±180°
    ],
)
def test_rounding_traps_of_positions(latitude: float, longitude: float, printed: str) -> None:
    assert position_fields(latitude, longitude) == printed


def test_rounding_traps_of_other_fields() -> None:
    almost_north = math.radians(359.9960001)
    top = replace(SKY[0], elevation=math.radians(89.6), azimuth=math.radians(359.6), cn0_dbhz=99.7)
    data = epoch_text(
        velocity_ned=(5 * math.cos(almost_north), 5 * math.sin(almost_north), 0.0),
        height=-0.04,
        geoid_separation=0.0,
        satellites=(top,) * 4,
    )
    assert line(data, "VTG").startswith("$GNVTG,0.00,T,")
    assert ",0.0,M,0.0,M,,*" in line(data, "GGA")
    assert ",01,90,000,99" in next(text for text in lines(data) if "GPGSV" in text)


def test_negative_and_large_heights() -> None:
    assert ",-422.6,M,18.9,M," in line(epoch_text(height=-403.65, geoid_separation=18.9), "GGA")
    assert ",49951.9,M,48.1,M," in line(epoch_text(height=50_000.0), "GGA")


@pytest.mark.parametrize(
    ("speed", "s_acc", "printed"),
    [(0.05, 0.01, False), (0.11, 0.05, True), (0.3, 0.5, False), (1.0, 0.2, True)],
)
def test_course_is_empty_at_low_speed(speed: float, s_acc: float, printed: bool) -> None:
    data = epoch_text(velocity_ned=(0.0, speed, 0.0), s_acc=s_acc)
    assert ("90.00" in line(data, "RMC")) is printed
    assert line(data, "VTG").startswith("$GNVTG,90.00,T,,M," if printed else "$GNVTG,,T,,M,")


def test_date_rolls_over_with_the_leap_seconds_taken_into_account() -> None:
    new_year_utc = 2295 * 604_800 + 0 * 86_400 + 18  # 2024-01-01 00:00:00 UTC is a Monday
    gps_s = new_year_utc + 86_400
    data = epoch_text(gps_time_ns=(gps_s - 2) * 1_000_000_000 - 1)
    assert line(data, "ZDA").startswith("$GNZDA,000000.00,01,01,2024")
    earlier = epoch_text(gps_time_ns=(gps_s - 3) * 1_000_000_000)
    assert line(earlier, "ZDA").startswith("$GNZDA,235959.00,31,12,2023")


def test_more_than_twelve_used_satellites() -> None:
    many = tuple(replace(SKY[0], number=n) for n in range(1, 15))
    data = epoch_text(satellites=many)
    assert line(data, "GGA").split(",")[7] == "12"
    assert line(data, "GNS").split(",")[7] == "14"
    slots = next(text for text in lines(data) if "GSA" in text).split(",")[3:15]
    assert slots == [f"{n:02d}" for n in range(1, 13)]


def test_two_dimensional_fix_with_three_satellites() -> None:
    data = epoch_text(satellites=SKY[:3])
    assert line(data, "GSA").startswith("$GNGSA,A,2,")
    assert line(data, "RMC").split(",")[2] == "A"


def test_satellites_are_printed_anew_when_anything_about_them_changes() -> None:
    """Their sentences are kept from epoch to epoch; no epoch may show an older one's."""
    world = BenchWorld()
    rig = Rig(world=world)
    rig.run(2.9)
    weaker = tuple(replace(satellite, cn0_dbhz=20.0) for satellite in SKY)
    same = lines(rig.run(1.0))
    kept = [text for text in same if "GSA" in text or "GSV" in text]
    assert kept == [text for text in lines(rig.run(1.0)) if "GSA" in text or "GSV" in text]
    for changes, shown in (
        ({"hdop": 1.11}, "$GNGSA,A,3,01,03,04,11,,,,,,,,,1.56,1.11,1.27"),
        ({"satellites": weaker}, "$GPGSV,2,1,07,01,53,280,20,03,29,301,20,04,55,223,20,08,38,166,20"),
        ({"fix": False}, "$GNGSA,A,1,,,,,,,,,,,,,99.99,99.99,99.99"),
        (
            {"fix": True, "satellites": SKY},
            "$GPGSV,2,1,07,01,53,280,36,03,29,301,24,04,55,223,37,08,38,166,16",
        ),
    ):
        world.set(**changes)
        assert shown in [text[:-3] for text in lines(rig.run(1.0))]
    rig.say(ubx(6, 0x17, bytes((0, 0x41, 0, 2, *bytes(16)))))  # NMEA 4.1: GSA and GSV have a field more
    printed = lines(rig.run(1.0)[10:])  # behind the acknowledgement
    assert "$GNGSA,A,3,01,03,04,11,,,,,,,,,1.56,1.11,1.27,1" in [text[:-3] for text in printed]


def test_every_line_has_the_shape_of_a_sentence(standard: bytes) -> None:
    for text in lines(standard):
        assert re.fullmatch(r"\$G[NPL][A-Z]{3},[ -)+-~]*\*[0-9A-F]{2}", text)
