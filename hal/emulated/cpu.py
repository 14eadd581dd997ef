"""An emulated processor: firmware in a greenlet, nested prioritised interrupts, work that takes cycles.

The first processor of a machine takes events off the queue itself while it works or sleeps, so that a
board with one processor never switches greenlets. Further processors park (one switch) whenever an event
is due before their work ends.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from greenlet import getcurrent, greenlet

from hal.emulated.interrupt_line import EmulatedLine, LineSpec
from hal.emulated.virtual_time import FAR, SECOND, VirtualTime

INTERRUPT_ENTRY_CYCLES = 12
"""Cortex-M exception entry; taken once for entry and exit together with tail-chaining ignored."""

ACCESS_CYCLES = 12
"""A read of a peripheral register over the bus matrix, so that polling lets time pass."""

POLL_LIMIT = 5_000_000
"""Register reads in one task without anything else happening: a loop that will not end."""

TRACE_LENGTH = 4000


class SpinError(RuntimeError):
    """The firmware waits in a loop for something that does not come."""


class PowerOff(BaseException):
    """Unwinds the firmware when the run ends. Firmware must not catch BaseException."""


class ProcessorReset(BaseException):
    """Unwinds the firmware to its reset vector."""


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
    ) -> None:
        self.time = time
        self.name = name
        self.frequency_hz = frequency_hz
        self.crystal_error_ppb = crystal_error_ppb
        self.costs = dict(costs or {})
        self.pending = 0
        self.open_lines = 0
        self.parked = False
        self.reset_cause = "power-on"
        self.resets: list[tuple[int, str]] = []
        self.stack_worst_bytes = 0
        self.trace: list[tuple[int, int, int]] | None = None
        """(bit of the line, start, end) in ns, while recording; at most TRACE_LENGTH entries."""
        self._enabled = 0
        self._carry = 0
        self._boot_ns = 0
        self._polls = 0
        self._nested_ns = 0
        self._stack_bytes = 0
        self._running: EmulatedLine | None = None
        self._owner: greenlet | None = None
        self._greenlet: greenlet | None = None
        self._reset_request: str | None = None
        self._entry_ns = INTERRUPT_ENTRY_CYCLES * SECOND // frequency_hz
        self._access_ns = -(-ACCESS_CYCLES * SECOND // frequency_hz)
        self.lines = self._make_lines(lines)
        self._by_bit = {line.bit: line for line in self.lines.values()}

    def _make_lines(self, specs: Sequence[LineSpec]) -> dict[str, EmulatedLine]:
        ordered = sorted(specs, key=lambda spec: spec.priority)
        lines = {spec.name: EmulatedLine(self, spec, 1 << rank) for rank, spec in enumerate(ordered)}
        for line in lines.values():
            line.above = sum(o.bit for o in lines.values() if o.spec.priority < line.spec.priority)
        return lines

    # -- what the firmware sees ------------------------------------------------------------------

    def cost(self, work: str) -> int:
        """Cycles budgeted for a named piece of work."""
        if work not in self.costs:
            known = ", ".join(sorted(self.costs)) or "none"
            raise KeyError(f"no cost named {work!r} for processor {self.name!r}; the board names: {known}")
        return self.costs[work]

    def attach(self, name: str, handler: Callable[[], None]) -> EmulatedLine:
        """Install a handler on a line of the board description and enable it."""
        if name not in self.lines:
            known = ", ".join(sorted(self.lines)) or "none"
            raise KeyError(f"no line named {name!r} on processor {self.name!r}; the board names: {known}")
        line = self.lines[name]
        line.handler = handler
        line.enable()
        return line

    def now_ns(self) -> int:
        """Time since reset by this processor's crystal."""
        self.poll()
        elapsed = self.time.now - self._boot_ns
        return elapsed + elapsed * self.crystal_error_ppb // SECOND

    def spend(self, cycles: int) -> None:
        """Let the time of `cycles` pass; being interrupted makes it longer."""
        carry = self._carry + cycles * SECOND
        duration = carry // self.frequency_hz
        self._carry = carry - duration * self.frequency_hz
        time = self.time
        end = time.now + duration
        if end < time.next_due and end < time.horizon:
            time.now = end
        else:
            self._pass_until(end, stretch=True)

    def delay(self, duration_ns: int) -> None:
        """Busy-wait."""
        self.wait_until(self.time.now + duration_ns)

    def wait_for_interrupt(self) -> None:
        """Sleep until at least one handler has run."""
        self._polls = 0
        if self.pending & self.open_lines:
            self.serve()
            return
        time = self.time
        if self._owner is not None:
            self._park_until(FAR)
        else:
            while not self.pending & self.open_lines:
                time.run_next()
                if self._reset_request is not None:
                    self._raise_reset()
        self.serve()

    # -- what the emulated peripherals use ---------------------------------------------------------

    def wait_until(self, end_ns: int) -> None:
        """Let time pass to `end_ns` whatever interrupts do meanwhile (a wire at work, a busy-wait)."""
        time = self.time
        if end_ns < time.next_due and end_ns < time.horizon:
            if end_ns > time.now:
                time.now = end_ns
        else:
            self._pass_until(end_ns, stretch=False)

    def poll(self) -> None:
        """One read of a register: takes a few cycles, and too many of them in a row are an error."""
        self._polls += 1
        if self._polls > POLL_LIMIT:
            raise SpinError(
                f"task {self.running_name!r} on processor {self.name!r} read registers {POLL_LIMIT:,} times "
                "without an end; give its waiting loop a bound, or sleep with wait_for_interrupt()"
            )
        self.wait_until(self.time.now + self._access_ns)

    @property
    def running_name(self) -> str:
        """Name of the task at work."""
        return self._running.spec.name if self._running is not None else "main"

    def set_enabled(self, bit: int, enabled: bool) -> None:
        """Enable or disable a line for all priority levels."""
        self._enabled = self._enabled | bit if enabled else self._enabled & ~bit
        self.open_lines = self._enabled & (self._running.above if self._running is not None else -1)
        if self.pending & self.open_lines and not self.parked:
            self.serve()

    def serve(self) -> None:
        """Run the handlers of all pending lines that are more urgent than the running task."""
        while ready := self.pending & self.open_lines:
            bit = ready & -ready
            self.pending ^= bit
            self._run_handler(self._by_bit[bit])

    def _run_handler(self, line: EmulatedLine) -> None:
        time = self.time
        start = time.now
        saved = (self.open_lines, self._running, self._nested_ns, self._polls)
        self.open_lines = line.above & self._enabled
        self._running = line
        self._nested_ns = 0
        self._polls = 0
        self._stack_bytes += line.spec.stack_bytes
        if self._stack_bytes > self.stack_worst_bytes:
            self.stack_worst_bytes = self._stack_bytes
        self.wait_until(start + self._entry_ns)
        line.handler()
        elapsed = time.now - start
        self._account(line, start, elapsed - self._nested_ns)
        self._stack_bytes -= line.spec.stack_bytes
        _, self._running, nested_ns, self._polls = saved
        self._nested_ns = nested_ns + elapsed
        self.open_lines = self._enabled & (self._running.above if self._running is not None else -1)

    def _account(self, line: EmulatedLine, start: int, busy: int) -> None:
        end = self.time.now
        response = end - line.pended_at
        line.activations += 1
        line.busy_ns += busy
        if busy > line.worst_busy_ns:
            line.worst_busy_ns = busy
        if response > line.worst_response_ns:
            line.worst_response_ns = response
        if start - line.pended_at > line.worst_start_ns:
            line.worst_start_ns = start - line.pended_at
        deadline = line.spec.deadline_ns
        if deadline is not None and response > deadline:
            line.deadline_misses += 1
        if self.trace is not None and len(self.trace) < TRACE_LENGTH:
            self.trace.append((line.bit, start, end))

    # -- the passing of time -----------------------------------------------------------------------

    def _pass_until(self, end: int, stretch: bool) -> None:
        time = self.time
        while time.next_due <= end or time.horizon <= end:
            if self._owner is not None:
                self._park_until(end)
            else:
                self._run_event(end)
            if self._reset_request is not None:
                self._raise_reset()
            if self.pending & self.open_lines:
                before = time.now
                self.serve()
                if stretch:
                    end += time.now - before
            if self._owner is not None and time.now >= end:
                return
        if end > time.now:
            time.now = end

    def _run_event(self, end: int) -> None:
        """As the machine's first processor: run one event; no other processor may pass `end`."""
        time = self.time
        saved = time.horizon
        time.horizon = end
        time.run_next()
        time.horizon = saved

    def _park_until(self, end: int) -> None:
        """As a further processor: leave the queue to the first one until `end` or an interrupt."""
        assert self._owner is not None
        wake = self.time.at(end, self._resume) if end < FAR else None
        self.parked = True
        self._owner.switch()
        self.parked = False
        if wake is not None:
            wake.cancel()
        if self._reset_request is not None:
            self._raise_reset()

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

    def reset(self, cause: str) -> None:
        """Reset the processor as soon as its firmware lets time pass."""
        self._reset_request = cause
        if self.parked:
            self.rouse()

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
        cause = self._reset_request or "reset"
        self._reset_request = None
        self.pending = self._enabled = self.open_lines = 0
        self._running = None
        self._nested_ns = self._polls = self._stack_bytes = 0
        raise ProcessorReset(cause)


def switch_to_host() -> None:
    """Event callback body: hand control back to the greenlet that started the machine."""
    parent = getcurrent().parent
    assert parent is not None
    parent.switch()
