"""Our own sentences: read back by pynmeagps and by our receiver's parser."""

import datetime

import pynmeagps
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from firmware.drivers.gnss_epoch import as_dict
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.link.nmea_output import NmeaWriter, OwnFix, Validity

DAY_ZERO = datetime.date(1980, 1, 6)
FIX = OwnFix(
    validity=Validity.GNSS,
    time_of_day_ms=34_045_120,
    date_days=16_140,
    lat_nanodeg=50_502_057_500,
    lon_nanodeg=-4_259_053_500,
    height_mm=135_500,
    separation_mm=48_100,
    speed_mmps=10_000,
    course_centideg=27_130,
    heading_centideg=35_999,
    roll_centideg=-123,
    pitch_centideg=56,
    roll_sigma_mdeg=20,
    pitch_sigma_mdeg=21,
    heading_sigma_mdeg=1234,
    satellites=9,
    hdop_centi=95,
)


def parsed_by_receiver(data: bytes) -> dict[str, int]:
    stream = ReceiverStream()
    stream.ring[: len(data)] = data
    while stream.take(len(data), 10**9):
        return as_dict(stream.epoch)
    assert stream.take(len(data), 2 * 10**9)
    return as_dict(stream.epoch)


def test_sentences_by_hand():
    writer = NmeaWriter()
    assert writer.gga(FIX)[:-5] == b"$INGGA,092725.12,5030.123450,N,00415.543210,W,1,09,0.95,87.4,M,48.1,M,,"
    assert writer.rmc(FIX)[:-5] == b"$INRMC,092725.12,A,5030.123450,N,00415.543210,W,19.438,271.30,150324,,,A"
    assert writer.vtg(FIX)[:-5] == b"$INVTG,271.30,T,,M,19.438,N,36.000,K,A"
    assert writer.hdt(FIX)[:-5] == b"$INHDT,359.99,T"
    assert writer.pashr(FIX)[:-5] == b"$PASHR,092725.12,359.99,T,-1.23,+0.56,,0.020,0.021,1.234,1,4"


@settings(max_examples=150, deadline=None)
@given(
    some.integers(-90 * 10**9, 90 * 10**9),
    some.integers(-180 * 10**9, 180 * 10**9),
    some.integers(0, 86_399_999),
    some.integers(0, 43_800),
    some.integers(0, 300_000),
    some.one_of(some.none(), some.integers(0, 36_000)),
    some.integers(-400_000, 9_000_000),
    some.integers(-110_000, 90_000),
)
def test_pynmeagps_reads_the_same(lat, lon, time_ms, days, speed, course, height, separation):
    fix = FIX._replace(
        lat_nanodeg=lat, lon_nanodeg=lon, time_of_day_ms=time_ms, date_days=days, speed_mmps=speed,
        course_centideg=course, height_mm=height, separation_mm=separation,
    )  # fmt: skip
    writer = NmeaWriter("GN")
    sentences = [writer.gga(fix), writer.rmc(fix), writer.vtg(fix), writer.hdt(fix)]
    assert all(len(sentence) <= 82 for sentence in sentences)
    gga, rmc, vtg, hdt = map(pynmeagps.NMEAReader.parse, sentences)
    for told in (gga, rmc):
        assert told.lat == pytest.approx(lat * 1e-9, abs=0.51e-6 / 60)
        assert told.lon == pytest.approx(lon * 1e-9, abs=0.51e-6 / 60)
        hundredths = told.time.hour * 360_000 + told.time.minute * 6000 + told.time.second * 100
        assert hundredths + told.time.microsecond // 10_000 == time_ms // 10
    assert gga.alt == pytest.approx((height - separation) / 1000, abs=0.0501)
    assert gga.sep == pytest.approx(separation / 1000, abs=0.0501)
    assert rmc.spd == vtg.sogn == pytest.approx(speed * 3.6 / 1852, abs=0.000501)
    assert vtg.sogk == pytest.approx(speed * 3.6e-3, abs=0.000501)
    if days < 36_500:  # two digits of the year say no more
        expected = DAY_ZERO + datetime.timedelta(days)
        assert (rmc.date.year % 100, rmc.date.month, rmc.date.day) == (
            expected.year % 100, expected.month, expected.day,
        )  # fmt: skip
    assert (vtg.cogt == "") == (course is None)
    assert hdt.headingT == 359.99


@settings(max_examples=60, deadline=None)
@given(some.integers(-90 * 10**9, 90 * 10**9), some.integers(-180 * 10**9, 180 * 10**9))
def test_our_own_parser_reads_the_same(lat, lon):
    writer = NmeaWriter()
    epoch = parsed_by_receiver(writer.gga(FIX._replace(lat_nanodeg=lat, lon_nanodeg=lon)) + writer.rmc(FIX))
    assert epoch["height_mm"] == 135_500
    assert epoch["date_days"] == 16_140
    told = parsed_by_receiver(writer.gga(FIX._replace(lat_nanodeg=lat, lon_nanodeg=lon)))
    assert abs(told["lat_nanodeg"] - lat) <= 9
    assert abs(told["lon_nanodeg"] - lon) <= 9


def test_rounding_carries_into_degrees():
    fix = FIX._replace(lat_nanodeg=49_999_999_999, lon_nanodeg=-1)
    assert b",5000.000000,N,00000.000000,W," in NmeaWriter().gga(fix)


def test_no_minus_zero():
    fix = FIX._replace(height_mm=48_080, roll_centideg=0)
    assert b",0.0,M," in NmeaWriter().gga(fix)
    assert b",+0.00,+0.56," in NmeaWriter().pashr(fix)


@pytest.mark.parametrize("kind", ["gga", "rmc", "vtg", "hdt", "pashr"])
@pytest.mark.parametrize("validity", list(Validity))
def test_the_longest_sentences_keep_to_82_characters(kind, validity):
    longest = OwnFix(
        validity=validity,
        time_of_day_ms=86_399_999,
        date_days=40_000,
        lat_nanodeg=-89_999_999_999,
        lon_nanodeg=-179_999_999_999,
        height_mm=-9_999_000,
        separation_mm=-109_900,
        speed_mmps=2_058_000,
        course_centideg=35_999,
        heading_centideg=35_999,
        roll_centideg=-17_999,
        pitch_centideg=-9_000,
        roll_sigma_mdeg=10**6,
        pitch_sigma_mdeg=10**6,
        heading_sigma_mdeg=10**6,
        satellites=120,
        hdop_centi=20_000,
    )
    sentence = getattr(NmeaWriter(), kind)(longest)
    assert len(sentence) <= 82
    assert pynmeagps.NMEAReader.parse(sentence).identity


def test_without_a_solution_nothing_is_claimed():
    writer, none = NmeaWriter("GN"), FIX._replace(validity=Validity.NONE, time_of_day_ms=None, date_days=None)
    assert writer.gga(none)[:-5] == b"$GNGGA,,,,,,0,09,99.99,,,,,,"
    assert writer.rmc(none) == b"$GNRMC,,V,,,,,,,,,,N*4D\r\n"
    assert writer.hdt(none)[:-5] == b"$GNHDT,,T"
    assert parsed_by_receiver(writer.gga(none) + writer.rmc(none) + writer.vtg(none))["flags"] == 0


def test_dead_reckoning_says_so():
    writer, fix = NmeaWriter(), FIX._replace(validity=Validity.DEAD_RECKONING)
    assert b",W,6," in writer.gga(fix)
    assert writer.rmc(fix)[-6:-5] == b"E"


def test_talkers():
    for talker in ("I", "INS", "in", "é1"):
        with pytest.raises(ValueError, match="must be two capital letters"):
            NmeaWriter(talker)
