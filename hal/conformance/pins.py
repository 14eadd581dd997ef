"""Checks for `hal.pins`: an output wired to an input."""

from collections.abc import Callable
from typing import Protocol

from hal.interrupts import InterruptLine
from hal.pins import Edge, InputPin, OutputPin


class PinBench(Protocol):
    """A jumper from `output` to `input`."""

    output: OutputPin
    input: InputPin

    def line(self, handler: Callable[[], None]) -> InterruptLine:
        """An interrupt line for the input with this handler."""
        ...

    def expect(self, level: bool) -> None:
        """`output.set(level)` will be called next."""
        ...

    def settle(self) -> None:
        """Wait until the level has come across, with its interrupt."""
        ...


def _drive(bench: PinBench, *levels: bool) -> None:
    for level in levels:
        bench.expect(level)
        bench.output.set(level)
        bench.settle()


def input_follows_output(bench: PinBench) -> None:
    """The level driven is the level read."""
    for level in (True, False, True, True, False):
        _drive(bench, level)
        assert bench.input.read() is level, f"reads {bench.input.read()} when driven {level}"


def edges_interrupt(bench: PinBench) -> None:
    """Exactly the chosen edges pend the line; a level that stays is none; a new choice replaces the old."""
    edges: list[Edge] = []
    chosen = Edge.RISING
    line = bench.line(lambda: edges.append(chosen))
    _drive(bench, False)
    for chosen, expected in ((Edge.RISING, 2), (Edge.FALLING, 1), (Edge.BOTH, 3)):
        edges.clear()
        bench.input.interrupt_on(chosen, line)
        _drive(bench, True, True, False, True)
        assert len(edges) == expected, f"{len(edges)} interrupts on {chosen}, expected {expected}"
        bench.input.interrupt_on(Edge.RISING, line)
        _drive(bench, False)


CHECKS: tuple[Callable[[PinBench], None], ...] = (input_follows_output, edges_interrupt)
