"""A scripted processor with its clock and interrupt controller."""

from __future__ import annotations

from collections.abc import Callable

from hal.interrupts import LineFigures
from hal.scripted.transcript import Transcript

QUERY_NS = 1000
"""A look at the clock takes this long, so that a loop with a time-out ends."""


class ScriptedLine:
    """Implements `hal.interrupts.InterruptLine`. Handlers run when the driver lets time pass."""

    def __init__(self, name: str, handler: Callable[[], None]) -> None:
        self.name = name
        self.handler = handler
        self.pending = False
        self.enabled = True
        self.activations = 0

    def pend(self) -> None:
        """Make the line pending."""
        self.pending = True

    def enable(self) -> None:
        """Let the line interrupt."""
        self.enabled = True

    def disable(self) -> None:
        """Hold the line back; a request meanwhile stays pending."""
        self.enabled = False


class ScriptedCpu:
    """Implements `hal.cpu.Cpu`, `hal.clock.Clock` and `hal.interrupts.InterruptController`.

    Only `delay` is a step. Time moves by delays, by `<- time NS` and by QUERY_NS a look at the clock; work
    takes none. Lines are served in the order in which they were attached.
    """

    def __init__(self, transcript: Transcript, costs: dict[str, int] | None = None) -> None:
        self._transcript = transcript
        self._costs = costs
        self._now_ns = 0
        self._lines: dict[str, ScriptedLine] = {}
        transcript.on_arrival("time", "", self._time_passes)

    def cost(self, work: str) -> int:
        """Cycles of a named piece of work: 0 unless a table was given."""
        if self._costs is None:
            return 0
        if work not in self._costs:
            raise KeyError(f"no cost named {work!r}; there are: {', '.join(sorted(self._costs)) or 'none'}")
        return self._costs[work]

    def now_ns(self) -> int:
        """Time since the transcript began."""
        self._transcript.play()
        self._now_ns += QUERY_NS
        return self._now_ns

    def spend(self, cycles: int) -> None:
        """Work takes no time here; pending handlers run."""
        self._serve()

    def delay(self, duration_ns: int) -> None:
        """A step: `delay NS`."""
        self._transcript.take(f"delay {duration_ns}")
        self._now_ns += duration_ns
        self._serve()

    def wait_for_interrupt(self) -> None:
        """Run pending handlers. Raises AssertionError when nothing comes in that could end the sleep."""
        if not self._serve():
            raise AssertionError(
                f"the driver sleeps at step {self._transcript.position + 1}, where nothing comes in"
            )

    def attach(self, name: str, handler: Callable[[], None]) -> ScriptedLine:
        """Install a handler; every name is known here, and `<- line NAME` pends it."""
        line = ScriptedLine(name, handler)
        self._lines[name] = line
        self._transcript.on_arrival("line", name, lambda _words: line.pend())
        return line

    def figures(self) -> list[LineFigures]:
        """Activations; handlers take no time here."""
        return [
            LineFigures(n, line.activations, 0, 0, 0) for n, line in self._lines.items() if line.activations
        ]

    def _time_passes(self, words: list[str]) -> None:
        self._now_ns += int(words[0])

    def _serve(self) -> bool:
        self._transcript.play()
        served = False
        while line := next((one for one in self._lines.values() if one.pending and one.enabled), None):
            line.pending = False
            line.activations += 1
            line.handler()
            served = True
        return served
