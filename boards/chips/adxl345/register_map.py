"""The ADXL345's registers as data (fact sheet section 2) and their named bits."""

from __future__ import annotations

from boards.chips.registers import Access, Register

DEVID, THRESH_TAP, OFSX, OFSZ, DUR, LATENT, WINDOW = 0x00, 0x1D, 0x1E, 0x20, 0x21, 0x22, 0x23
THRESH_ACT, THRESH_INACT, TIME_INACT, ACT_INACT_CTL = 0x24, 0x25, 0x26, 0x27
THRESH_FF, TIME_FF, TAP_AXES, ACT_TAP_STATUS = 0x28, 0x29, 0x2A, 0x2B
BW_RATE, POWER_CTL, INT_ENABLE, INT_MAP, INT_SOURCE, DATA_FORMAT = 0x2C, 0x2D, 0x2E, 0x2F, 0x30, 0x31
DATAX0, DATAZ1, FIFO_CTL, FIFO_STATUS = 0x32, 0x37, 0x38, 0x39

DATA_READY, SINGLE_TAP, DOUBLE_TAP, ACTIVITY = 0x80, 0x40, 0x20, 0x10
INACTIVITY, FREE_FALL, WATERMARK, OVERRUN = 0x08, 0x04, 0x02, 0x01
"""Bits of INT_ENABLE, INT_MAP and INT_SOURCE."""
DETECTED = SINGLE_TAP | DOUBLE_TAP | ACTIVITY | INACTIVITY | FREE_FALL
"""Latched by what the acceleration does, cleared by reading INT_SOURCE."""
LIVE = DATA_READY | WATERMARK | OVERRUN
"""Always shown in INT_SOURCE; cleared by reading data."""

LINK, AUTO_SLEEP, MEASURE, SLEEP = 0x20, 0x10, 0x08, 0x04
"""Bits of POWER_CTL."""
LOW_POWER = 0x10
"""Bit of BW_RATE."""
SELF_TEST, THREE_WIRE, INT_INVERT, FULL_RES, JUSTIFY_LEFT = 0x80, 0x40, 0x20, 0x08, 0x04
"""Bits of DATA_FORMAT."""
ASLEEP = 0x08
"""Bit of ACT_TAP_STATUS."""
FIFO_TRIG = 0x80
"""Bit of FIFO_STATUS."""

DATA = range(DATAX0, DATAZ1 + 1)
OFFSETS = range(OFSX, OFSZ + 1)

_R, _RW = Access.READ, Access.READ_WRITE

REGISTERS: tuple[Register, ...] = (
    Register(DEVID, "DEVID", _R, 0xE5),
    Register(THRESH_TAP, "THRESH_TAP", _RW),
    Register(OFSX, "OFSX", _RW),
    Register(0x1F, "OFSY", _RW),
    Register(OFSZ, "OFSZ", _RW),
    Register(DUR, "DUR", _RW),
    Register(LATENT, "LATENT", _RW),
    Register(WINDOW, "WINDOW", _RW),
    Register(THRESH_ACT, "THRESH_ACT", _RW),
    Register(THRESH_INACT, "THRESH_INACT", _RW),
    Register(TIME_INACT, "TIME_INACT", _RW),
    Register(ACT_INACT_CTL, "ACT_INACT_CTL", _RW),
    Register(THRESH_FF, "THRESH_FF", _RW),
    Register(TIME_FF, "TIME_FF", _RW),
    Register(TAP_AXES, "TAP_AXES", _RW, reserved=0xF0),
    Register(ACT_TAP_STATUS, "ACT_TAP_STATUS", _R),
    Register(BW_RATE, "BW_RATE", _RW, 0x0A, reserved=0xE0),
    Register(POWER_CTL, "POWER_CTL", _RW, reserved=0xC0),
    Register(INT_ENABLE, "INT_ENABLE", _RW),
    Register(INT_MAP, "INT_MAP", _RW),
    Register(INT_SOURCE, "INT_SOURCE", _R, WATERMARK),
    Register(DATA_FORMAT, "DATA_FORMAT", _RW, reserved=0x10),
    *(Register(DATAX0 + i, f"DATA{'XYZ'[i // 2]}{i % 2}", _R) for i in range(6)),
    Register(FIFO_CTL, "FIFO_CTL", _RW),
    Register(FIFO_STATUS, "FIFO_STATUS", _R),
)
