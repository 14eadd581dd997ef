"""A processor in real time: the firmware is a thread of this computer, and its interrupts run in it.

Firmware code is plain and blocking. Threads that read from real links never run any of it: they fill rings
and make lines pending. The handlers run in the firmware's own thread, at its *safe points*:

    every call of `Clock`, `Cpu`, `Uart`, `SpiDevice`, `I2cBus`, `CanController`, `LogFile`, pins, `pend`
    wait_for_interrupt and delay, for as long as they wait

in order of priority, nested by more urgent lines only, as on the chip. Emulated, the same calls are those
that let time pass, so firmware that is right there is right here; between two safe points nothing
interrupts it, which is longer here than there. Two things differ. `spend` takes no time: the host has
already spent its own. And nobody ends a program that runs for ever without a safe point.

Timers are alarms that run at safe points too. An expiry that comes late, because the host was busy, is made
up for, each with its own run of the handler.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from threading import Condition, RLock, get_ident

from hal.board_io import NotNamedError
from hal.endings import PowerOff, ProcessorReset
from hal.interrupts import LineFigures
from hal.live.alarms import Alarm, AlarmCallback, Alarms
from hal.live.interrupt_line import LiveLine

LOOKS_WITHOUT_REST = 64
"""Safe points in a row after which other threads get their turn: a polling loop must not starve the
threads that it waits for."""
THREAD_LEVEL = 1 << 62
"""Priority of the program outside of handlers: every line is more urgent."""


class LiveCpu:
    """Implements `hal.cpu.Cpu`, `hal.clock.Clock` and `hal.interrupts.InterruptController`.

    `lines`: priority by name, lower is more urgent; `deadlines_ns`: from the request to the end of the
    handler. `costs`: as in the board description; without it every cost is 0. The firmware's thread is the
    one that made this, or the one that calls `run`.
    """

    def __init__(
        self,
        lines: Mapping[str, int] | None = None,
        costs: Mapping[str, int] | None = None,
        deadlines_ns: Mapping[str, int] | None = None,
    ) -> None:
        self._costs = None if costs is None else dict(costs)
        deadlines = deadlines_ns or {}
        self.lines = {
            name: LiveLine(self, name, priority, deadlines.get(name))
            for name, priority in (lines or {}).items()
        }
        self._by_urgency = sorted(self.lines.values(), key=lambda line: line.priority)
        self._alarms = Alarms()
        self._changed = Condition(RLock())
        self._attention = False
        """Something may be waiting for a safe point: a line, a reset, the end."""
        self._level = THREAD_LEVEL
        self._thread = get_ident()
        self._boot_ns = time.monotonic_ns()
        self._looks = 0
        self._handled = 0
        """Handlers that have run."""
        self._nested_ns = 0
        """Time in handlers that have nested in the one that runs."""
        self._reset_cause: str | None = None
        self._ending = False
        self.reset_cause = "power-on"
        self.resets: list[tuple[int, str]] = []
        """(ns since power-on, cause) of every reset."""
        self.reset_hooks: list[Callable[[], None]] = []
        """Called when the processor resets: every peripheral falls back to its state after power-on."""
        self.worst_lateness_ns = 0
        """How late the latest alarm ran."""
        self._power_on_ns = self._boot_ns

    # -- what the firmware sees ------------------------------------------------------------------

    def cost(self, work: str) -> int:
        """Cycles budgeted for a named piece of work; spending them takes no time here."""
        if self._costs is None:
            return 0
        if work not in self._costs:
            raise NotNamedError("costs", work, self._costs)
        return self._costs[work]

    def attach(self, name: str, handler: Callable[[], None]) -> LiveLine:
        """Install a handler on a line of the board description and enable it."""
        if name not in self.lines:
            raise NotNamedError("interrupt line", name, self.lines)
        line = self.lines[name]
        line.handler = handler
        line.enable()
        return line

    def figures(self) -> list[LineFigures]:
        """Figures of the lines that have run, by the host's clock."""
        return [line.figures() for line in self._by_urgency if line.activations]

    def now_ns(self) -> int:
        """Time since reset by this computer's monotonic clock."""
        self.safe_point()
        return time.monotonic_ns() - self._boot_ns

    def spend(self, cycles: int) -> None:
        """Pending handlers run; the work itself has taken its time already."""
        self.safe_point()

    def delay(self, duration_ns: int) -> None:
        """Wait; handlers run meanwhile. Alarms due after its end wait for the next safe point."""
        end = time.monotonic_ns() + duration_ns
        while True:
            self._run_alarms(end)
            self._serve()
            left = end - time.monotonic_ns()
            if left <= 0:
                return
            self._rest(left)

    def wait_for_interrupt(self) -> None:
        """Sleep until at least one handler has run."""
        before = self._handled
        while self._handled == before:
            self._run_alarms(time.monotonic_ns())
            self._serve()
            if self._handled == before:
                self._rest(None)

    # -- what the live peripherals use -----------------------------------------------------------

    def safe_point(self) -> None:
        """Run what is due: alarms and pending handlers more urgent than what runs. Elsewhere than in the
        firmware's thread: nothing."""
        if get_ident() != self._thread:
            return
        self._looks += 1
        if self._looks >= LOOKS_WITHOUT_REST:
            self._looks = 0
            time.sleep(0)
        self._run_alarms(time.monotonic_ns())
        if self._attention:
            self._serve()

    def clock_at(self, monotonic_ns: int) -> int:
        """What this processor's clock shows at a time of the host's monotonic clock."""
        return monotonic_ns - self._boot_ns

    def alarm_at(self, monotonic_ns: int, callback: AlarmCallback) -> Alarm:
        """Call `callback` at the first safe point after a time of the host's monotonic clock."""
        return self._alarms.at(monotonic_ns, callback)

    def request(self, line: LiveLine) -> None:
        """Make a line pending, from any thread."""
        with self._changed:
            if line.pending:
                line.overruns += 1
                return
            line.pending = True
            line.pended_at = time.monotonic_ns()
            self._attention = True
            self._changed.notify_all()
        if get_ident() == self._thread:
            self._serve()

    def set_enabled(self, line: LiveLine, enabled: bool) -> None:
        """Enable or disable a line."""
        with self._changed:
            line.enabled = enabled
            self._attention = True
        if enabled and get_ident() == self._thread:
            self._serve()

    # -- reset and the end -----------------------------------------------------------------------

    def run(self, program: Callable[[], None]) -> None:
        """Run `program` in this thread from reset, again after every reset, until `power_off`."""
        self._thread = get_ident()
        while True:
            self._boot_ns = time.monotonic_ns()
            try:
                self._serve()
                program()
                while True:
                    self.wait_for_interrupt()
            except ProcessorReset as reset:
                self.resets.append((time.monotonic_ns() - self._power_on_ns, str(reset)))
                self.reset_cause = str(reset)
            except PowerOff:
                return

    def reset(self, cause: str) -> None:
        """Reset the processor at its next safe point. From any thread."""
        with self._changed:
            self._reset_cause = cause
            self._attention = True
            self._changed.notify_all()

    def power_off(self) -> None:
        """End `run` at the next safe point. From any thread."""
        with self._changed:
            self._ending = True
            self._attention = True
            self._changed.notify_all()

    # -- the passing of time ---------------------------------------------------------------------

    def _serve(self) -> None:
        """Run all handlers that may run now."""
        while (line := self._take_most_urgent()) is not None:
            outer, self._level = self._level, line.priority
            nested_before, self._nested_ns = self._nested_ns, 0
            start = time.monotonic_ns()
            try:
                line.handler()
            finally:
                self._level = outer
                end = time.monotonic_ns()
                line.note(end, end - start - self._nested_ns)
                self._nested_ns = nested_before + end - start
            self._looks = 0
            self._handled += 1

    def _take_most_urgent(self) -> LiveLine | None:
        with self._changed:
            if self._ending:
                raise PowerOff
            if self._reset_cause is not None:
                self._raise_reset()
            self._attention = False
            for line in self._by_urgency:
                if line.pending and line.enabled:
                    self._attention = True
                    if line.priority >= self._level:
                        return None
                    line.pending = False
                    return line
        return None

    def _can_serve(self) -> bool:
        with self._changed:
            if self._ending or self._reset_cause is not None:
                return True
            return any(x.pending and x.enabled and x.priority < self._level for x in self._by_urgency)

    def _rest(self, at_most_ns: int | None) -> None:
        """Let the thread sleep until a line is pending, an alarm is due or the time is over."""
        next_due = self._alarms.next_due_ns
        now = time.monotonic_ns()
        waits = [one for one in (at_most_ns, None if next_due is None else next_due - now) if one is not None]
        shortest = min(waits, default=None)
        self._looks = 0
        with self._changed:
            if self._can_serve() or (shortest is not None and shortest <= 0):
                return
            self._changed.wait(None if shortest is None else shortest * 1e-9)

    def _run_alarms(self, until_ns: int) -> None:
        """Run the alarms due by now and by `until_ns`; each runs the handler of the line that it pends."""
        alarms = self._alarms
        while (due := alarms.next_due_ns) is not None and due <= until_ns:
            late = time.monotonic_ns() - due
            if late < 0:
                return
            self.worst_lateness_ns = max(self.worst_lateness_ns, late)
            alarms.run_next()

    def _raise_reset(self) -> None:
        cause, self._reset_cause = self._reset_cause or "", None
        for hook in self.reset_hooks:
            hook()
        self._alarms.clear()
        for line in self.lines.values():
            line.pending = line.enabled = False
        self._level = THREAD_LEVEL
        raise ProcessorReset(cause)
