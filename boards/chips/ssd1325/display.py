"""SSD1325 on SPI: commands with D/C low, picture data with D/C high, and the picture that one would see.

The memory has 80 rows of 64 bytes, two pixels of 4 bits each; a byte goes to the place of the pointer, which
runs through the window of columns and rows. Re-map (0xA0): bit 0 mirrors the columns (of bytes), bit 1 puts
the left pixel into the high half, bit 2 moves down first, bit 4 counts the common lines from the other end:

    line k shows row (k + offset + start) mod 80, or row (79 − k + offset + start) mod 80

Row 0 of the glass hangs on line `first_common`, the next on the one before. Left out: current, voltages,
timing of the panel, the grey table (levels are shown as they are), odd-even split of the rows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from boards.chips.registers import AccessLog, AccessReport, ReportKind
from boards.chips.ssd1325 import commands as cmd
from hal.emulated.virtual_time import VirtualTime

WIDTH, HEIGHT = 128, 64
ROWS, COLUMNS = 80, 64
FASTEST_BIT_NS = 100
"""10 MHz on the serial interface."""
FIRST_COMMON = 75
"""Of Newhaven's panel of 2.7 inch: upright with re-map 0x5X and offset 0x4C. That of Osram's has 63."""
MIRROR_COLUMNS, SWAP_PIXELS, DOWN_FIRST, MIRROR_ROWS = 1, 2, 4, 16
BRIGHTEST = 15


class InputNet(Protocol):
    """What the display needs of the net on its D/C pin."""

    level: bool


@runtime_checkable
class ListenedNet(Protocol):
    """A net that tells of its edges."""

    def listen(self, callback: Callable[[bool, int], None]) -> None:
        """Call `callback(level, time_ns)` at every change."""
        ...


class Ssd1325:
    """The controller with a panel of 128 × 64."""

    feels = "none"
    spi_modes = (0, 3)

    def __init__(
        self,
        time: VirtualTime,
        *,
        strict: bool = False,
        name: str = "ssd1325",
        first_common: int = FIRST_COMMON,
    ) -> None:
        """`first_common`: the line on which the uppermost row of the glass hangs. Raises ValueError."""
        if not 0 <= first_common < ROWS:
            raise ValueError(
                f"{name}: first_common = {first_common}; a line is 0 … {ROWS - 1}, for example 75"
            )
        self._first_common = first_common
        self.name = name
        self.log = AccessLog(name, strict=strict)
        self.pins: dict[str, InputNet | None] = {"DC": None, "RES": None}
        self._time = time
        self.powered = True
        self._reset()

    def wired(self) -> None:
        """The nets are connected: RES acts at once, also between transfers."""
        reset = self.pins["RES"]
        if isinstance(reset, ListenedNet):
            reset.listen(self._on_reset_pin)

    def _on_reset_pin(self, level: bool, _time_ns: int) -> None:
        if not level:
            self._reset()

    @property
    def reports(self) -> list[AccessReport]:
        """Accesses outside the command table or the model."""
        return self.log.reports

    def power(self, on: bool) -> None:
        """Switch the supply; what was in the memory is gone."""
        if on != self.powered:
            self.powered = on
            self._reset()

    def _reset(self) -> None:
        self._memory = np.zeros((ROWS, COLUMNS), np.uint8)
        self._waiting: list[int] = []
        self._columns, self._rows = (0, COLUMNS - 1), (0, ROWS - 1)
        self._column = self._row = 0
        self._remap = self._start = self._offset = 0
        self._lines = ROWS
        self._mode = cmd.NORMAL
        self._on = False
        self.contrast = 0x40
        self._fill = False

    # -- bus ---------------------------------------------------------------------------------------

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        """One chip-select low period; the display has no data output."""
        if 0 < end_ns - start_ns < 8 * FASTEST_BIT_NS * len(mosi) - 1:
            self.log.report(
                ReportKind.TIMING, "SPI", "clock faster than 10 MHz, served all the same", start_ns
            )
        reset, data = self.pins["RES"], self.pins["DC"]
        if reset is not None and not reset.level:
            self._reset()
        elif self.powered:
            if data is not None and data.level:
                for byte in mosi:
                    self._put(byte)
            else:
                for byte in mosi:
                    self._command(byte, start_ns)
        return b"\xff" * len(mosi)

    def _command(self, byte: int, time_ns: int) -> None:
        self._waiting.append(byte)
        known = cmd.COMMANDS.get(self._waiting[0])
        if known is None:
            self.log.report(
                ReportKind.UNDOCUMENTED_ADDRESS, f"0x{byte:02X}", "no command of the SSD1325", time_ns
            )
            self._waiting = []
        elif len(self._waiting) > known.arguments:
            arguments, self._waiting = self._waiting[1:], []
            if not known.modelled:
                self.log.report(ReportKind.NOT_MODELLED, known.name, "moves nothing here", time_ns)
            self._obey(known, arguments, time_ns)

    def _obey(self, command: cmd.Command, arguments: list[int], time_ns: int) -> None:
        code = command.code
        if code == cmd.SET_COLUMNS:
            self._columns = self._window(command, arguments, COLUMNS, self._columns, time_ns)
            self._column = self._columns[0]
        elif code == cmd.SET_ROWS:
            self._rows = self._window(command, arguments, ROWS, self._rows, time_ns)
            self._row = self._rows[0]
        elif code == cmd.CONTRAST:
            self.contrast = arguments[0] & 0x7F
        elif code == cmd.REMAP:
            self._remap = arguments[0]
        elif code == cmd.START_LINE:
            self._start = arguments[0] % ROWS
        elif code == cmd.OFFSET:
            self._offset = arguments[0] % ROWS
        elif code == cmd.MULTIPLEX:
            self._lines = max(16, min(ROWS, (arguments[0] & 0x7F) + 1))
        elif cmd.NORMAL <= code <= cmd.INVERSE:
            self._mode = code
        elif code in (cmd.ON, cmd.OFF):
            self._on = code == cmd.ON
        elif code == cmd.DRAW_OPTIONS:
            self._fill = bool(arguments[0] & 1)
        elif code == cmd.DRAW_RECTANGLE:
            self._rectangle(arguments)

    def _window(
        self, command: cmd.Command, arguments: list[int], limit: int, before: tuple[int, int], time_ns: int
    ) -> tuple[int, int]:
        first, last = arguments
        if first > last or last >= limit:
            detail = f"{first} … {last} is no window of {limit}; the one before stays"
            self.log.report(ReportKind.RESERVED_VALUE, command.name, detail, time_ns)
            return before
        return first, last

    def _rectangle(self, arguments: list[int]) -> None:
        left, top, right, bottom, shade = arguments
        rows, columns = slice(top, bottom + 1), slice(left, right + 1)
        if self._fill:
            self._memory[rows, columns] = shade
            return
        self._memory[[row for row in (top, bottom) if row < ROWS], columns] = shade
        self._memory[rows, [column for column in (left, right) if column < COLUMNS]] = shade

    def _put(self, byte: int) -> None:
        self._memory[self._row, self._column] = byte
        if self._remap & DOWN_FIRST:
            self._row += 1
            if self._row > self._rows[1]:
                self._row = self._rows[0]
                self._column = self._next(self._column, self._columns)
            return
        self._column += 1
        if self._column > self._columns[1]:
            self._column = self._columns[0]
            self._row = self._next(self._row, self._rows)

    @staticmethod
    def _next(place: int, window: tuple[int, int]) -> int:
        return window[0] if place >= window[1] else place + 1

    # -- what one sees -----------------------------------------------------------------------------

    def picture(self) -> NDArray[np.uint8]:
        """(64, 128) grey levels 0 … 15 from the top left; dark while the display is off."""
        if not self._on or not self.powered or self._mode == cmd.ALL_OFF:
            return np.zeros((HEIGHT, WIDTH), np.uint8)
        if self._mode == cmd.ALL_ON:
            return np.full((HEIGHT, WIDTH), BRIGHTEST, np.uint8)
        pixels = np.empty((ROWS, WIDTH), np.uint8)
        memory = self._memory[:, ::-1] if self._remap & MIRROR_COLUMNS else self._memory
        low, high = memory & 0x0F, memory >> 4
        first, second = (high, low) if self._remap & SWAP_PIXELS else (low, high)
        pixels[:, 0::2], pixels[:, 1::2] = first, second
        common = self._first_common - np.arange(min(HEIGHT, self._lines))
        if self._remap & MIRROR_ROWS:
            common = ROWS - 1 - common
        shown = np.zeros((HEIGHT, WIDTH), np.uint8)
        shown[: len(common)] = pixels[(common + self._offset + self._start) % ROWS]
        return BRIGHTEST - shown if self._mode == cmd.INVERSE else shown

    def as_text(self) -> str:
        """The picture in characters, a line for each row: `#` for lit pixels, `.` for dark ones."""
        return "\n".join("".join("#" if level else "." for level in row) for row in self.picture())
