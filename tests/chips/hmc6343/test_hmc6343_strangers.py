"""Sequences of public drivers of the HMC6343, written from their order of calls and their waits."""

from __future__ import annotations

import pytest
from hmc6343_rig import ADDRESS, MS, Rig

from hal.errors import BusError

POST_ACCEL, POST_MAG, POST_HEADING, POST_TILT, POST_OP_MODE = 0x40, 0x45, 0x50, 0x55, 0x65


class WireLibrary:
    """How Arduino's Wire is used by them: a write with a stop, a wait in whole milliseconds, a read."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig

    def send(self, *data: int, wait_ms: int = 1) -> None:
        self._rig.bus.transaction(ADDRESS, bytes(data))
        self._rig.wait(wait_ms * MS)

    def request(self, length: int) -> list[int]:
        return list(self._rig.bus.transaction(ADDRESS, b"", length))

    def words(self, command: int) -> list[int]:
        self.send(command)
        raw = self.request(6)
        values = [raw[k] << 8 | raw[k + 1] for k in (0, 2, 4)]
        return [value - 0x10000 if value & 0x8000 else value for value in values]

    def eeprom(self, register: int) -> int:
        self.send(0xE1, register, wait_ms=10)
        return self.request(1)[0]


@pytest.fixture
def rig() -> Rig:
    made = Rig(lambda t: (123.4, 5.0, -7.0))
    made.start()
    return made


def test_sparkfun_example(rig: Rig) -> None:
    """init() asks the EEPROM for the address; the example reads heading, acceleration in 1024ths of g."""
    wire = WireLibrary(rig)
    assert wire.eeprom(0x00) == 0x32
    heading, pitch, roll = wire.words(POST_HEADING)
    assert (heading, pitch, roll) == (1234, 50, -70)
    x, y, z = (count / 1024 for count in wire.words(POST_ACCEL))
    assert abs((x * x + y * y + z * z) ** 0.5 - 1.0) < 2e-3
    assert wire.words(POST_TILT)[:2] == [50, -70]
    assert len(set(wire.words(POST_MAG))) == 3
    assert rig.details == []


def test_sparkfun_modes_settings_and_reset(rig: Rig) -> None:
    wire = WireLibrary(rig)
    wire.send(0x76)
    wire.send(POST_OP_MODE)
    assert wire.request(1) == [0x09]
    wire.send(0x75)
    wire.send(0x83)
    wire.send(0x84, wait_ms=20)
    wire.send(0x75)
    wire.send(POST_OP_MODE)
    assert wire.request(1)[0] & 0x7F == 0x11
    wire.send(0xF1, 0x05, 0x02, wait_ms=10)
    wire.send(0xF1, 0x0C, 0x1E, wait_ms=10)
    wire.send(0x82, wait_ms=500)
    assert wire.eeprom(0x05) == 0x02
    assert wire.words(POST_HEADING)[0] == 1264, "3.0° of variation"
    wire.send(0x71)
    wire.send(0x7E, wait_ms=50)
    assert rig.details == []


def test_a_driver_that_does_not_wait_is_told_and_survives(rig: Rig) -> None:
    """Repeated start right behind the command; commands in a row; a probe by an empty write."""
    early = rig.bus.transaction(ADDRESS, bytes((POST_HEADING,)), 6)
    assert len(early) == 6
    assert any("within the delay" in detail for detail in rig.details)
    rig.wait(1 * MS)
    assert WireLibrary(rig).words(POST_HEADING) == [1234, 50, -70]
    rig.bus.transaction(ADDRESS, bytes((0x82,)))
    with pytest.raises(BusError):
        rig.bus.transaction(ADDRESS, bytes((POST_HEADING,)))
    rig.wait(500 * MS)
    assert WireLibrary(rig).words(POST_HEADING) == [1234, 50, -70]
