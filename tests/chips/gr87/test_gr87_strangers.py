"""Drivers for a SiRF receiver as others write them, from the fact sheet's section 5 alone.

Bytes go out one at a time or all at once, line ends are CR LF, LF or CR; what comes back is read by fixed
columns, by splitting, or by a state machine that looks at one byte at a time.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from gr87_rig import Rig

LATITUDE, LONGITUDE = 50.0 + 30.12345 / 60, -(4.0 + 15.54321 / 60)


class ByteMachine:
    """A reader for a small processor: waits for "$", adds up, compares two digits, hands over the fields."""

    def __init__(self) -> None:
        self.text = ""
        self.sum = 0
        self.state = 0
        self.bad = 0

    def take(self, data: bytes) -> Iterator[list[str]]:
        for byte in data:
            letter = chr(byte)
            if letter == "$":
                self.text, self.sum, self.state = "", 0, 1
            elif self.state == 1 and letter == "*":
                self.state, self.digits = 2, ""
            elif self.state == 1:
                self.text += letter
                self.sum ^= byte
            elif self.state == 2:
                self.digits += letter
                if len(self.digits) == 2:
                    self.state = 0
                    if int(self.digits, 16) == self.sum:
                        yield self.text.split(",")
                    else:
                        self.bad += 1


def degrees(field: str, side: str) -> float:
    """ddmm.mmmm or dddmm.mmmm."""
    point = field.index(".")
    value = int(field[: point - 2]) + float(field[point - 2 :]) / 60
    return -value if side in "SW" else value


@pytest.mark.parametrize("end", ["\r\n", "\n", "\r"])
@pytest.mark.parametrize("whole", [True, False])
def test_set_up_and_read_by_a_state_machine(end: str, whole: bool) -> None:
    """4800 baud, RMC and GGA alone, 19200 baud; strings as published, in upper and lower case of the sum."""
    rig = Rig()
    rig.wait(1.0)
    published = ["PSRF103,04,00,01,01*21", "PSRF103,02,00,00,01*26", "PSRF103,03,00,00,01*27"]
    for text in (*published, "PSRF100,1,19200,8,1,0*38"):
        line = f"${text}{end}".encode()
        for piece in [line] if whole else [line[k : k + 1] for k in range(len(line))]:
            rig.chip.receive(piece, rig.time.now)
            rig.wait(len(piece) / 480)
    rig.wait(2.5)
    assert rig.chip.baud == 19_200
    assert rig.chip.reports == []
    machine = ByteMachine()
    found = list(machine.take(rig.wait(3.0)))
    assert machine.bad == 0
    assert [fields[0] for fields in found] == ["GPGGA", "GPRMC"] * 3
    for fields in found:
        at = 2 if fields[0] == "GPGGA" else 3
        assert degrees(*fields[at : at + 2]) == pytest.approx(LATITUDE, abs=1e-6)
        assert degrees(*fields[at + 2 : at + 4]) == pytest.approx(LONGITUDE, abs=1e-6)


def test_fixed_columns() -> None:
    """A display reads RMC by the places of its letters: all fields that have a fixed width keep it."""
    rig = Rig(baud=19_200)
    rig.wait(3.05)
    (rmc,) = (line for line in rig.wait(1.0).decode().split("\r\n") if line.startswith("$GPRMC"))
    assert (rmc[7:9], rmc[9:11], rmc[11:17], rmc[18]) == ("09", "27", "28.000", "A")
    assert (rmc[20:29], rmc[30], rmc[32:42], rmc[43]) == ("5030.1235", "N", "00415.5432", "W")


def test_polling_alone() -> None:
    """All rates 0, then each sentence asked for when it is wanted."""
    rig = Rig(baud=19_200)
    rig.wait(3.05)
    for number in range(6):
        rig.say(f"PSRF103,{number:02d},00,00,01")
    rig.wait(1.0)
    assert rig.wait(3.0) == b""
    for number, name in enumerate(("GGA", "GLL", "GSA", "GSV", "RMC", "VTG")):
        rig.say(f"PSRF103,{number:02d},01,00,01")
        told = {fields[0] for fields in ByteMachine().take(rig.wait(0.4))}
        assert told == {f"GP{name}"}


def test_a_driver_that_lost_the_rate_finds_it_again() -> None:
    """It sends the change to 4800 baud at each rate there is and listens; at a wrong one nothing arrives."""
    rig = Rig(baud=19_200)
    rig.wait(1.0)
    line = b"$PSRF100,1,4800,8,1,0*0E\r\n"
    for baud in (4800, 9600, 19_200):
        heard = line if baud == rig.chip.baud else bytes(byte * 7 & 0xFF | 0x80 for byte in line)
        rig.chip.receive(heard, rig.time.now)
        rig.wait(1.2)
    assert rig.chip.baud == 4800
    rig.wait(1.5)
    assert any(fields[0] == "GPRMC" for fields in ByteMachine().take(rig.wait(2.0)))
