"""What `navtwin attach gnss` is made of, without waiting for real time."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest
from pynmeagps import NMEAMessage

from host.attach import first_fix
from host.attach.epoch_arrival import EpochArrivals
from host.attach.first_fix import wait_for_fix
from host.attach.gnss_session import pulse_changes, standing_request
from host.attach.scatter import Scatter
from host.record.errors import UserError
from host.record.result import RunRequest

LATITUDE, LONGITUDE, HEIGHT_MSL, SEPARATION = 48.1173, -11.5167, 545.4, 46.9


def sentences(utc: datetime, fix: bool = True) -> bytes:
    """GGA and RMC as pynmeagps makes them."""
    place = {"lat": LATITUDE, "NS": "N", "lon": LONGITUDE, "EW": "W"} if fix else {}
    gga = NMEAMessage(
        "GN", "GGA", 0, time=utc.time(), **place, quality=int(fix), numSV=9, HDOP=0.9, alt=HEIGHT_MSL,
        altUnit="M", sep=SEPARATION, sepUnit="M",
    )  # fmt: skip
    rmc = NMEAMessage(
        "GN", "RMC", 0, time=utc.time(), status="A" if fix else "V", **place, spd=0.01, date=utc.date()
    )
    return bytes(gga.serialize() + rmc.serialize())


class Port:
    """What a receiver port looks like from the inside, with all bytes there already."""

    url = "a port"

    def __init__(self, *pieces: bytes) -> None:
        self.link = SimpleNamespace(baud=9600)
        self.notes: deque[str] = deque()
        self._pieces = list(pieces)
        self._now_ns = 0

    def take(self) -> list[tuple[int, bytes]]:
        self._now_ns += 1_000_000_000
        return [(self._now_ns, self._pieces.pop(0))] if self._pieces else []


@pytest.fixture(autouse=True)
def _in_a_hurry(monkeypatch):
    monkeypatch.setattr(first_fix, "POLL_S", 0.0)


def test_the_first_fix_is_where_and_when_the_receiver_says():
    utc = datetime(2026, 2, 28, 23, 59, 58, tzinfo=UTC)
    after = datetime(2026, 3, 1, 0, 0, 0, tzinfo=UTC)
    port = Port(sentences(utc, fix=False), sentences(after), sentences(after.replace(second=1)))
    fix = wait_for_fix(port, 5.0, lambda _text: None)
    assert fix.utc == after
    assert fix.latitude_deg == pytest.approx(LATITUDE, abs=1e-6)
    assert fix.longitude_deg == pytest.approx(LONGITUDE, abs=1e-6)
    assert fix.height_m == pytest.approx(HEIGHT_MSL + SEPARATION, abs=1e-6)
    assert 'start.utc="2026-03-01T00:00:00Z"' in fix.overrides()
    assert f"place.geoid_separation_m={SEPARATION}" in fix.overrides()


def test_no_fix_in_time_says_what_there_was():
    utc = datetime(2026, 2, 28, 12, 0, 0, tzinfo=UTC)
    port = Port(*(sentences(utc.replace(second=k), fix=False) for k in range(4)))
    with pytest.raises(UserError, match=r"no fix within 0\.2 s .*position not known.*--wait"):
        wait_for_fix(port, 0.2, lambda _text: None)
    with pytest.raises(UserError, match="nothing comes from the receiver"):
        wait_for_fix(Port(), 0.1, lambda _text: None)


def test_bytes_without_sense_are_told_before_the_time_is_over(monkeypatch):
    monkeypatch.setattr(first_fix, "SENSELESS_S", 0.05)
    port = Port(*[bytes(range(128, 228))] * 10)
    with pytest.raises(UserError, match="1000 bytes at 9600 baud make no sense as NMEA or UBX"):
        wait_for_fix(port, 30.0, lambda _text: None)


def test_latency_and_jitter_are_those_that_were_put_in(monkeypatch):
    """Epochs at full seconds that arrive 80 ms later, spread by ±5 ms."""
    base_ns = 1_800_000_000 * 10**9
    monkeypatch.setattr("host.attach.epoch_arrival.time.time_ns", lambda: base_ns)
    monkeypatch.setattr("host.attach.epoch_arrival.time.monotonic_ns", lambda: 0)
    arrivals = EpochArrivals()
    put_in = []
    for second in range(1, 61):
        late_ns = 80_000_000 + (second * 37 % 11 - 5) * 1_000_000
        put_in.append(late_ns / 1e6)
        data = sentences(datetime.fromtimestamp(base_ns / 1e9 + second, UTC))
        for place in range(0, len(data), 32):
            arrivals.take(second * 10**9 + late_ns + place // 32 * 3_000_000, data[place : place + 32])
        arrivals.take(second * 10**9 + 600_000_000, b"")
    figures = arrivals.figures()
    assert figures["epochs"] == 60
    assert figures["latency_median_ms"] == pytest.approx(np.median(put_in), abs=0.01)
    assert figures["latency_max_ms"] == pytest.approx(max(put_in), abs=0.01)
    assert figures["jitter_rms_ms"] == pytest.approx(np.std(put_in), abs=0.01)
    assert abs(figures["host_clock_ppm"]) < 60


def test_a_receiver_of_another_time_has_jitter_only():
    arrivals = EpochArrivals()
    for second in range(1, 5):
        arrivals.take(second * 10**9, sentences(datetime(2015, 3, 18, 17, 0, second, tzinfo=UTC)))
    arrivals.take(6 * 10**9, b"")
    figures = arrivals.figures()
    if abs(datetime.now(UTC).hour - 17) > 1:
        assert "latency_median_ms" not in figures
    assert figures["jitter_rms_ms"] < 1.0


def test_scatter_is_that_of_the_positions():
    rng = np.random.default_rng(4)
    ned = rng.normal((30.0, -20.0, 5.0), (2.0, 1.0, 3.0), (500, 3))
    scatter = Scatter()
    radius = 6_378_137.0
    for north, east, down in ned:
        lon = 179_999_900_000 + round(math.degrees(east / radius) * 1e9)
        lon = (lon + 180 * 10**9) % (360 * 10**9) - 180 * 10**9
        scatter.add(round(math.degrees(north / 6_335_439.0) * 1e9), lon, -down)
    figures = scatter.figures()
    for axis, column in zip(("north", "east", "down"), ned.T, strict=True):
        assert figures[f"sigma_{axis}_m"] == pytest.approx(column.std(), rel=2e-3)
    assert figures["farthest_from_first_m"] == pytest.approx(
        np.hypot(*(ned - ned[0])[:, :2].T).max(), rel=2e-3
    )


def test_a_moving_vehicle_is_refused_and_recorded_only():
    request = RunRequest("car_mems", "town-open")
    with pytest.raises(UserError, match=r"its vehicle moves.*--record-only"):
        standing_request(request, record_only=False)
    assert standing_request(request, record_only=True) is request
    assert standing_request(replace(request, scenario="static"), record_only=False).scenario == "static"
    assert standing_request(replace(request, scenario=None), record_only=False).scenario == "static"
    with pytest.raises(UserError, match="its vehicle moves"):
        standing_request(replace(request, scenario="real-drive"), record_only=False)


def test_a_serial_port_brings_no_time_pulse():
    from boards.description import load_board

    assert pulse_changes(load_board("car_mems")) == ("board.pins.timepulse.wired=false",)
