"""When an epoch is complete, what belongs to it, and when its burst began and ended on the board's clock."""

import pytest
from receiver_line import ReceiverLine, sentence

from firmware.drivers import gnss_epoch as ge
from firmware.drivers import receiver_state as st
from firmware.drivers.receiver_stream import ReceiverStream

SECOND = 1_000_000_000


def burst(second: int, fraction: str = "00") -> bytes:
    time = f"0927{second:02d}.{fraction}"
    return (
        sentence(f"GNRMC,{time},A,5030.12345,N,00415.54321,W,0.045,271.30,150324,,,A")
        + sentence("GNVTG,271.30,T,,M,0.045,N,0.083,K,A")
        + sentence(f"GNGGA,{time},5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,")
        + sentence("GNGSA,A,3,01,11,31,,,,,,,,,,1.56,0.95,1.27")
        + sentence(f"GNGLL,5030.12345,N,00415.54321,W,{time},A,A")
    )


def times(line: ReceiverLine) -> list[int]:
    return [epoch["time_of_day_ms"] % 60_000 for epoch in line.epochs]


def test_another_time_of_day_completes_an_epoch():
    line = ReceiverLine()
    line.chunks([burst(25) + burst(26) + burst(27)])
    assert times(line) == [25_000, 26_000]
    assert all(epoch["fix_type"] == 3 and epoch["speed_mmps"] == 23 for epoch in line.epochs)


def test_a_silence_completes_an_epoch():
    line = ReceiverLine()
    line.send(burst(25))
    assert line.epochs == []
    line.silence(30_000_000)
    assert times(line) == [25_000]
    line.silence()
    assert len(line.epochs) == 1


def test_the_next_burst_completes_an_epoch_when_nobody_looked_at_the_silence():
    line = ReceiverLine()
    line.send(burst(25), SECOND)
    line.send(burst(26)[:10], 2 * SECOND)
    assert times(line) == [25_000]


def test_the_last_message_completes_an_epoch_at_once():
    line = ReceiverLine(ReceiverStream(last_message=st.GLL))
    line.send(burst(25))
    assert times(line) == [25_000]
    line.silence()
    line.send(burst(26))
    assert times(line) == [25_000, 26_000]


def test_what_comes_late_for_an_epoch_given_out_makes_no_second_one():
    line = ReceiverLine(ReceiverStream(last_message=st.GGA))
    line.send(burst(25))
    line.silence()
    assert times(line) == [25_000]
    line.send(burst(26))
    line.silence()
    assert times(line) == [25_000, 26_000]


def test_cold_epochs_without_any_time_are_told_apart_by_repetition():
    cold = (
        sentence("GNRMC,,V,,,,,,,,,,N")
        + sentence("GNVTG,,,,,,,,,N")
        + sentence("GNGGA,,,,,,0,00,99.99,,,,,,")
    )
    line = ReceiverLine()
    line.chunks([cold * 3])
    line.silence()
    assert [epoch["flags"] for epoch in line.epochs] == [0, 0, 0]


def test_hundredths_and_nanoseconds_are_one_epoch():
    line = ReceiverLine()
    line.send(
        sentence("GNGGA,235959.99,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,")
        + sentence("GNRMC,000000.00,A,5030.12345,N,00415.54321,W,0.045,271.30,150324,,,A")
    )
    line.silence()
    assert len(line.epochs) == 1


@pytest.mark.parametrize(
    "fractions", [("00", "20", "40", "60", "80"), ("00", "10", "20"), ("00", "05", "10")]
)
def test_fast_receivers(fractions):
    line = ReceiverLine(ReceiverStream(baud=115200))
    line.chunks([burst(25, fraction) for fraction in fractions])
    line.silence()
    assert times(line) == [25_000 + 10 * int(fraction) for fraction in fractions]


def test_burst_times_follow_from_the_wire():
    line = ReceiverLine(ReceiverStream(baud=9600))
    byte_ns = 10 * SECOND // 9600
    text = burst(25)
    line.send(text, 5 * SECOND)
    line.silence()
    line.send(b"\x00" + burst(26), 6 * SECOND)
    line.silence()
    first, second = line.epochs
    assert first["burst_start_ns"] == 5 * SECOND
    # the last message ends two bytes (CR LF) before the burst
    assert first["burst_end_ns"] == 5 * SECOND + (len(text) - 2) * byte_ns
    # whatever the first byte of a burst is: it began there
    assert second["burst_start_ns"] == 6 * SECOND


def test_an_epoch_within_a_burst_begins_with_its_first_message():
    line = ReceiverLine(ReceiverStream(baud=9600))
    line.send(burst(25) + burst(26), 5 * SECOND)
    line.silence()
    assert line.epochs[1]["burst_start_ns"] == 5 * SECOND + len(burst(25)) * (10 * SECOND // 9600)


def test_baud_changes_the_times():
    line = ReceiverLine(ReceiverStream(baud=115200))
    line.send(burst(25), SECOND)
    line.silence()
    byte_ns = 10 * SECOND // 115200
    assert line.epochs[0]["burst_end_ns"] == SECOND + (len(burst(25)) - 2) * byte_ns


def test_bytes_overwritten_by_dma_are_counted_and_parsing_goes_on():
    stream = ReceiverStream(ring_length=512)
    line = ReceiverLine(stream)
    line.send(burst(25)[:-10])
    for byte in burst(26) * 4:
        stream.ring[line.received % 512] = byte
        line.received += 1
    line.send(b"\r\n" + burst(27))
    line.silence()
    assert stream.statistics().overruns == 1
    assert times(line)[-1] == 27_000


def test_a_ring_of_another_length_is_refused():
    for length in (1000, 256, 0, -512):
        with pytest.raises(ValueError, match=f"ring_length is {length}, .* valid: 2048"):
            ReceiverStream(ring_length=length)


def test_finer_messages_stay():
    pubx = (
        "PUBX,00,092725.00,5030.11111,N,00415.54321,W,100.123,G3,2.1,3.4,36.000,30.00,-0.250,"
        ",0.92,1.19,0.77,9,0,0"
    )
    gga = "GNGGA,092725.00,5030.22222,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,"
    for order in ((pubx, gga), (gga, pubx)):
        line = ReceiverLine()
        line.send(b"".join(sentence(body) for body in order))
        line.silence()
        (epoch,) = line.epochs
        assert epoch["height_mm"] == 100_123
        assert epoch["lat_nanodeg"] == 50_501_851_833
        assert epoch["height_msl_mm"] == 87_400
        assert epoch["flags"] & ge.HAS_VELOCITY
