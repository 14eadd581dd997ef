"""A powered board in virtual time: run it to an instant, look at it, run it on, switch it off."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from greenlet import greenlet

from hal.emulated.cpu import EmulatedCpu, switch_to_host
from hal.emulated.virtual_time import VirtualTime
from hal.endings import PowerOff, SpinError

STALL_LIMIT_S = 60.0
"""Wall-clock seconds without any progress of virtual time after which a firmware loop is called endless."""


class Machine:
    """Processors with their programs on one virtual time. The first processor works the event queue off."""

    def __init__(self, time: VirtualTime) -> None:
        self.time = time
        self.cpus: list[EmulatedCpu] = []
        self._greenlets: list[greenlet] = []
        self._ended = False

    def add(self, cpu: EmulatedCpu, program: Callable[[], None]) -> None:
        """Add a processor that runs `program` from reset at the present instant."""
        owner = self._greenlets[0] if self._greenlets else None
        self.cpus.append(cpu)
        self._greenlets.append(cpu.boot(program, owner))
        if owner is not None:
            cpu.start()

    def run_until(self, end_ns: int) -> None:
        """Let virtual time pass to `end_ns`. Raises what the firmware raises; SpinError: an endless loop."""
        if self._ended:
            raise RuntimeError("the machine is switched off; build a new one to run again")
        self.time.at(end_ns, switch_to_host, priority=1 << 30)
        with self._stall_guard():
            self._greenlets[0].switch()

    def power_off(self) -> None:
        """Unwind all firmware. The machine cannot run again."""
        self._ended = True
        for program in reversed(self._greenlets):
            if program:
                with suppress(PowerOff):
                    program.throw(PowerOff)

    @contextmanager
    def _stall_guard(self) -> Iterator[None]:
        """End a firmware loop that never lets time pass (it makes no hal call that could notice)."""
        seen = [-1, -1]

        def check(_signal: int, _frame: FrameType | None) -> None:
            progress = [self.time.now, self.time.events_run]
            if progress == seen:
                busy = ", ".join(f"{cpu.running_name!r} on {cpu.name!r}" for cpu in self.cpus)
                raise SpinError(
                    f"virtual time stood still at {self.time.now / 1e9:.6f} s for {STALL_LIMIT_S:g} s: a task"
                    f" never lets time pass (running: {busy}); give its loop a bound, or call spend() in it"
                )
            seen[:] = progress

        try:
            previous = signal.signal(signal.SIGALRM, check)
        except ValueError:  # not in the main thread: no guard
            yield
            return
        signal.setitimer(signal.ITIMER_REAL, STALL_LIMIT_S, STALL_LIMIT_S)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, previous)
