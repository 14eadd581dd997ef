"""A drive as a board would tell it: bytes of the link with their times, all values from closed forms."""

from __future__ import annotations

import math
from pathlib import Path

from firmware.drivers.satellite_lists import SatelliteInView
from firmware.link import frames
from firmware.link.nmea_output import NmeaWriter
from host.capture.writer import CaptureWriter
from host.record.manifest import build_manifest

LAT, LON = 48.1, 11.5
RADIUS_M = 200.0
SPEED = 10.0
METRES_A_DEGREE = 6_371_000.0 * math.pi / 180
DAY = 16_140
START_MS = 9 * 3_600_000
SATELLITES = [
    SatelliteInView("GPS", 5, 62, 110, 47, True),
    SatelliteInView("GPS", 13, 35, 290, 41, True),
    SatelliteInView("GLONASS", 78, 20, 20, 33, True),
    SatelliteInView("Galileo", 11, 48, 200, 24, True),
    SatelliteInView("BeiDou", 401, 5, 340, None, False),
    SatelliteInView("SBAS", 33, None, None, 30, False),
]
TASKS = ("imu_ready", "navigation", "filter", "output")
LOADS = (0.02, 0.031, 0.0015, 0.004)


def place(t: float) -> tuple[int, int, float]:
    """Latitude and longitude in nanodegrees, yaw: a circle that begins eastwards at its northern end."""
    angle = SPEED * t / RADIUS_M
    north = LAT + RADIUS_M * (math.cos(angle) - 1.0) / METRES_A_DEGREE
    east = LON + RADIUS_M * math.sin(angle) / METRES_A_DEGREE / math.cos(math.radians(LAT))
    return round(north * 1e9), round(east * 1e9), (math.pi / 2 + angle) % (2 * math.pi)


def solution(writer: frames.FrameWriter, t: float, mode: int = 3, flags: int = 1 << 9) -> bytes:
    """A SOLUTION frame; roll 8°, pitch −3° all the way."""
    lat, lon, yaw = place(t)
    velocity = (SPEED * math.cos(yaw), SPEED * math.sin(yaw), 0.25)
    attitude = (yaw, math.radians(-3.0), math.radians(8.0))
    rates = (0.0, 0.0, SPEED / RADIUS_M)
    sigmas = (0.5, 0.75, 1.5, 0.03125, 0.0625, 0.125, 0.0078125, 0.00390625, 0.015625)
    time_of_day = START_MS + round(t * 1000)
    values = (lat, lon, 520.25, *velocity, *attitude, *rates, *sigmas)
    return writer.pack(frames.SOLUTION, round(t * 1e6), time_of_day, DAY, mode, flags, *values)


def gnss(writer: frames.FrameWriter, t: float) -> bytes:
    """A GNSS frame, three metres south of the circle, with accuracies."""
    lat, lon, yaw = place(t)
    lat -= round(3.0 / METRES_A_DEGREE * 1e9)
    course = round(math.degrees(yaw) * 1e5)
    values = (521_000, 474_000, 10_000, course, 0, 0, 0, 4, 110, 1500, 2500)
    return writer.pack(frames.GNSS, round(t * 1e6), START_MS + round(t * 1000), DAY, 0x1FF, lat, lon, *values)


def second(writer: frames.FrameWriter, t: int) -> bytes:
    """What comes once a second."""
    us = t * 1_000_000
    data = gnss(writer, t)
    wave = [math.sin(t * (1 + k)) for k in range(6)]
    data += writer.pack(frames.INNOVATION, us, 0b11_1111 if t % 4 else 0b00_0111, *wave, *([1.0] * 6))
    biases = (0.001, -0.002, 0.003, 0.1, -0.2, 0.05, 0.02, 0.01, 0.08)
    data += writer.pack(frames.BIAS, us, *biases, *([0.001] * 9))
    data += writer.pack(frames.STATUS, us, 3, 1 << 9, t, 100 * t, 2, 0, 1, 56, 0, 1, 1)
    rows = [
        (name, 100 * t, round(load * us), 50 + 10 * k, 0)
        for k, (name, load) in enumerate(zip(TASKS, LOADS, strict=True))
    ]
    data += b"".join(writer.tasks(us, rows))
    if t % 5 == 0:
        data += b"".join(writer.satellites(us, SATELLITES))
    return data + NmeaWriter().seal("INHDT,90.00,T")


def spoken(seconds: int) -> list[tuple[int, bytes]]:
    """(time in ns, bytes) of the whole drive."""
    writer = frames.FrameWriter()
    pieces = [(1_000_000, writer.text("mode: navigating"))]
    for tenth in range(1, seconds * 10 + 1):
        data = solution(writer, tenth / 10)
        if tenth % 10 == 0:
            data += second(writer, tenth // 10)
        if tenth == 200:
            data += writer.text("IMU samples missing")
        pieces.append((tenth * 100_000_000 + 20_000_000, data))
    return pieces


def manifest() -> dict:
    """Of the drive's captures."""
    return build_manifest("car_mems", 'name = "car_mems"\n', "circle", "", "full-rate", 1, [])


def write_capture(path: Path, pieces: list[tuple[int, bytes]], finished: bool = True) -> Path:
    """A capture of the board's line alone."""
    writer = CaptureWriter(path, manifest())
    record = writer.uart_recorder("host", "tx")
    for time_ns, data in pieces:
        record(time_ns, data)
    if finished:
        writer.close({"state_hash": "0" * 64, "duration_s": f"{pieces[-1][0] / 1e9:.9f}"})
        return path
    writer.flush(pieces[-1][0])
    return writer.part
