"""Commands of the SSD1325 as data: code, name, how many argument bytes follow.

Public facts: the controller's command table as the drivers of several projects use it. A command acts
when its last argument is there. Copying and scrolling by the controller itself are not modelled.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """One command; `modelled` False: what it does is left out and reported."""

    code: int
    name: str
    arguments: int = 0
    modelled: bool = True


SET_COLUMNS, SET_ROWS, CONTRAST = 0x15, 0x75, 0x81
QUARTER, HALF, FULL = 0x84, 0x85, 0x86
REMAP, START_LINE, OFFSET = 0xA0, 0xA1, 0xA2
NORMAL, ALL_ON, ALL_OFF, INVERSE = 0xA4, 0xA5, 0xA6, 0xA7
MULTIPLEX, OFF, ON = 0xA8, 0xAE, 0xAF
DRAW_OPTIONS, DRAW_RECTANGLE, COPY = 0x23, 0x24, 0x25

COMMANDS = {
    one.code: one
    for one in (
        Command(SET_COLUMNS, "SET_COLUMNS", 2),
        Command(SET_ROWS, "SET_ROWS", 2),
        Command(CONTRAST, "CONTRAST", 1),
        Command(QUARTER, "CURRENT_QUARTER"),
        Command(HALF, "CURRENT_HALF"),
        Command(FULL, "CURRENT_FULL"),
        Command(REMAP, "REMAP", 1),
        Command(START_LINE, "START_LINE", 1),
        Command(OFFSET, "OFFSET", 1),
        Command(NORMAL, "NORMAL"),
        Command(ALL_ON, "ALL_ON"),
        Command(ALL_OFF, "ALL_OFF"),
        Command(INVERSE, "INVERSE"),
        Command(MULTIPLEX, "MULTIPLEX", 1),
        Command(0xAD, "MASTER_CONFIGURATION", 1),
        Command(OFF, "OFF"),
        Command(ON, "ON"),
        Command(0xB0, "PRECHARGE_COMPENSATION", 1),
        Command(0xB1, "PHASE_LENGTH", 1),
        Command(0xB2, "ROW_PERIOD", 1),
        Command(0xB3, "CLOCK", 1),
        Command(0xB4, "PRECHARGE_LEVEL", 1),
        Command(0xB8, "GREY_TABLE", 8),
        Command(0xBC, "PRECHARGE_VOLTAGE", 1),
        Command(0xBE, "VCOMH", 1),
        Command(0xBF, "SEGMENT_LOW", 1),
        Command(0xE3, "NOTHING"),
        Command(DRAW_OPTIONS, "DRAW_OPTIONS", 1),
        Command(DRAW_RECTANGLE, "DRAW_RECTANGLE", 5),
        Command(COPY, "COPY", 6, modelled=False),
        Command(0x26, "SCROLL", 4, modelled=False),
        Command(0x2E, "SCROLL_STOP"),
        Command(0x2F, "SCROLL_START", modelled=False),
    )
}
