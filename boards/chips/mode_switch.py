"""A switch of several poles that straps a processor's mode inputs: it feels nothing and only drives nets.

What its positions are called and which levels they give is the board's matter:

    parameters = { positions = { run = [0, 0], set-up = [1, 0] }, position = "run" }
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from hal.emulated.virtual_time import VirtualTime


class PoleNet(Protocol):
    """What a pole needs of its net."""

    def set(self, level: bool) -> None:
        """Drive the level."""
        ...


class ModeSwitch:
    """One switch; its poles are the pins SW0, SW1, …"""

    feels = "none"

    def __init__(
        self,
        _time: VirtualTime,
        *,
        positions: Mapping[str, Sequence[int]],
        position: str,
        name: str = "mode switch",
    ) -> None:
        """`positions`: of each the levels of the poles. Raises ValueError."""
        self.name = name
        self.positions = tuple(positions)
        self._levels = {called: tuple(levels) for called, levels in positions.items()}
        widths = {len(levels) for levels in self._levels.values()}
        if (
            len(widths) != 1
            or widths == {0}
            or not all(level in (0, 1) for levels in self._levels.values() for level in levels)
        ):
            raise ValueError(
                f"{name}: positions = {dict(positions)!r}; each needs as many levels 0 or 1 as the switch has"
                " poles, for example { run = [0, 0], set-up = [1, 0] }"
            )
        self.pins: dict[str, PoleNet | None] = {f"SW{pole}": None for pole in range(widths.pop())}
        self._check(position)
        self.position = position

    def wired(self) -> None:
        """The nets are connected."""
        self.turn_to(self.position)

    def turn_to(self, position: str) -> None:
        """Turn it. ValueError for a position that it does not have."""
        self._check(position)
        self.position = position
        for net, level in zip(self.pins.values(), self._levels[position], strict=True):
            if net is not None:
                net.set(bool(level))

    def _check(self, position: str) -> None:
        if position not in self._levels:
            raise ValueError(
                f"{self.name}: there is no position {position!r}; there are {', '.join(self.positions)}"
            )
