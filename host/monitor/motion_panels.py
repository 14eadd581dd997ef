"""What moves: attitude, position and velocity. Each function gives lines for a box of a size."""

from __future__ import annotations

import math

from rich.text import Text

from firmware.drivers import gnss_epoch as epoch
from host.link.messages import Gnss, Solution
from host.monitor.horizon import compass, horizon
from host.monitor.state import BoardState
from host.monitor.words import degrees, latitude, longitude, mode_name, number, utc

KMH = 3.6
LEAST_HORIZON = 3
UNDEFINED_COURSE_MPS = 0.3


def attitude_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """Horizon, compass, and the three angles with σ."""
    solution = state.solution
    seen = solution or state.attitude
    if seen is None:
        return [Text("no attitude yet" if state.gnss is None else "no attitude from a receiver", "dim")]
    sigmas = attitude_sigmas(solution) if solution is not None else (math.nan,) * 3
    numbers = _angles((seen.yaw, seen.pitch, seen.roll), sigmas)
    left = height - len(numbers) - 1
    if left < LEAST_HORIZON:
        return numbers
    pitch, roll, yaw = degrees(seen.pitch), degrees(seen.roll), degrees(seen.yaw)
    return [*horizon(pitch, roll, width, left), compass(yaw, width), *numbers]


def _angles(angles: tuple[float, float, float], sigmas: tuple[float, ...]) -> list[Text]:
    return [
        Text.assemble(
            f"{name:<6}",
            (number(degrees(angle), 2, 8) + "°", "bold"),
            (f" ±{number(degrees(sigma), 2)}°" if math.isfinite(sigma) else "", "dim"),
            no_wrap=True,
        )
        for name, angle, sigma in zip(("yaw", "pitch", "roll"), angles, sigmas, strict=True)
    ]


def attitude_sigmas(solution: Solution) -> tuple[float, float, float]:
    """σ of yaw, pitch and roll for small tilts, from those about north, east and down as if uncorrelated."""
    north, east = solution.sigma_phi_n, solution.sigma_phi_e
    if not math.isfinite(solution.yaw):
        return solution.sigma_phi_d, math.nan, math.nan
    cosine, sine = math.cos(solution.yaw), math.sin(solution.yaw)
    roll = math.hypot(north * cosine, east * sine)
    pitch = math.hypot(north * sine, east * cosine)
    return solution.sigma_phi_d, pitch, roll


def motion_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """Position, velocity, their σ and UTC, the more important lines first when there is little room."""
    solution = state.solution
    if solution is None:
        return _receiver_lines(state.gnss)[:height]
    style = "bold" if state.is_navigating else "dim"
    speed, course = speed_and_course(solution)
    lines = [
        Text(latitude(solution.lat_nanodeg).rjust(16), style),
        Text(longitude(solution.lon_nanodeg).rjust(16), style),
        _line("height", number(solution.height, 2, 9), "m", style),
        _three("± m", (solution.sigma_n, solution.sigma_e, solution.sigma_d), 2, "dim"),
        _line("speed", number(speed * KMH, 1, 9), "km/h", style),
        _line("course", number(course, 1, 9), "°", style),
        Text(utc(solution.time_of_day_ms, solution.date_days) + " UTC"),
        _three("NED", (solution.v_n, solution.v_e, solution.v_d), 2, ""),
        _three("±m/s", (solution.sigma_v_n, solution.sigma_v_e, solution.sigma_v_d), 2, "dim"),
        _line("mode", mode_name(solution.mode), "", ""),
    ]
    if height >= len(lines):
        lines[7:7] = [Text("velocity, m/s", "dim")] if height > len(lines) else []
    return lines[:height]


def _receiver_lines(gnss: Gnss | None) -> list[Text]:
    """What a receiver alone can tell."""
    if gnss is None:
        return [Text("no position yet", "dim")]
    flags = gnss.flags
    style = "bold" if flags & epoch.HAS_POSITION else "dim"
    height = gnss.height_mm if flags & epoch.HAS_HEIGHT else None
    speed = gnss.speed_mmps / 1000 if flags & epoch.HAS_SPEED else None
    course = gnss.course_e5deg * 1e-5 if flags & epoch.HAS_COURSE else None
    return [
        Text(latitude(gnss.lat_nanodeg).rjust(16), style),
        Text(longitude(gnss.lon_nanodeg).rjust(16), style),
        _line("height", number(None if height is None else height / 1000, 2, 9), "m", style),
        _line("speed", number(None if speed is None else speed * KMH, 1, 9), "km/h", style),
        _line("course", number(course, 1, 9), "°", style),
        Text(utc(gnss.time_of_day_ms, gnss.date_days) + " UTC"),
    ]


def speed_and_course(solution: Solution) -> tuple[float, float | None]:
    """m/s over ground, and degrees from north; no course at rest."""
    speed = math.hypot(solution.v_n, solution.v_e)
    if not math.isfinite(speed) or speed < UNDEFINED_COURSE_MPS:
        return speed, None
    return speed, math.degrees(math.atan2(solution.v_e, solution.v_n)) % 360.0


def _line(name: str, value: str, unit: str, style: str) -> Text:
    return Text.assemble(f"{name:<7}", (value, style), f" {unit}", no_wrap=True)


def _three(name: str, values: tuple[float, float, float], decimals: int, style: str) -> Text:
    told = "".join(number(value, decimals, 7) for value in values)
    return Text(f"{name:<4}{told}", style, no_wrap=True)
