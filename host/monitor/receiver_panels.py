"""What the receiver sees: fix, satellites with C/N0 bars, and where they stand in the sky."""

from __future__ import annotations

import math

from rich.text import Text

from firmware.drivers import gnss_epoch as epoch
from firmware.drivers.satellite_lists import SatelliteInView
from firmware.link import frames
from host.monitor.bars import bar
from host.monitor.state import BoardState
from host.monitor.words import number

BEST_DBHZ = 55.0
OLD_S = 2.5
"""Epochs come once a second or more often."""
LETTERS = {"GPS": "G", "GLONASS": "R", "Galileo": "E", "BeiDou": "C", "QZSS": "J", "SBAS": "S"}
STRONG_DBHZ, WEAK_DBHZ = 38, 28
NARROWEST = 11
"""Width of a satellite with number, C/N0 and bar."""
WITH_ANGLES = 26
"""The same with elevation and azimuth."""


def fix_line(state: BoardState) -> Text:
    """Kind of fix, satellites used, dilution and accuracy."""
    gnss = state.gnss
    if gnss is None:
        return Text("no epoch of the receiver yet", "dim")
    silent_s = state.at_s - state.seen_s.get(frames.GNSS, state.at_s)
    if silent_s > OLD_S:
        return Text(f"no epoch for {silent_s:.0f} s", "bold red")
    style = "bold green" if gnss.flags & epoch.HAS_POSITION else "bold red"
    told = f" {gnss.satellites} used"
    if gnss.flags & epoch.HAS_ACCURACY:
        told += f" ±{number(gnss.h_acc_mm / 1000, 1)}m"
    if gnss.hdop_centi:
        told += f" HDOP {number(gnss.hdop_centi / 100, 1)}"
    return Text.assemble((state.fix, style), told, no_wrap=True)


def satellite_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """The fix, then satellites, used and strong ones first, in as many columns as fit."""
    lines = [fix_line(state)]
    if state.satellites is None:
        return [*lines, Text("no list of satellites yet", "dim")]
    seen = sorted(state.satellites, key=_order)
    rows = max(height - 1, 1)
    columns = min(max(-(-len(seen) // rows), 1), max(width // NARROWEST, 1))
    column_width = width // columns
    cells = [_satellite(one, column_width - 1) for one in seen]
    if len(cells) > rows * columns:
        left = len(cells) - rows * columns + 1
        cells[rows * columns - 1 :] = [Text(f"and {left} more", "dim")]
    for row in range(min(rows, len(cells))):
        line = Text(no_wrap=True)
        for column in range(columns):
            place = column * rows + row
            if place < len(cells):
                cell = cells[place]
                cell.pad_right(max(column_width - cell.cell_len, 0))
                line.append_text(cell)
        lines.append(line)
    return lines


def _order(one: SatelliteInView) -> tuple[bool, int, str, int]:
    return not one.used, -(one.cn0_dbhz or 0), one.system, one.number


def _name(one: SatelliteInView) -> str:
    return f"{LETTERS.get(one.system, '?')}{one.number:02d}"


def signal_style(one: SatelliteInView) -> str:
    """Colour of a satellite: grey when not used, else by strength."""
    if not one.used:
        return "bright_black"
    if (one.cn0_dbhz or 0) >= STRONG_DBHZ:
        return "green"
    return "yellow" if (one.cn0_dbhz or 0) >= WEAK_DBHZ else "red"


def _satellite(one: SatelliteInView, width: int) -> Text:
    angles = ""
    if width >= WITH_ANGLES:
        elevation = "--" if one.elevation_deg is None else f"{one.elevation_deg:2d}"
        azimuth = "---" if one.azimuth_deg is None else f"{one.azimuth_deg:3d}"
        angles = f" el {elevation} az {azimuth}  "
    cn0 = "--" if one.cn0_dbhz is None else f"{one.cn0_dbhz:2d}"
    head = f"{_name(one):<3}{'*' if one.used else ' '}{angles}{cn0} "
    return Text.assemble(
        (head, "" if one.used else "dim"),
        (bar((one.cn0_dbhz or 0) / BEST_DBHZ, max(width - len(head), 0)), signal_style(one)),
        no_wrap=True,
    )


def sky_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """The sky from above, north up: the middle is the zenith, the rim the horizon."""
    if not state.satellites:
        return [Text("no list of satellites yet", "dim")]
    radius_y = max((height - 1) / 2, 0.5)
    radius_x = min(2 * radius_y, (width - 4) / 2)
    grid: list[list[tuple[str, str]]] = [[(" ", "")] * width for _ in range(height)]

    def put(elevation: float, azimuth: float, sign: str, style: str) -> None:
        away = (90.0 - elevation) / 90.0
        angle = math.radians(azimuth)
        row = round((height - 1) / 2 - away * radius_y * math.cos(angle))
        column = round((width - 1) / 2 + away * radius_x * math.sin(angle)) - len(sign) // 2
        for k, letter in enumerate(sign):
            if 0 <= row < height and 0 <= column + k < width:
                grid[row][column + k] = letter, style

    for azimuth in range(0, 360, 4):
        put(0, azimuth, "·", "bright_black")
        put(45, azimuth, "·", "bright_black")
    for azimuth, name in ((0, "N"), (90, "E"), (180, "S"), (270, "W")):
        put(0, azimuth, name, "bold cyan")
    for one in sorted(state.satellites, key=_order, reverse=True):
        if one.elevation_deg is not None and one.azimuth_deg is not None:
            put(one.elevation_deg, one.azimuth_deg, _name(one), signal_style(one))
    return [Text.assemble(*row, no_wrap=True) for row in grid]
