"""Public drivers that nobody here wrote, unmodified, against the model: adafruit_gps and ublox_gps."""

from __future__ import annotations

import sys
import types

import adafruit_gps
import pytest
from neo_m8n_rig import Rig


class Port:
    """The receiver's line as a serial port that a driver reads and writes; waiting lets virtual time pass."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.data = bytearray()

    @property
    def in_waiting(self) -> int:
        return len(self.data)

    def listen(self, seconds: float) -> None:
        """What comes in that time is there to be read."""
        self.data += self.rig.run(seconds)

    def read(self, count: int = 1) -> bytes:
        for _ in range(30):
            if len(self.data) >= count:
                break
            self.listen(0.1)
        part = bytes(self.data[:count])
        del self.data[:count]
        return part

    def readline(self) -> bytes:
        end = self.data.find(b"\n") + 1
        return self.read(end)

    def write(self, data: bytes) -> int:
        self.rig.say(bytes(data))
        return len(data)


def test_adafruit_gps_reads_the_fix() -> None:
    """It keeps six decimals of a degree."""
    rig = Rig(start_state="hot")
    port = Port(rig)
    gps = adafruit_gps.GPS(port, debug=False)
    rig.run(3.5)
    port.listen(3.0)
    while port.in_waiting and b"\n" in port.data:
        gps.update()
    assert gps.has_3d_fix
    assert gps.latitude == pytest.approx(50.0 + 30.12345 / 60, abs=2e-6)
    assert gps.longitude == pytest.approx(-(4.0 + 15.54321 / 60), abs=2e-6)
    assert gps.altitude_m == pytest.approx(87.4)
    assert gps.speed_knots == pytest.approx(5.0 * 3600 / 1852, abs=1e-3)
    assert gps.timestamp_utc.tm_year == 2024


def test_ublox_gps_polls_nav_pvt(monkeypatch: pytest.MonkeyPatch) -> None:
    """It imports spidev, which this test has no use for."""
    spidev = types.ModuleType("spidev")
    spidev.SpiDev = object  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "spidev", spidev)
    from ublox_gps import UbloxGps

    rig = Rig(start_state="hot")
    rig.run(3.5)
    gps = UbloxGps(Port(rig))
    told = gps.geo_coords()
    assert told.lat == pytest.approx(50.0 + 30.12345 / 60, abs=1e-6)
    assert told.lon == pytest.approx(-(4.0 + 15.54321 / 60), abs=1e-6)
