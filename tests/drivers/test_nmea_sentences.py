"""Sentences with values written down by hand, from the fact sheet's field tables."""

import datetime

import pytest
from receiver_line import ReceiverLine, epoch_of, epochs_of, sentence

from firmware.drivers import gnss_epoch as ge

GGA = "GNGGA,092725.00,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,"
RMC = "GNRMC,092725.00,A,5030.12345,N,00415.54321,W,0.045,271.30,150324,,,A"
PUBX = (
    "PUBX,00,092725.50,5030.12345,S,00415.54321,E,-135.123,D3,2.1,3.45,36.000,30.00,-0.250,"
    ",0.92,1.19,0.77,9,0,0"
)


def days(year: int, month: int, day: int) -> int:
    return (datetime.date(year, month, day) - datetime.date(1980, 1, 6)).days


def test_fact_sheet_samples_have_the_checksums_of_the_fact_sheet():
    assert sentence(GGA).endswith(b"*6E\r\n")
    assert sentence(RMC).endswith(b"*68\r\n")


def test_gga():
    epoch = epoch_of(GGA)
    assert epoch["time_of_day_ms"] == ((9 * 60 + 27) * 60 + 25) * 1000
    assert epoch["lat_nanodeg"] == 50_502_057_500  # 50 + 30.12345/60
    assert epoch["lon_nanodeg"] == -4_259_053_500  # 4 + 15.54321/60
    assert (epoch["fix_quality"], epoch["satellites"], epoch["hdop_centi"]) == (1, 9, 95)
    assert (epoch["height_msl_mm"], epoch["height_mm"]) == (87_400, 135_500)
    assert epoch["flags"] == ge.HAS_TIME | ge.HAS_POSITION | ge.HAS_HEIGHT | ge.HAS_HEIGHT_MSL


def test_rmc():
    epoch = epoch_of(RMC)
    assert epoch["date_days"] == days(2024, 3, 15)
    assert epoch["speed_mmps"] == 23  # 0.045 kn · 1852/3.6
    assert epoch["course_e5deg"] == 27_130_000
    expected = ge.HAS_TIME | ge.HAS_DATE | ge.HAS_POSITION | ge.HAS_SPEED | ge.HAS_COURSE
    assert epoch["flags"] == expected


def test_pubx_00_gives_a_whole_velocity():
    epoch = epoch_of(PUBX)
    assert epoch["lat_nanodeg"] == -50_502_057_500
    assert epoch["height_mm"] == -135_123
    # 36 km/h = 10 m/s towards 30°
    assert (epoch["vel_n_mmps"], epoch["vel_e_mmps"], epoch["vel_d_mmps"]) == (8660, 5000, -250)
    assert (epoch["h_acc_mm"], epoch["v_acc_mm"], epoch["s_acc_mmps"]) == (2100, 3450, 0)
    assert (epoch["fix_quality"], epoch["fix_type"], epoch["satellites"]) == (2, 3, 9)
    assert (epoch["hdop_centi"], epoch["vdop_centi"]) == (92, 119)
    assert epoch["flags"] & (ge.HAS_VELOCITY | ge.HAS_ACCURACY | ge.HAS_HEIGHT) == (
        ge.HAS_VELOCITY | ge.HAS_ACCURACY | ge.HAS_HEIGHT
    )
    assert not epoch["flags"] & ge.HAS_HEIGHT_MSL


@pytest.mark.parametrize(
    ("course", "north", "east"),
    [("0.00", 10000, 0), ("90.00", 0, 10000), ("180.00", -10000, 0), ("270.00", 0, -10000),
     ("360.00", 10000, 0), ("225.00", -7071, -7071), ("359.99", 10000, -2)],
)  # fmt: skip
def test_pubx_00_courses(course, north, east):
    epoch = epoch_of(PUBX.replace("36.000,30.00", f"36.000,{course}"))
    assert (epoch["vel_n_mmps"], epoch["vel_e_mmps"]) == (north, east)
    assert 0 <= epoch["course_e5deg"] < 36_000_000


def test_vtg_prefers_knots_and_falls_back_to_kilometres_per_hour():
    assert epoch_of("GPVTG,054.70,T,034.40,M,005.500,N,010.200,K,A")["speed_mmps"] == 2829
    assert epoch_of("GPVTG,054.70,T,034.40,M,,N,036.000,K,A")["speed_mmps"] == 10_000
    assert epoch_of("GPVTG,054.70,T,034.40,M,005.500,N,010.200,K")["course_e5deg"] == 5_470_000


def test_an_empty_course_is_no_course():
    rmc = "GNRMC,171926.00,A,4404.14063,N,12118.85478,W,0.117,,180315,,,A"
    epoch = epoch_of(rmc, "GNVTG,,T,,M,0.117,N,0.216,K,A")
    assert epoch["flags"] & ge.HAS_SPEED
    assert not epoch["flags"] & ge.HAS_COURSE
    assert epoch["speed_mmps"] == 60


def test_gns_needs_one_valid_mode():
    gns = "GNGNS,092725.00,5030.12345,N,00415.54321,W,{},09,0.95,87.4,48.1,,"
    assert epoch_of(gns.format("AN"))["fix_quality"] == 1
    assert epoch_of(gns.format("DA"))["fix_quality"] == 2
    assert epoch_of(gns.format("FR"))["fix_quality"] == 4
    assert epoch_of(gns.format("AN"))["height_mm"] == 135_500
    assert not epoch_of(gns.format("NN"))["flags"] & ge.HAS_POSITION
    assert not epoch_of(gns.format(""))["flags"] & ge.HAS_POSITION


def test_gsa_gst_zda():
    epoch = epoch_of(
        GGA,
        "GNGSA,A,3,01,11,31,14,22,32,04,25,03,,,,1.56,0.95,1.27",
        "GNGSA,A,1,67,83,,,,,,,,,,,1.56,0.95,1.27",
        "GPGST,092725.00,22,,,,3.0,4.0,12.5",
        "GPZDA,092725.00,29,02,2024,00,00",
    )
    assert (epoch["pdop_centi"], epoch["hdop_centi"], epoch["vdop_centi"]) == (156, 95, 127)
    assert epoch["fix_type"] == 3
    assert (epoch["h_acc_mm"], epoch["v_acc_mm"]) == (5000, 12_500)
    assert epoch["date_days"] == days(2024, 2, 29)


def test_headings():
    epoch = epoch_of("GPHDT,123.456,T")
    assert (epoch["heading_e5deg"], epoch["flags"]) == (12_345_600, ge.HAS_HEADING)
    assert epoch_of("GPTHS,359.9,A")["heading_e5deg"] == 35_990_000
    assert epoch_of("GPTHS,359.9,E")["flags"] == 0
    assert epoch_of("GPTHS,,V")["flags"] == 0
    assert epoch_of("GPHDT,,T")["flags"] == 0


@pytest.mark.parametrize(
    "body",
    [
        "GNRMC,,V,,,,,,,,,,N",
        "GNVTG,,,,,,,,,N",
        "GNGGA,,,,,,0,00,99.99,,,,,,",
        "GNGSA,A,1,,,,,,,,,,,,,99.99,99.99,99.99",
        "GNGLL,,,,,,V,N",
        "GNZDA,,,,,00,00",
        "GNGNS,,,,,,NN,00,99.99,,,,",
        "GNGST,,,,,,,,",
    ],
)
def test_the_no_fix_forms_are_good_sentences_without_a_fix(body):
    line = ReceiverLine()
    line.send(sentence(body))
    line.silence()
    assert line.stream.statistics().sentences == 1
    assert [epoch["flags"] for epoch in line.epochs] == [0]


def test_time_is_known_before_the_position():
    epoch = epoch_of("GNRMC,235959.99,V,,,,,,,311224,,,N", "GNGGA,235959.99,,,,,0,00,99.99,,,,,,")
    assert epoch["flags"] == ge.HAS_TIME | ge.HAS_DATE
    assert epoch["time_of_day_ms"] == 86_399_990


@pytest.mark.parametrize(
    ("body", "quality"),
    [(GGA.replace(",W,1,", ",W,6,"), 6), (RMC[:-1] + "E", 0), (RMC.replace(",A,5", ",V,5"), 0)],
)
def test_dead_reckoning_and_warnings_are_no_fix(body, quality):
    epoch = epoch_of(body)
    assert epoch["fix_quality"] == quality
    assert not epoch["flags"] & (ge.HAS_POSITION | ge.HAS_HEIGHT | ge.HAS_SPEED | ge.HAS_VELOCITY)


def test_one_message_without_fix_is_enough():
    epoch = epoch_of(GGA, RMC.replace(",A,5", ",V,5"))
    assert epoch["flags"] == ge.HAS_TIME | ge.HAS_DATE


def test_a_two_dimensional_fix_has_no_height():
    epoch = epoch_of(GGA, "GNGSA,A,2,01,11,31,,,,,,,,,,5.0,4.0,3.0")
    assert epoch["flags"] == ge.HAS_TIME | ge.HAS_POSITION
    assert not epoch_of(PUBX.replace("D3", "G2"))["flags"] & (ge.HAS_HEIGHT | ge.HAS_VELOCITY)


def test_no_geoid_separation_no_ellipsoid_height():
    epoch = epoch_of("GPGGA,204132.10,4205.733715,N,08802.040978,W,2,08,1.0,221.921,M,,,3,0138")
    assert epoch["flags"] == ge.HAS_TIME | ge.HAS_POSITION | ge.HAS_HEIGHT_MSL
    assert epoch["height_msl_mm"] == 221_921


@pytest.mark.parametrize(
    "body",
    [
        GGA.replace("5030.", "9030."),  # beyond the pole
        GGA.replace("5030.", "5060."),  # 60 minutes
        GGA.replace("5030.", "530."),  # too few digits
        GGA.replace("00415.", "18015."),
        GGA.replace(",N,", ",E,"),
        GGA.replace(",N,", ",NN,"),
        GGA.replace(",N,", ",,"),
        GGA.replace(",W,", ",w,"),
        GGA.replace("30.12345", "30.1x345"),
        GGA.replace("5030", "-5030"),
        GGA.replace("092725", "242725"),
        GGA.replace("092725", "096025"),
        GGA.replace("092725", "092760"),
        GGA.replace("092725.00", "92725.00"),
        GGA.replace("87.4", "87.4.1"),
        GGA.replace("87.4", "--87.4"),
        GGA.replace("87.4", "-"),
        GGA.replace("87.4", "."),
        GGA.replace("0.95", "-0.95"),
        GGA.replace(",09,", ",0x9,"),
        RMC.replace("150324", "300224"),
        RMC.replace("150324", "15032"),
        RMC.replace("150324", "150024"),
        RMC.replace("271.30", "360.01"),
        RMC.replace("0.045", "99999.0"),
        RMC.replace("0.045", "-1.0"),
        RMC.replace(",A,5", ",X,5"),
        "GPHDT,361.0,T",
        "GPHDT,10.0,M",
        "GPZDA,092725.00,32,01,2024,00,00",
        "GPGSV,1,2,02,01,53,280,36",
        "GPGSV,1,1,01,01,5x,280,36",
        PUBX.replace("D3", "XX"),
    ],
)  # fmt: skip
def test_a_field_that_is_not_what_it_should_be_spoils_its_sentence_only(body):
    line = ReceiverLine()
    line.send(sentence(body) + sentence("GNGLL,0000.00000,N,00000.00000,E,111111.00,A,A"))
    line.silence()
    assert line.stream.statistics().malformed == 1
    (epoch,) = line.epochs
    assert epoch["time_of_day_ms"] == ((11 * 60 + 11) * 60 + 11) * 1000
    assert (epoch["lat_nanodeg"], epoch["height_mm"], epoch["speed_mmps"], epoch["heading_e5deg"]) == (
        0,
        0,
        0,
        0,
    )


def test_a_leap_second_is_a_time():
    assert epoch_of(GGA.replace("092725.00", "235960.50"))["time_of_day_ms"] == 86_400_500


def test_missing_fields_read_as_empty():
    assert epoch_of("GPGGA,092725,5030.12345,N,00415.54321,W,1")["flags"] == ge.HAS_TIME | ge.HAS_POSITION
    assert epoch_of("GPRMC,092725,A,5030.12345,N,00415.54321,W")["flags"] == ge.HAS_TIME | ge.HAS_POSITION


def test_leap_seconds_come_with_pubx_04_once_they_are_received():
    line = ReceiverLine()
    line.send(sentence("PUBX,04,073731.00,091202,113851.00,1196,15D,1930035,-2660.664,43"))
    line.send(sentence(GGA))
    line.silence()
    line.send(sentence("PUBX,04,073731.00,091202,113851.00,1196,18,1930035,-2660.664,43"))
    line.send(sentence(GGA.replace("25.00", "26.00")))
    line.silence()
    assert [epoch["leap_seconds"] for epoch in line.epochs] == [0, 18]


def test_talkers_do_not_matter():
    for talker in ("GP", "GN", "GL", "GA", "GB", "IN", "II"):
        assert epoch_of(talker + GGA[2:])["lat_nanodeg"] == 50_502_057_500


def test_sentences_longer_than_82_characters_are_read():
    long = "GPGGA,092725.000000,5030.123456789,N,00415.543219876,W,1,09,0.95,87.40000,M,48.10000,M,,0000"
    assert len(sentence(long)) > 82
    assert epoch_of(long)["lat_nanodeg"] == 50_502_057_613
    assert epochs_of(sentence("GPTXT," + "x" * 300)) == []
