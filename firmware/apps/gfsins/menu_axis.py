"""Scale and offset of one acceleration: shown with what it reads now, and edited digit by digit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from firmware.apps.gfsins.accelerations import NOMINAL_SCALE
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.corrections import LARGEST_OFFSET, LARGEST_SCALE, LEAST_SCALE, Corrections
from firmware.apps.gfsins.menu import Choice, Item, Menu, two_ends
from firmware.apps.gfsins.sampling import Sampling

REFUSED = "outside the limits"
NOT_KEPT = "not kept in flash"
WORDS_PER_G = 2000
FACTOR_ONE = 100_000
"""A factor is edited in hundred thousandths of the nominal scale."""


def factor_of(scale: int) -> int:
    """In hundred thousandths."""
    return (scale * FACTOR_ONE + NOMINAL_SCALE // 2) // NOMINAL_SCALE


def scale_of(factor: int) -> int:
    """The scale of a factor."""
    return (factor * NOMINAL_SCALE + FACTOR_ONE // 2) // FACTOR_ONE


def factor_text(corrections: Corrections, axis: int) -> str:
    """Of the scale, as "1.00000"."""
    return f"{factor_of(int(corrections.scales[axis])) / FACTOR_ONE:.5f}"


def offset_text(corrections: Corrections, axis: int) -> str:
    """As "+12.5 mg"."""
    return f"{int(corrections.offsets[axis]) / 2:+.1f} mg"


def axis_page(axis: int, calibration: Calibration, sampling: Sampling) -> Choice:
    """The page of A1 … A9 (axis 0 … 8). What is stored acts at once, and is kept in flash."""
    corrections = calibration.corrections

    def kept(is_taken: bool) -> str:
        if not is_taken:
            return REFUSED
        return "" if calibration.keep_corrections() else NOT_KEPT

    def edit_scale(menu: Menu) -> None:
        factor = Number(
            f"A{axis + 1} scale", factor_of(LEAST_SCALE), factor_of(LARGEST_SCALE), 5, signed=False
        )
        before = factor_of(int(corrections.scales[axis]))
        menu.open(Editor(factor, before, lambda new: kept(corrections.set_scale(axis, scale_of(new)))))

    def edit_offset(menu: Menu) -> None:
        limit = LARGEST_OFFSET * 5
        offset = Number(f"A{axis + 1} offset, mg", -limit, limit, 1, signed=True, step=5)
        before = int(corrections.offsets[axis]) * 5
        menu.open(Editor(offset, before, lambda new: kept(corrections.set_offset(axis, new // 5))))

    def nominal(menu: Menu) -> None:
        corrections.set_scale(axis, NOMINAL_SCALE)
        corrections.set_offset(axis, 0)
        if not calibration.keep_corrections():
            menu.open(Choice(NOT_KEPT, [Item(lambda: "nominal until reset", Menu.back)]))

    def reading() -> str:
        return two_ends("reads", f"{sampling.means[axis] / WORDS_PER_G:+.3f} g")

    def nothing(menu: Menu) -> None:
        """The reading is only looked at."""

    return Choice(
        f"Accelerometer A{axis + 1}",
        [
            Item(lambda: two_ends("scale", factor_text(corrections, axis)), edit_scale),
            Item(lambda: two_ends("offset", offset_text(corrections, axis)), edit_offset),
            Item(lambda: "back to nominal", nominal),
            Item(reading, nothing),
        ],
    )


@dataclass(frozen=True)
class Number:
    """What is edited: a whole number of units of the last decimal, within limits."""

    title: str
    least: int
    most: int
    decimals: int
    signed: bool
    step: int = 1
    """Of the last digit."""

    def text(self, value: int) -> str:
        """With its decimals."""
        return f"{value / 10**self.decimals:{'+' if self.signed else ''}.{self.decimals}f}"


class Editor:
    """Implements `Page`: LEFT and RIGHT choose the digit, UP and DOWN turn it, OK stores, BACK does not.

    `store` tells what is wrong with it, if anything.
    """

    marked: int | None = None

    def __init__(self, number: Number, value: int, store: Callable[[int], str]) -> None:
        self._number = number
        self._value = value
        self._store = store
        self._digit = 0
        self._note = ""

    def lines(self) -> list[str]:
        """Title, value with its digit pointed at, limits, what the keys do."""
        number = self._number
        text = number.text(self._value).rjust(10)
        # the last digit stands at the end; the decimal point is no digit
        from_end = self._digit + (1 if self._digit >= number.decimals else 0)
        pointer = " " * (9 - from_end) + "^"
        limits = f"{number.text(number.least)}..{number.text(number.most)}"
        return [number.title, "", text, pointer, limits, self._note, "arrows: change", "OK: store  BACK: no"]

    def press(self, key: str, menu: Menu) -> None:
        """A key."""
        number = self._number
        self._note = ""
        if key == "BACK":
            menu.back()
        elif key == "OK":
            self._note = self._store(self._value)
            if not self._note:
                menu.back()
        elif key == "LEFT":
            self._digit = min(self._digit + 1, len(str(number.most)) - 1)
        elif key == "RIGHT":
            self._digit = max(self._digit - 1, 0)
        else:
            self._turn(1 if key == "UP" else -1)

    def _turn(self, way: int) -> None:
        number = self._number
        step = number.step if self._digit == 0 else 10**self._digit
        wanted = self._value + way * step
        if number.least <= wanted <= number.most:
            self._value = wanted
        else:
            self._note = "that is the limit"
