"""Which boxes stand where, by the size of the terminal and by what there is to tell."""

from __future__ import annotations

from collections.abc import Mapping

from rich.layout import Layout

from host.monitor.picture import Lines, box

NARROW = 60
WIDE, HIGH = 108, 34
"""From so many columns and rows on everything fits."""
WITH_SKY = 150
LEAST_BESIDE = 34
NARROW_ROWS = {"attitude": 11, "position": 10, "link": 9, "satellites": 10, "events": 6}

Boxes = Mapping[str, Lines]


def arranged(boxes: Boxes, width: int, height: int, receiver_only: bool) -> Layout:
    """The boxes of a board, or of a receiver alone, in `width` × `height`."""
    if width < NARROW:
        return _narrow(boxes, height)
    if receiver_only:
        return _receiver(boxes, width, height)
    if width < WIDE or height < HIGH:
        return _small(boxes, height)
    return _large(boxes, width, height)


def with_display(boxes: Boxes, width: int, size: tuple[int, int]) -> Layout:
    """The board's own display, so large (0 columns: as wide as there is room), and what the board says;
    beside it the line where there is room."""
    columns, rows = size
    shown = [box("display", boxes["display"], columns or None)]
    if columns and width >= columns + LEAST_BESIDE:
        shown.append(box("link and flags", boxes["link"]))
    return _column(_row(*shown, size=rows), box("events", boxes["events"]))


def _narrow(boxes: Boxes, height: int) -> Layout:
    """One below the other, as many as there is room for."""
    shown: list[Layout] = []
    for name, wanted in NARROW_ROWS.items():
        if height >= wanted or not shown:
            shown.append(box(name, boxes[name], min(wanted, height)))
            height -= wanted
    shown[-1].size = None
    return _column(*shown)


def _small(boxes: Boxes, height: int) -> Layout:
    """Rows of three and the events."""
    rows = [["attitude", "position", "track"], ["satellites", "link", "tasks"], ["innovations", "inertial"]]
    if height < HIGH:
        rows = [rows[0], ["satellites", "link", "tasks and innovations"]]
    events = min(max(height - 10 * len(rows), 4), 8)
    parts = [_row(*(box(name.split()[0], boxes[name]) for name in row)) for row in rows]
    return _column(*parts, box("events", boxes["events"], events))


def _receiver(boxes: Boxes, width: int, height: int) -> Layout:
    """A receiver alone has less to tell."""
    upper = _row(box("position", boxes["position"]), box("track", boxes["track"]))
    seen = [box("satellites", boxes["satellites"]), box("sky", boxes["sky"])]
    lower = _row(*seen, box("line", boxes["link"], min(34, width // 3)))
    events = [box("events", boxes["events"], 5)] if height >= 30 else []
    return _column(upper, lower, *events)


def _large(boxes: Boxes, width: int, height: int) -> Layout:
    """Three columns, of which the map has the most room, and a row of events."""
    third = max(width // 3, 38)
    left = _column(
        box("attitude", boxes["attitude"]),
        box("inertial", boxes["inertial"], 10),
        box("innovations", boxes["innovations"], 8),
        size=third,
    )
    middle = _column(
        box("position", boxes["position"], 13),
        box("link and flags", boxes["link"], 11),
        box("tasks", boxes["tasks"]),
        size=third,
    )
    sky = [box("sky", boxes["sky"])] if width >= WITH_SKY else []
    lower = _row(box("satellites", boxes["satellites"]), *sky, size=min(14, height // 3))
    right = _column(box("track", boxes["track"]), lower)
    events = 6 if height < 44 else 9
    return _column(_row(left, middle, right), box("events", boxes["events"], events))


def _row(*parts: Layout, size: int | None = None) -> Layout:
    row = Layout(size=size)
    row.split_row(*parts)
    return row


def _column(*parts: Layout, size: int | None = None) -> Layout:
    column = Layout(size=size)
    column.split_column(*parts)
    return column
