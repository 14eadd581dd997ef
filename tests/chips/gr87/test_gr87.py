"""The GR-87: sentences to the letter, $PSRF commands, starts, whatever comes in; readers from PyPI."""

from __future__ import annotations

import adafruit_gps
import pynmea2
import pytest
from gr87_rig import Rig, body, lines, sentence
from hypothesis import given, settings
from hypothesis import strategies as st
from pynmeagps import NMEAReader


def test_a_set_to_the_letter() -> None:
    rig = Rig()
    rig.wait(3.05)
    told = [body(line) for line in lines(rig.wait(1.0))]
    assert told == [
        "GPGGA,092728.000,5030.1235,N,00415.5432,W,1,04,0.9,87.4,M,48.1,M,,0000",
        "GPGSA,A,3,01,03,04,11,,,,,,,,,1.6,0.9,1.3",
        "GPGSV,2,1,06,01,53,280,36,03,29,301,24,04,55,223,37,08,38,166,16",
        "GPGSV,2,2,06,11,40,245,29,12,05,034,",
        "GPRMC,092728.000,A,5030.1235,N,00415.5432,W,9.72,53.13,150324,,",
    ]


def test_the_other_sentences() -> None:
    rig = Rig(baud=19_200)
    rig.wait(2.0)
    for number in (0, 2, 3, 4):
        rig.say(f"PSRF103,{number:02d},00,00,01")
    for number in (1, 5, 8):
        rig.say(f"PSRF103,{number:02d},00,01,01")
    rig.wait(1.05)
    assert [body(line) for line in lines(rig.wait(1.0))] == [
        "GPGLL,5030.1235,N,00415.5432,W,092728.000,A",
        "GPVTG,53.13,T,,M,9.72,N,18.0,K",
        "GPZDA,092728.000,15,03,2024,00,00",
    ]


def test_no_fix_forms_and_the_clock_before_it_knows_the_time() -> None:
    rig = Rig(start_state="cold")
    rig.wait(2.05)
    assert [body(line) for line in lines(rig.wait(1.0))] == [
        "GPGGA,000002.000,,,,,0,00,,,M,0.0,M,,0000",
        "GPGSA,A,1,,,,,,,,,,,,,,,",
        "GPGSV,2,1,06,01,53,280,36,03,29,301,24,04,55,223,37,08,38,166,16",
        "GPGSV,2,2,06,11,40,245,29,12,05,034,",
        "GPRMC,000002.000,V,,,,,,,060180,,",
    ]


@pytest.mark.parametrize(("state", "seconds"), [("cold", 42), ("warm", 38), ("hot", 1)])
def test_first_fix(state: str, seconds: int) -> None:
    rig = Rig(start_state=state)
    told = lines(rig.wait(60.0))
    first = next(line for line in told if line.startswith("$GPRMC") and ",A," in line)
    assert pynmea2.parse(first).timestamp.second == (25 + seconds) % 60


def test_the_public_strings_switch_the_rate_and_back() -> None:
    """They stand in the fact sheet with their checksums."""
    rig = Rig()
    rig.wait(3.0)
    rig.chip.receive(b"$PSRF100,1,19200,8,1,0*38\r\n", rig.time.now)
    rig.wait(1.5)
    assert rig.chip.baud == 19_200 == rig.wire.baud
    assert len(lines(rig.wait(2.0))) == 10
    rig.chip.receive(b"$PSRF100,1,4800,8,1,0*0E\r\n", rig.time.now)
    rig.wait(1.5)
    assert rig.chip.baud == 4800
    rig.chip.receive(b"$PSRF103,04,00,01,01*21\r\n", rig.time.now)
    assert rig.chip.reports == []


def test_a_line_too_slow_for_the_set_drops_whole_sentences() -> None:
    rig = Rig(baud=1200)
    told = rig.wait(60.0)
    assert rig.chip.messages_dropped > 10
    whole = told[told.index(b"$") : told.rindex(b"\r\n") + 2]
    for line in lines(whole):
        body(line)


def test_rates_queries_and_checksums() -> None:
    rig = Rig()
    rig.wait(2.05)
    for number in (0, 2, 4):
        rig.say(f"PSRF103,{number:02d},00,00,01")
    rig.say("PSRF103,03,00,05,00")
    told = lines(rig.wait(10.0))
    assert len(told) == 4
    assert all(line.startswith("$GPGSV") and "*" not in line for line in told)
    rig.say("PSRF103,00,01,00,01")
    assert [line[:6] for line in lines(rig.wait(0.3))] == ["$GPGGA"]


def test_settings_survive_a_pause_with_a_battery_only() -> None:
    for battery, baud, first_fix in ((True, 19_200, 2.5), (False, 4800, 43.5)):
        rig = Rig(backup_supply=battery)
        rig.wait(3.0)
        rig.say("PSRF100,1,19200,8,1,0")
        rig.wait(2.0)
        rig.chip.power(False)
        assert rig.wait(5.0) == b""
        rig.chip.power(True)
        told = lines(rig.wait(first_fix))
        assert rig.chip.baud == baud
        assert [",A," in line for line in told if line.startswith("$GPRMC")][-1]
        assert next(",V," in line for line in told if line.startswith("$GPRMC")) == (not battery)


@pytest.mark.parametrize(("reset", "seconds"), [(1, 1.6), (2, 38.6), (4, 42.6), (8, 42.6)])
def test_restarts(reset: int, seconds: float) -> None:
    rig = Rig(baud=9600)
    rig.wait(3.05)
    rig.say(f"PSRF101,-2686700,-4304200,3851624,96000,497260,921,12,{reset}")
    told = [line for line in lines(rig.wait(seconds + 1.5)) if line.startswith("$GPRMC")]
    assert ",A," in told[-1]
    assert ",V," in told[0] or reset == 1
    assert rig.chip.baud == (4800 if reset == 8 else 9600)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("PSRF100,1,12345,8,1,0", "protocol"), ("PSRF100,1,9600", "protocol"),
        ("PSRF100,1,9600,7,1,0", "not modelled"), ("PSRF102,9600,8,1,0", "not modelled"),
        ("PSRF103,07,00,01,01", "protocol"), ("PSRF103,06,00,01,01", "not modelled"),
        ("PSRF103,00,00,999,01", "protocol"), ("PSRF103,xx,00,01,01", "protocol"),
        ("PSRF101,1,2,3,4,5,6,12,3x", "protocol"), ("PSRF104,1", "protocol"), ("PSRF105,2", "protocol"),
        ("PSRF106,178", "not modelled"), ("PSRF107,1", "not modelled"), ("PSRF108,1", "not modelled"),
        ("PSRF999,1", "protocol"), ("PSRFab", "protocol"), ("GPGGA,1", "protocol"), ("PSRF", "protocol"),
    ],
)  # fmt: skip
def test_what_it_cannot_is_reported_and_ignored(text: str, kind: str) -> None:
    rig = Rig()
    rig.wait(3.05)
    before = lines(rig.wait(1.0))
    rig.say(text)
    assert [report.kind.value for report in rig.chip.reports] == [kind]
    assert len(lines(rig.wait(1.0))) == len(before)
    rig.say("PSRF106,21")
    rig.say("PSRF105,1")
    assert len(rig.chip.reports) == 1


def test_development_data_tell_why() -> None:
    rig = Rig()
    rig.wait(3.05)
    rig.say("PSRF105,1")
    rig.say("PSRF103,00,07,01,01")
    assert any(line.startswith("$PSRFTXT,") for line in lines(rig.wait(1.0)))


ORDERS = st.one_of(
    st.binary(max_size=40),
    st.builds(
        lambda number, fields: sentence(f"PSRF{number},{','.join(map(str, fields))}"),
        st.integers(99, 109),
        st.lists(st.one_of(st.integers(-2, 40_000), st.text("0123456789.-x", max_size=4)), max_size=9),
    ),
    st.sampled_from([b"power", b"\xa0\xa2", b"$"]),
)


@settings(max_examples=40, deadline=None)
@given(st.lists(ORDERS, max_size=8))
def test_nothing_raises_and_only_sentences_leave(said: list[bytes]) -> None:
    rig = Rig()
    told = rig.wait(2.0)
    on = True
    for data in said:
        if data == b"power":
            on = not on
            rig.chip.power(on)
        else:
            rig.chip.receive(data, rig.time.now)
        rig.wait(1.3)
    told = rig.wait(3.0)
    for line in lines(told)[1:-1]:
        assert line.startswith("$")
        assert len(line) <= 82


def test_pynmeagps_reads_every_sentence() -> None:
    rig = Rig(baud=19_200)
    rig.wait(3.05)
    for line in lines(rig.wait(1.0)):
        told = NMEAReader.parse(line.encode() + b"\r\n")
        if told.msgID in ("GGA", "RMC"):
            assert told.lat == pytest.approx(50.0 + 30.12345 / 60, abs=1e-6)
            assert told.lon == pytest.approx(-(4.0 + 15.54321 / 60), abs=1e-6)


class AdafruitUart:
    """The little of CircuitPython's busio.UART that adafruit_gps uses."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.data = bytearray()
        self.in_waiting = 0

    def take(self, data: bytes) -> None:
        self.data += data
        self.in_waiting = len(self.data)

    def readline(self) -> bytes:
        end = self.data.find(b"\n") + 1
        line = bytes(self.data[:end])
        del self.data[:end]
        self.in_waiting = len(self.data)
        return line

    def read(self, count: int) -> bytes:
        part = bytes(self.data[:count])
        del self.data[:count]
        return part

    def write(self, data: bytes) -> int:
        self.rig.chip.receive(bytes(data), self.rig.time.now)
        return len(data)


def test_adafruit_gps_unmodified() -> None:
    """adafruit-circuitpython-gps reads the fix and switches the bit rate by its own `send_command`.

    It leaves an RMC without mode (NMEA 2.2) alone, so speed and date are not read.
    """
    rig = Rig()
    uart = AdafruitUart(rig)
    gps = adafruit_gps.GPS(uart, debug=False)
    rig.wait(3.05)
    gps.send_command(b"PSRF100,1,19200,8,1,0")
    rig.wait(1.5)
    for _ in range(4):
        uart.take(rig.wait(1.0))
        while gps.update():
            pass
    assert rig.chip.baud == 19_200
    assert gps.has_3d_fix
    assert gps.latitude == pytest.approx(50.0 + 30.12345 / 60, abs=1e-6)
    assert gps.longitude == pytest.approx(-(4.0 + 15.54321 / 60), abs=1e-6)
    assert (gps.altitude_m, gps.satellites, gps.horizontal_dilution) == (87.4, 4, 0.9)
    assert set(gps.sats) == {"GP1", "GP3", "GP4", "GP8", "GP11", "GP12"}
