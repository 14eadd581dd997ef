"""The same bytes give the same epochs however they are cut; garbage is counted and does no harm."""

from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as some
from receiver_line import ReceiverLine, epoch_of, sentence

from firmware.drivers import gnss_epoch as ge
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.ubx import frame

GGA = sentence("GNGGA,092725.00,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,")
RMC = sentence("GNRMC,092725.00,A,5030.12345,N,00415.54321,W,0.045,271.30,150324,,,A")
GSV = sentence("GPGSV,1,1,02,01,53,280,36,03,29,301,")
NEXT = sentence("GNGGA,092726.00,5030.12346,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,")
ACK = frame(0x0501, b"\x06\x08")
PVT = frame(0x0107, bytes(92))

pieces = some.one_of(
    some.sampled_from(
        [GGA, RMC, GSV, NEXT, ACK, PVT, b"\xb5\x62", b"\xb5", b"$", b"\xb5\x62\x01\x07\xff\xff"]
    ),
    some.binary(max_size=20),
    some.sampled_from([GGA, ACK, PVT]).flatmap(
        lambda whole: some.integers(0, len(whole)).map(lambda n: whole[:n])
    ),
)
streams = some.lists(pieces, max_size=12).map(b"".join)


def outcome(line: ReceiverLine) -> tuple[object, ...]:
    return line.epochs, line.stream.statistics(), line.stream.satellites()


@settings(max_examples=60, deadline=None)
@given(streams, some.lists(some.integers(1, 90), min_size=1, max_size=8))
def test_chunks_do_not_matter(data, sizes):
    whole = ReceiverLine()
    for start in range(0, len(data), 400):
        whole.chunks([data[start : start + 400]])
    whole.silence()
    cut = ReceiverLine()
    position = turn = 0
    while position < len(data):
        size = sizes[turn % len(sizes)]
        cut.chunks([data[position : position + size]])
        position += size
        turn += 1
    cut.silence()
    assert outcome(cut) == outcome(whole)


@settings(max_examples=60, deadline=None)
@given(some.binary(max_size=1500))
def test_random_bytes_do_no_harm(data):
    line = ReceiverLine()
    line.send(data)
    line.silence()
    line.send(b"\r\n" + RMC)
    line.silence()
    assert line.epochs[-1]["lat_nanodeg"] == 50_502_057_500


@settings(max_examples=40, deadline=None)
@given(some.sampled_from([GGA, RMC]), some.integers(0, 70), some.integers(1, 255))
def test_one_wrong_byte_spoils_a_sentence(text, position, flip):
    spoilt = bytearray(text)
    if position >= len(text) - 2:
        return
    spoilt[position] ^= flip
    line = ReceiverLine()
    line.send(bytes(spoilt))
    line.silence()
    same = position >= len(text) - 4 and spoilt.upper() == text  # the case of checksum digits is free
    assert (len(line.epochs) == 1) == same or b"$" in spoilt[1:]


@settings(max_examples=150, deadline=None)
@given(
    some.integers(0, 89),
    some.integers(0, 179),
    some.integers(0, 10**9 * 60 - 1),
    some.integers(0, 9),
    some.booleans(),
)
def test_positions_are_exact_to_the_last_printed_digit(lat_deg, lon_deg, nanominutes, decimals, negative):
    printed = nanominutes // 10 ** (9 - decimals) * 10 ** (9 - decimals)
    whole, fraction = divmod(printed, 10**9)
    minutes = f"{whole:02d}" + (f".{fraction:09d}"[: decimals + 1] if decimals else "")
    north, east = ("S", "W") if negative else ("N", "E")
    epoch = epoch_of(
        f"GPGGA,092725,{lat_deg:02d}{minutes},{north},{lon_deg:03d}{minutes},{east},1,4,,,M,,M,,"
    )
    sign = -1 if negative else 1
    for degrees, field in ((lat_deg, "lat_nanodeg"), (lon_deg, "lon_nanodeg")):
        exact = sign * (degrees * 10**9 + Fraction(printed, 60))
        assert abs(epoch[field] - exact) <= Fraction(1, 2)


@settings(max_examples=100, deadline=None)
@given(some.decimals(min_value=-9999, max_value=20000, places=3), some.decimals(0, 1500, places=3))
def test_heights_and_speeds_are_rounded_to_the_nearest_unit(height, knots):
    epoch = epoch_of(
        f"GPGGA,092725,5030.1,N,00415.5,W,1,4,,{height},M,0.0,M,,", f"GPVTG,1.0,T,,M,{knots},N,,K,A"
    )
    assert epoch["height_mm"] == Fraction(height) * 1000
    assert abs(epoch["speed_mmps"] - Fraction(knots) * 1852000 / 3600) <= Fraction(1, 2)


def test_lower_case_checksums_are_read():
    line = ReceiverLine()
    line.send(GGA.replace(b"*6E", b"*6e"))
    line.silence()
    assert len(line.epochs) == 1


def test_what_was_heard_is_counted():
    line = ReceiverLine(ReceiverStream())
    line.send(GGA + RMC.replace(b"*68", b"*69") + b"$GPGGA,1234$" + b"$" + b"x" * 300 + b"\r\n")
    line.send(sentence("PGRME,1,2,3") + sentence("GPGRS,092725.00") + b"garbage")
    line.send(sentence("GPTXT,01,01,02,u-blox AG") + ACK + PVT[:-1] + b"\x00" + frame(0x0120, bytes(15)))
    line.silence()
    heard = line.stream.statistics()
    assert heard.sentences == 2
    assert heard.frames == 1
    assert heard.bad_checksums == 2
    assert heard.truncated == 2
    assert heard.overlong == 1
    assert heard.unknown == 3
    assert heard.garbage >= len(b"garbage")


def test_a_frame_that_is_cut_off_gives_back_what_it_had_swallowed():
    line = ReceiverLine()
    line.send(b"\xb5\x62\x01\x07\x00\x03" + GGA)  # 768 bytes announced, a sentence comes
    assert line.epochs == []
    line.silence()
    (epoch,) = line.epochs
    assert epoch["lat_nanodeg"] == 50_502_057_500
    assert epoch["burst_start_ns"] == 0


def test_nmea_within_the_payload_of_a_frame_is_payload():
    line = ReceiverLine()
    line.send(frame(0x0A04, GGA) + NEXT)
    line.silence()
    (epoch,) = line.epochs
    assert epoch["time_of_day_ms"] % 60_000 == 26_000
    assert epoch["flags"] & ge.HAS_POSITION
