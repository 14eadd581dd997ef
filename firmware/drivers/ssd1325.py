r"""SSD1325 on SPI with D/C and RES pins: set up, fill, put a block of bytes, be set right again in flight.

    D/C low    command byte, its arguments
    D/C high   bytes into the window, from left to right, then from top to bottom

A byte is two pixels of four bits, the left one high. The controller has no data output: nobody can tell
whether it is there, so nothing here waits for it or calls it missing. What can be done: `restore` ends a
command whose arguments were lost, and sets all registers anew. It clears nothing, so the picture does not
flicker; whoever draws then draws all of it again, since the supply may have failed.
"""

from __future__ import annotations

from typing import Final

from hal.cpu import Cpu
from hal.pins import OutputPin
from hal.spi import SpiDevice

WIDTH: Final = 128
HEIGHT: Final = 64
COLUMNS: Final = WIDTH // 2
"""Of bytes."""
RESET_NS: Final = 10_000
"""RES low, and the wait after it."""

NOTHING: Final = 0xE3
LONGEST_ARGUMENTS: Final = 10
"""More than any command takes: so many NOTHINGs end each of them."""
SET_COLUMNS, SET_ROWS = 0x15, 0x75
DRAW_OPTIONS, DRAW_RECTANGLE, FILLED = 0x23, 0x24, 0x01
OFF, ON = 0xAE, 0xAF

SETTINGS: Final = (
    bytes((0xA4,)),  # the memory is shown as it is
    bytes(
        (0xA0, 0x52)
    ),  # addresses to the right, left pixel in the high half, common lines from the other end
    bytes((0xA1, 0)),  # first row
    bytes((0xA2, 0x4C)),  # offset, as the panel of 2.7 inch is wired
    bytes((0xA8, HEIGHT - 1)),  # rows driven
    bytes((0x81, 0x60)),  # contrast
    bytes((0x86,)),  # full current
    bytes((0xB1, 0x22)),  # phases
    bytes((0xB2, 0x51)),  # clocks a row
    bytes((0xB3, 0x41)),  # oscillator
    bytes((0xB4, 0x03)),  # precharge
    bytes((0xBE, 0x1C)),  # V COMH
    bytes((0xBF, 0x0D)),  # V SL
)


class Ssd1325:
    """One display of 128 × 64."""

    def __init__(self, device: SpiDevice, data_pin: OutputPin, reset_pin: OutputPin, cpu: Cpu) -> None:
        self._device = device
        self._data_pin = data_pin
        self._reset_pin = reset_pin
        self._cpu = cpu

    def start(self) -> None:
        """Reset, set up, clear, and switch on: a dark picture."""
        self._reset_pin.set(False)
        self._cpu.delay(RESET_NS)
        self._reset_pin.set(True)
        self._cpu.delay(RESET_NS)
        self._command(bytes((OFF,)) + b"".join(SETTINGS))
        self.fill(0, 0, COLUMNS, HEIGHT, 0)
        self._command(bytes((ON,)))

    def restore(self) -> None:
        """Registers as `start` leaves them, whatever has happened to them."""
        self._reset_pin.set(True)
        self._command(bytes((NOTHING,)) * LONGEST_ARGUMENTS + b"".join(SETTINGS) + bytes((ON,)))

    def stop(self) -> None:
        """Dark, the panel's current off; `start` or `restore` switch it on again."""
        self._command(bytes((OFF,)))

    def fill(self, column: int, row: int, columns: int, rows: int, pair: int) -> None:
        """One byte for two pixels all over a block, by the controller. Raises ValueError outside."""
        _check_block(column, row, columns, rows)
        corners = (column, row, column + columns - 1, row + rows - 1)
        self._command(bytes((DRAW_OPTIONS, FILLED, DRAW_RECTANGLE, *corners, pair)))

    def put(self, column: int, row: int, columns: int, data: bytes | bytearray) -> None:
        """Whole rows of `columns` bytes, from byte column and row on. Raises ValueError outside."""
        rows, rest = divmod(len(data), columns) if columns > 0 else (0, 1)
        if rest:
            raise ValueError(f"{len(data)} bytes are no whole rows of {columns}")
        _check_block(column, row, columns, rows)
        window = (SET_COLUMNS, column, column + columns - 1, SET_ROWS, row, row + rows - 1)
        self._command(bytes(window))
        self._data_pin.set(True)
        self._device.transaction(bytearray(data))

    def _command(self, data: bytes) -> None:
        self._data_pin.set(False)
        self._device.transaction(bytearray(data))


def _check_block(column: int, row: int, columns: int, rows: int) -> None:
    is_inside = column >= 0 and row >= 0 and column + columns <= COLUMNS and row + rows <= HEIGHT
    if columns < 1 or rows < 1 or not is_inside:
        raise ValueError(
            f"a block of {columns} × {rows} at column {column}, row {row} does not lie in"
            f" {COLUMNS} × {HEIGHT}"
        )
