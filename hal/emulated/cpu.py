"""An emulated processor: firmware in a greenlet, nested prioritised interrupts, work that takes cycles.

The first processor of a machine takes events off the queue itself while it works or sleeps, so that a
board with one processor never switches greenlets. Further processors park (one switch) whenever an event
is due before their work ends.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final, SupportsIndex

from greenlet import getcurrent, greenlet

from hal.board_io import NotNamedError
from hal.emulated.interrupt_line import NEVER_YET, EmulatedLine, LineSpec
from hal.emulated.virtual_time import FAR, SECOND, VirtualTime
from hal.emulated.whole_number import whole_number
from hal.endings import ProcessorReset, SpinError
from hal.interrupts import LineFigures

INTERRUPT_ENTRY_CYCLES: Final = 12
"""Cortex-M exception entry; taken once for entry and exit together with tail-chaining ignored."""

ACCESS_CYCLES: Final = 12
"""A read of a peripheral register over the bus matrix, so that polling lets time pass."""

POLL_LIMIT = 5_000_000
"""Register reads in one task without anything else happening: a loop that will not end."""

TRACE_LENGTH: Final = 4000

THREAD_PRIORITY: Final = 1 << 30
"""Less urgent than every line."""

RESET_BIT: Final = 1
"""The reset request, as a line more urgent than all others that nothing can mask."""


class EmulatedCpu:
    """One core. Implements `hal.cpu.Cpu`, `hal.clock.Clock` and `hal.interrupts.InterruptController`."""

    def __init__(
        self,
        time: VirtualTime,
        name: str,
        frequency_hz: int,
        lines: Sequence[LineSpec] = (),
        costs: Mapping[str, int] | None = None,
        crystal_error_ppb: int = 0,
        interrupt_entry_cycles: int = INTERRUPT_ENTRY_CYCLES,
    ) -> None:
        self.time = time
        self.name = name
        self.frequency_hz = frequency_hz
        self._round_up = frequency_hz - 1
        self.crystal_error_ppb = crystal_error_ppb
        self._fast_ppb = max(crystal_error_ppb, 0)
        self._slow_ppb = max(-crystal_error_ppb, 0)
        self.costs = dict(costs or {})
        self.pending = 0
        self.parked = False
        self.reset_cause = "power-on"
        self.resets: list[tuple[int, str]] = []
        self.trace: list[tuple[int, int, int]] | None = None
        """(bit of the line, start, end) in ns, from `start_trace` on; at most TRACE_LENGTH entries."""
        self.tracing = False
        self.reset_hooks: list[Callable[[], None]] = []
        """Called when the processor resets: every peripheral falls back to its state after power-on."""
        self._enabled = 0
        self._boot_ns = 0
        self._polls = POLL_LIMIT
        """Register reads left until something else has to happen."""
        self._owner: greenlet | None = None
        self._greenlet: greenlet | None = None
        self._reset_cause = ""
        """ns that the processor's clock shows in a second."""
        self._entry_ns = self._duration(interrupt_entry_cycles)
        self._access_ns = self._duration(ACCESS_CYCLES)
        self.lines = self._make_lines(lines)
        self._all_lines = [self._reset_line(), *self.lines.values()]
        self._most_urgent: dict[int, EmulatedLine] = {}
        """By the bits of all lines that are ready."""
        self._main = EmulatedLine(self, LineSpec("main", THREAD_PRIORITY), 0)
        self._main.open = RESET_BIT
        self.running = self._main
        """Whose code runs: a line's handler, or the thread that all lines may interrupt."""

    def _make_lines(self, specs: Sequence[LineSpec]) -> dict[str, EmulatedLine]:
        ordered = sorted(specs, key=lambda spec: spec.priority)
        lines = {spec.name: EmulatedLine(self, spec, 2 << rank) for rank, spec in enumerate(ordered)}
        for line in lines.values():
            more_urgent = [o.bit for o in lines.values() if o.spec.priority < line.spec.priority]
            line.above = RESET_BIT | sum(more_urgent)
            line.open = RESET_BIT
        return lines

    def _reset_line(self) -> EmulatedLine:
        line = EmulatedLine(self, LineSpec("reset", -1), RESET_BIT)
        line.handler = self._raise_reset
        return line

    def _duration(self, cycles: int) -> int:
        """ns that `cycles` take, rounded up to whole ns."""
        return -(-cycles * SECOND // self.frequency_hz)

    @property
    def stack_worst_bytes(self) -> int:
        """Worst case of the stack: at every priority the deepest task, each nested in the next."""
        deepest: dict[int, int] = {}
        for line in self.lines.values():
            spec = line.spec
            deepest[spec.priority] = max(deepest.get(spec.priority, 0), spec.stack_bytes)
        return sum(deepest.values())

    # -- what the firmware sees ------------------------------------------------------------------

    def cost(self, work: str) -> int:
        """Cycles budgeted for a named piece of work."""
        if work not in self.costs:
            raise NotNamedError(f"processors.{self.name}.costs", work, self.costs)
        return self.costs[work]

    def attach(self, name: str, handler: Callable[[], None]) -> EmulatedLine:
        """Install a handler on a line of the board description and enable it."""
        if name not in self.lines:
            raise NotNamedError(f"processors.{self.name}.tasks", name, self.lines)
        line = self.lines[name]
        line.handler = handler
        line.enable()
        return line

    def figures(self) -> list[LineFigures]:
        """Figures of all lines, the most urgent first; looking takes no time."""
        return [
            LineFigures(name, line.activations, line.busy_ns, line.worst_response_ns, line.deadline_misses)
            for name, line in self.lines.items()
            if line.activations
        ]

    def now_ns(self) -> int:
        """Time since reset by this processor's crystal."""
        time = self.time
        now = time.now + self._access_ns
        polls = self._polls
        if polls and now < time.limit:
            self._polls = polls - 1
            time.now = now
        else:
            self._poll_slowly()
            now = time.now
        return self.clock_at(now)

    def clock_at(self, time_ns: int) -> int:
        """What this processor's clock shows at a virtual time (a capture unit's latch, without an access)."""
        if self._boot_ns:
            time_ns -= self._boot_ns
        whole, rest = time_ns // SECOND, time_ns % SECOND  # so that no product leaves a register
        if self._fast_ppb:
            return time_ns + whole * self._fast_ppb + rest * self._fast_ppb // SECOND
        return time_ns - whole * self._slow_ppb - (rest * self._slow_ppb + SECOND - 1) // SECOND

    def start_trace(self) -> None:
        """Record the next TRACE_LENGTH activations in `trace`; meanwhile none of them is an ordinary one."""
        self.trace = []
        self.tracing = True
        for line in self._all_lines:
            line.expect(NEVER_YET)

    def trace_activation(self, bit: int, took: int) -> None:
        """An activation of `took` ns ends now."""
        assert self.trace is not None
        end = self.time.now
        self.trace.append((bit, end - took, end))
        self.tracing = len(self.trace) < TRACE_LENGTH

    def virtual_ns(self, clock_ns: int) -> int:
        """The virtual time at which this processor's clock showed `clock_ns` (since its last reset)."""
        return self._boot_ns + clock_ns * SECOND // (SECOND + self.crystal_error_ppb)

    def spend(self, cycles: SupportsIndex) -> None:
        """Let the time of `cycles` pass, rounded up to ns; being interrupted makes it longer."""
        time = self.time
        count = cycles if isinstance(cycles, int) else whole_number(cycles, "cycles to spend")
        end = time.now + (count * SECOND + self._round_up) // self.frequency_hz
        if end < time.limit:
            time.now = end
        else:
            self._pass_until(end, stretch=True)

    def delay(self, duration_ns: SupportsIndex) -> None:
        """Busy-wait."""
        self.wait_until(self.time.now + whole_number(duration_ns, "delay in ns"))

    def wait_for_interrupt(self) -> None:
        """Sleep until at least one handler has run.

        Most events and activations of a board happen here, so `VirtualTime.run_next` and `serve` stand
        inline; what the thread itself is interrupted by need not be counted.
        """
        self._polls = POLL_LIMIT
        running = self.running
        if self._owner is not None:
            while not self.pending & running.open:
                self._park_until(FAR)
        time = self.time
        heap = time.heap
        while not self.pending & running.open:
            entry = heap[0]
            callback = entry[3]
            if callback is None:
                time.drop_first()
                continue
            time.now = now = entry[0]
            again: object = callback()
            if isinstance(again, int) and now <= again < time.second_due:
                entry[0] = time.next_due = time.limit = again
                time.repeated += 1
            else:
                time.put_away(entry, again)
        if running.bit:
            self.serve()
            return
        while ready := self.pending & running.open:
            try:
                line = self._most_urgent[ready]
            except KeyError:
                line = self._find_most_urgent(ready)
            self.pending ^= line.bit
            self.running = line
            start = time.now
            entered = start + self._entry_ns
            if entered < time.limit:
                time.now = entered
            else:
                self._pass_until(entered, stretch=False)
            handler = line.handler
            handler()
            took = time.now - start
            if took == line.usual_ns and line.pended_at == start and not line.nested_ns:
                line.repeats += 1
            else:
                line.account(start - line.pended_at, took)
        self.running = running

    # -- what the emulated peripherals use ---------------------------------------------------------

    def wait_until(self, end_ns: int) -> None:
        """Let time pass to `end_ns` whatever interrupts do meanwhile (a wire at work, a busy-wait)."""
        time = self.time
        if end_ns < time.limit:
            if end_ns > time.now:
                time.now = end_ns
        else:
            self._pass_until(end_ns, stretch=False)

    def poll(self) -> None:
        """One read of a register: takes a few cycles, and too many of them in a row are an error."""
        time = self.time
        now = time.now + self._access_ns
        polls = self._polls
        if polls and now < time.limit:
            self._polls = polls - 1
            time.now = now
        else:
            self._poll_slowly()

    def _poll_slowly(self) -> None:
        """The same where something is due meanwhile, or the limit is reached."""
        if not self._polls:
            raise SpinError(
                f"task {self.running_name!r} on processor {self.name!r} read registers {POLL_LIMIT:,} times "
                "without an end; give its waiting loop a bound, or sleep with wait_for_interrupt()"
            )
        self._polls -= 1
        self.wait_until(self.time.now + self._access_ns)

    @property
    def running_name(self) -> str:
        """Name of the task at work."""
        return self.running.spec.name

    def set_enabled(self, bit: int, enabled: bool) -> None:
        """Enable or disable a line for all priority levels."""
        self._enabled = self._enabled | bit if enabled else self._enabled & ~bit
        self._main.open = self._enabled | RESET_BIT
        for line in self.lines.values():
            line.open = line.above & self._main.open
        if self.pending & self.running.open and not self.parked:
            self.serve()

    def serve(self) -> None:
        """Run the handlers of all pending lines that are more urgent than the running task.

        An activation that began at the instant of its request and went like the one
        before, undisturbed, is only counted.
        """
        time = self.time
        begin = time.now
        outer = self.running
        while ready := self.pending & outer.open:
            try:
                line = self._most_urgent[ready]
            except KeyError:
                line = self._find_most_urgent(ready)
            self.pending ^= line.bit
            self.running = line
            start = time.now
            entered = start + self._entry_ns
            if entered < time.limit:
                time.now = entered
            else:
                self._pass_until(entered, stretch=False)
            handler = line.handler  # by a name of its own: a call of what a slot holds is slow
            handler()
            took = time.now - start
            if took == line.usual_ns and line.pended_at == start and not line.nested_ns:
                line.repeats += 1
            else:
                line.account(start - line.pended_at, took)
        self.running = outer
        if outer.bit:
            outer.nested_ns += time.now - begin

    def _find_most_urgent(self, ready: int) -> EmulatedLine:
        """The first of the lines whose bits are set; found once for each set."""
        line = next(line for line in self._all_lines if line.bit & ready)
        self._most_urgent[ready] = line
        return line

    # -- the passing of time -----------------------------------------------------------------------

    def _pass_until(self, end: int, stretch: bool) -> None:
        """Let time pass to `end`, with events and interrupts on the way; `stretch`: those delay the end."""
        time = self.time
        if self._owner is not None:
            self._pass_parked(end, stretch)
            return
        while time.next_due <= end:
            time.run_next_before(end)
            if self.pending & self.running.open:
                before = time.now
                self.serve()
                if stretch:
                    end += time.now - before
        if end > time.now:
            time.now = end

    def _pass_parked(self, end: int, stretch: bool) -> None:
        """The same for a further processor, which leaves the queue to the first one."""
        time = self.time
        while True:
            if self.pending & self.running.open:
                before = time.now
                self.serve()
                if stretch:
                    end += time.now - before
            if time.now >= end:
                return
            if end < time.limit:
                time.now = end
                return
            self._park_until(end)

    def _park_until(self, end: int) -> None:
        """As a further processor: leave the queue to the first one until `end` or an interrupt."""
        assert self._owner is not None
        wake = self.time.at(end, self._resume) if end < FAR else None
        self.parked = True
        self._owner.switch()
        self.parked = False
        if wake is not None:
            wake.cancel()

    def _resume(self) -> None:
        """Event: let this processor's firmware go on."""
        assert self._greenlet is not None
        self.time.release_running()
        if self.parked:
            self._greenlet.switch()

    def rouse(self) -> None:
        """Wake a parked processor for an interrupt, at once but outside the present event."""
        self.time.at(self.time.now, self._resume)

    # -- power and reset ---------------------------------------------------------------------------

    def boot(self, program: Callable[[], None], owner: greenlet | None = None) -> greenlet:
        """Prepare the greenlet that runs `program` from reset. `owner`: None for the first processor."""
        self._owner = owner
        self._greenlet = greenlet(lambda: self._reset_vector(program))
        return self._greenlet

    def start(self) -> None:
        """Let a further processor leave reset as an event at the present instant."""
        self.parked = True
        self.time.at(self.time.now, self._resume)

    def reset(self, cause: str) -> None:
        """Reset the processor as soon as its firmware lets time pass."""
        self._reset_cause = cause
        self.pending |= RESET_BIT
        if self.parked:
            self.rouse()
        elif self.time.next_due > self.time.now:
            self.time.look_now()

    def _reset_vector(self, program: Callable[[], None]) -> None:
        while True:
            try:
                program()
                while True:
                    self.wait_for_interrupt()
            except ProcessorReset as reset:
                self.resets.append((self.time.now, str(reset)))
                self.reset_cause = str(reset)
                self._boot_ns = self.time.now

    def _raise_reset(self) -> None:
        """Handler of the reset request: forget everything and unwind the firmware."""
        for hook in self.reset_hooks:
            hook()
        self.pending = self._enabled = 0
        for line in self.lines.values():
            line.open = RESET_BIT
            line.nested_ns = 0
        self._main.open = RESET_BIT
        self.running = self._main
        self._polls = POLL_LIMIT
        raise ProcessorReset(self._reset_cause)


def switch_to_host() -> None:
    """Event callback body: hand control back to the greenlet that started the machine."""
    parent = getcurrent().parent
    assert parent is not None
    parent.switch()
