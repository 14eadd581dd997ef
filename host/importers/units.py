"""Units that columns of recordings come in, and `--unit QUANTITY=UNIT`.

A factor takes a value into the unit of the capture's topics: °/s, m/s², degrees, m, m/s, µT, °C.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from boards.hints import did_you_mean
from host.record.errors import UserError

STANDARD_GRAVITY = 9.80665
DEGREES = 180.0 / math.pi

ANGLES = {"deg": 1.0, "rad": DEGREES}
LENGTHS = {"m": 1.0, "ft": 0.3048, "km": 1000.0}
SPEEDS = {"m/s": 1.0, "km/h": 1.0 / 3.6, "kn": 1852.0 / 3600.0, "ft/s": 0.3048}

QUANTITIES: dict[str, dict[str, float]] = {
    "gyro": {"deg/s": 1.0, "rad/s": DEGREES, "mdeg/s": 1e-3},
    "accel": {"m/s2": 1.0, "g": STANDARD_GRAVITY, "mg": STANDARD_GRAVITY * 1e-3},
    "position": ANGLES,
    "height": LENGTHS,
    "velocity": SPEEDS,
    "attitude": ANGLES,
    "accuracy": LENGTHS,
    "mag": {"uT": 1.0, "G": 100.0, "mG": 0.1, "nT": 1e-3},
    "temperature": {"degC": 1.0},
}
"""Units of each quantity with their factors."""


@dataclass(frozen=True, slots=True)
class Unit:
    """What a quantity of a recording is measured in."""

    quantity: str
    name: str
    stated: bool = False
    """By the user, for this import: not doubted any more."""

    @property
    def factor(self) -> float:
        """Into the unit of the topics."""
        return QUANTITIES[self.quantity][self.name]


class Units:
    """What was said with `--unit`."""

    def __init__(self, stated: Iterable[str] = ()) -> None:
        """`stated`: texts QUANTITY=UNIT. Raises UserError."""
        self._stated: dict[str, str] = {}
        self._used: set[str] = set()
        for text in stated:
            quantity, _, name = text.partition("=")
            if quantity not in QUANTITIES:
                hint = did_you_mean(quantity, QUANTITIES)
                raise UserError(f"--unit {text}: no such quantity; {hint}; for example --unit gyro=deg/s")
            if name not in QUANTITIES[quantity]:
                known = ", ".join(QUANTITIES[quantity])
                raise UserError(
                    f"--unit {text}: {quantity} may be in {known}; --unit {quantity}={_first(quantity)}"
                )
            self._stated[quantity] = name

    def of(self, quantity: str, named: str) -> Unit:
        """The unit of a quantity that the recording itself says is in `named`."""
        self._used.add(quantity)
        if quantity in self._stated:
            return Unit(quantity, self._stated[quantity], stated=True)
        return Unit(quantity, named)

    def check_used(self, kind: str) -> None:
        """Raises UserError for a quantity that this kind of recording does not leave open."""
        for quantity in self._stated:
            if quantity not in self._used:
                known = ", ".join(sorted(self._used)) or "nothing"
                raise UserError(
                    f"--unit {quantity}={self._stated[quantity]}: {kind} has no such column here; "
                    f"units may be stated of: {known}"
                )


def _first(quantity: str) -> str:
    return next(iter(QUANTITIES[quantity]))
