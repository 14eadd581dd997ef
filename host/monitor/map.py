"""The track as a map: north up, fused and GNSS in two colours, a scale bar below."""

from __future__ import annotations

import math
from itertools import groupby, pairwise

import numpy as np
from rich.text import Text

from host.monitor.braille import ACROSS, DOWN, Mask, blank, line, paint
from host.monitor.track import Line, Track

FUSED = "bold cyan"
GNSS = "yellow"
ARROWS = "↑↗→↘↓↙←↖"
SMALLEST_SPAN_M = 20.0
NICE = (1, 2, 5)


class TrackMap:
    """Draws a track; draws again only what has changed."""

    def __init__(self) -> None:
        self._drawn: tuple[object, list[Text]] | None = None

    def lines(self, track: Track, width: int, height: int) -> list[Text]:
        """`height` lines of `width` characters, the last one the scale."""
        now = track.fused.now or track.gnss.now
        if now is None or width < 4 or height < 3:
            return [Text("no position yet", "dim")]
        key = (track.version, width, height, now, track.yaw)
        if self._drawn is None or self._drawn[0] != key:
            self._drawn = key, _draw(track, now, width, height)
        return self._drawn[1]


def _draw(track: Track, now: tuple[float, float], width: int, height: int) -> list[Text]:
    rows, columns = (height - 1) * DOWN, width * ACROSS
    points = np.array([*track.fused.points, *track.gnss.points, now])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    spans = np.maximum(high - low, SMALLEST_SPAN_M)
    metres_a_dot = float(max(spans[0] / (rows - 2), spans[1] / (columns - 2)))

    def place(points: list[tuple[float, float]]) -> list[tuple[int, int]]:
        scaled = (np.array(points) - middle) / metres_a_dot
        row = np.rint((rows - 1) / 2 - scaled[:, 0]).astype(int)
        column = np.rint((columns - 1) / 2 + scaled[:, 1]).astype(int)
        return list(zip(row.tolist(), column.tolist(), strict=True))

    def layer(way: Line, joined: bool) -> Mask:
        dots = blank(width, height - 1)
        ends = [end for end, _ in groupby(place(way.points))] if way.points else []
        for row, column in ends:
            dots[row, column] = True
        for start, end in pairwise(ends) if joined else ():
            if max(abs(end[0] - start[0]), abs(end[1] - start[1])) > 1:
                line(dots, start, end)
        return dots

    layers = [(layer(track.gnss, False), GNSS), (layer(track.fused, True), FUSED)]
    ((row, column),) = place([now])
    arrow = ARROWS[round(track.yaw / (math.pi / 4)) % 8] if track.fused.now else "+"
    marks = {(row // DOWN, column // ACROSS): (arrow, "bold white")}
    return [*paint(layers, marks), _scale(metres_a_dot * ACROSS, width)]


def _scale(metres_a_sign: float, width: int) -> Text:
    """A bar of a round length, at most a third of the width."""
    wanted = metres_a_sign * max(width // 3, 3)
    power = 10.0 ** math.floor(math.log10(wanted))
    length = max(n * power for n in NICE if n * power <= wanted)
    signs = max(round(length / metres_a_sign), 2)
    told = f"{length:g} m" if length < 1000 else f"{length / 1000:g} km"
    bar = "├" + "─" * (signs - 2) + "┤"
    key: list[tuple[str, str]] = [("  fused", FUSED), (" GNSS", GNSS)]
    if len(bar) + len(told) + 13 > width:
        key = []
    return Text.assemble(bar, " ", told, *key, no_wrap=True)
