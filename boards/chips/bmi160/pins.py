"""INT1 and INT2: output stage, and their levels as inputs (fact sheet section 3, 0x53 and 0x54).

The net stands for a wire with a pull-up when the output is open-drain, so that a released pin reads high
there as with a push-pull stage; a pin whose output is off is low. Nothing is driven while nobody looks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from boards.chips.bmi160.interrupts import SOURCES, Interrupts, SourceBits
from boards.chips.bmi160.register_map import INT_LATCH, INT_OUT_CTRL

PIN_NAMES = ("INT1", "INT2")

_EDGE, _ACTIVE_HIGH, _OUTPUT_ENABLED = 0x01, 0x02, 0x08


class PinNet(Protocol):
    """What the chip needs of the net on one of its pins."""

    level: bool
    on_first_listener: Callable[[], None] | None

    @property
    def listened(self) -> bool:
        """Whether anybody follows the level."""
        ...

    def set(self, level: bool) -> None:
        """Drive the level."""
        ...

    def listen(self, callback: Callable[[bool, int], None]) -> None:
        """Hear of changes."""
        ...


class OutputPins:
    """The output stages."""

    def __init__(
        self, nets: Mapping[str, PinNet | None], registers: Sequence[int], interrupts: Interrupts
    ) -> None:
        self._nets = nets
        self._registers = registers
        self._interrupts = interrupts

    def control(self, pin: int) -> int:
        """The pin's nibble of INT_OUT_CTRL: edge, active high, open drain, output on."""
        return self._registers[INT_OUT_CTRL] >> 4 * pin & 0x0F

    def watched(self, wake: Callable[[], None]) -> list[int]:
        """Pins that somebody follows and that the firmware drives; the others call `wake` when needed."""
        pins = []
        for pin, name in enumerate(PIN_NAMES):
            net = self._nets.get(name)
            if net is None:
                continue
            net.on_first_listener = wake
            if net.listened and self.control(pin) & _OUTPUT_ENABLED:
                pins.append(pin)
        return pins

    def sources(self, pin: int) -> list[SourceBits]:
        """The enabled sources that drive a pin."""
        registers = self._registers
        return [source for source in SOURCES if source.enabled(registers) and source.mapped(registers, pin)]

    def active_level(self, pin: int) -> bool:
        """The electrical level of the asserted pin."""
        return bool(self.control(pin) & _ACTIVE_HIGH)

    def drive(self, time_ns: int) -> None:
        """Bring the followed nets to their levels."""
        for pin, name in enumerate(PIN_NAMES):
            net = self._nets.get(name)
            if net is None or not net.listened:
                continue
            control = self.control(pin)
            if control & _OUTPUT_ENABLED:
                asserted = self._interrupts.asserted(pin, time_ns, bool(control & _EDGE))
                net.set(asserted == self.active_level(pin))
            elif not self._is_input(pin):
                net.set(False)

    def release(self) -> None:
        """No power: all pins low."""
        for pin, name in enumerate(PIN_NAMES):
            net = self._nets.get(name)
            if net is not None and not self._is_input(pin):
                net.set(False)

    def _is_input(self, pin: int) -> bool:
        return bool(self._registers[INT_LATCH] & 0x10 << pin)


class TagInputs:
    """Levels of the pins as FIFO tag inputs, remembered until the samples they belong to are worked off."""

    def __init__(self, nets: Mapping[str, PinNet | None], registers: Sequence[int]) -> None:
        self._nets = nets
        self._registers = registers
        self._edges: dict[int, list[tuple[int, bool]]] = {}

    def follow(self, time_ns: int) -> None:
        """Begin to listen to the pins whose input is on."""
        for pin, name in enumerate(PIN_NAMES):
            net = self._nets.get(name)
            if net is None or pin in self._edges or not self._registers[INT_LATCH] & 0x10 << pin:
                continue
            edges = [(time_ns, net.level)]
            self._edges[pin] = edges
            net.listen(lambda level, when_ns, edges=edges: edges.append((when_ns, level)))  # type: ignore[misc]

    def levels(self, time_ns: int) -> int:
        """Levels at a time (INT1 bit 0, INT2 bit 1); times must not fall from call to call."""
        levels = 0
        for pin, edges in self._edges.items():
            while len(edges) > 1 and edges[1][0] <= time_ns:
                del edges[0]
            if edges[0][1] and self._registers[INT_LATCH] & 0x10 << pin:
                levels |= 1 << pin
        return levels
