"""Electrical nets and the processor pins on them.

A net has one driver (a chip, a processor pin, the world outside) and any number of listeners. A chip may
leave its outputs alone while nobody looks at them: it asks `Net.listened`, and is told through
`Net.on_first_listener` when that changes, so that it can bring the level up to date and go on from there.
"""

from __future__ import annotations

from collections.abc import Callable

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import EmulatedLine, emulated_line
from hal.emulated.virtual_time import VirtualTime
from hal.interrupts import InterruptLine
from hal.pins import Edge

Listener = Callable[[bool, int], None]
EdgeListener = Callable[[], None]


class Net:
    """One wire of the board. `level` is its electrical level now."""

    __slots__ = (
        "_edges",
        "_fall",
        "_listeners",
        "_rise",
        "_tape",
        "holder",
        "level",
        "name",
        "on_first_listener",
        "time",
    )

    def __init__(self, time: VirtualTime, name: str, level: bool = False) -> None:
        self.time = time
        self.name = name
        self.level = level
        self.on_first_listener: Callable[[], None] | None = None
        """Set by a lazy driver: called when `listened` becomes true, before the listener looks at `level`."""
        self.holder: Callable[[bool], None] | None = None
        """Set by a fault that keeps the net at its level: hears of what the driver wants."""
        self._listeners: tuple[Listener, ...] = ()
        self._edges: tuple[tuple[EdgeListener, ...], tuple[EdgeListener, ...]] = ((), ())
        """Who hears of falling and of rising edges only: an edge that nobody waits for costs no call."""
        self._tape: list[int] | None = None
        self._fall: EdgeListener | None = None
        self._rise: EdgeListener | None = None
        """What an edge brings about, composed of all that; None: nothing."""

    @property
    def tape(self) -> list[int] | None:
        """Every change of the level as 2·time + level, for a capture. It is no listener: lazy drivers do not
        care for it."""
        return self._tape

    @tape.setter
    def tape(self, tape: list[int] | None) -> None:
        self._tape = tape
        self._compose()

    @property
    def listened(self) -> bool:
        """Whether anybody follows the level."""
        return bool(self._listeners or self._edges[0] or self._edges[1])

    def set(self, level: object) -> None:
        """Drive the level, high for what is true; listeners hear of a change only."""
        high = bool(level)
        if self.holder is not None:
            self.holder(high)
            return
        if high == self.level:
            return
        self.level = high
        follow = self._rise if high else self._fall
        if follow is not None:
            follow()

    def _compose(self) -> None:
        """The usual net has one listener for one edge: then that listener itself is what an edge brings
        about."""
        falling, rising = self._edges
        self._fall, self._rise = self._followed(False, falling), self._followed(True, rising)

    def _followed(self, level: bool, edge_listeners: tuple[EdgeListener, ...]) -> EdgeListener | None:
        listeners, tape, time = self._listeners, self._tape, self.time
        if not listeners and tape is None and len(edge_listeners) <= 1:
            return edge_listeners[0] if edge_listeners else None

        if tape is not None and not listeners and len(edge_listeners) <= 1:
            return _recorded(tape, time, level, edge_listeners[0] if edge_listeners else None)

        def follow() -> None:
            now = time.now
            if tape is not None:
                tape.append(now + now + level)
            for edge_listener in edge_listeners:
                edge_listener()
            for listener in listeners:
                listener(level, now)

        return follow

    def listen(self, callback: Listener) -> None:
        """Call `callback(level, time_ns)` at every change from now on. It must not let time pass."""
        first = not self.listened
        self._listeners = (*self._listeners, callback)
        self._compose()
        if first and self.on_first_listener is not None:
            self.on_first_listener()

    def listen_edge(self, rising: bool, callback: EdgeListener) -> None:
        """Call `callback()` at every rising (or falling) edge from now on, before those who `listen`."""
        first = not self.listened
        falling_edge, rising_edge = self._edges
        if rising:
            self._edges = (falling_edge, (*rising_edge, callback))
        else:
            self._edges = ((*falling_edge, callback), rising_edge)
        self._compose()
        if first and self.on_first_listener is not None:
            self.on_first_listener()

    def ignore_edges(self, callback: EdgeListener) -> None:
        """Take a listener for edges back, from both."""
        falling, rising = self._edges
        self._edges = (
            tuple([other for other in falling if other != callback]),
            tuple([other for other in rising if other != callback]),
        )
        self._compose()

    def ignore(self, callback: Listener) -> None:
        """Take a listener back. Raises ValueError when it does not listen."""
        if callback not in self._listeners:
            raise ValueError(f"net {self.name!r}: {callback!r} does not listen, so it cannot be taken back")
        self._listeners = tuple([other for other in self._listeners if other != callback])
        self._compose()


def _recorded(
    tape: list[int], time: VirtualTime, level: bool, edge_listener: EdgeListener | None
) -> EdgeListener:
    """What an edge to `level` brings about on a net with a tape and at most one listener."""
    append = tape.append

    def fall() -> None:
        now = time.now
        append(now + now)

    def rise() -> None:
        now = time.now
        append(now + now + 1)

    if edge_listener is None:
        return rise if level else fall

    def tell() -> None:
        now = time.now
        append(now + now + level)
        edge_listener()

    return tell


class EmulatedOutputPin:
    """Implements `hal.pins.OutputPin`. At a reset of the processor the net falls back to the level that it
    had before the firmware drove it (its pull-up or pull-down)."""

    def __init__(self, cpu: EmulatedCpu, net: Net) -> None:
        self._net = net
        self._undriven = net.level
        cpu.reset_hooks.append(self._reset)

    def set(self, level: object) -> None:
        """Drive the electrical level, high for what is true."""
        self._net.set(level)

    def _reset(self) -> None:
        self._net.set(self._undriven)


class EmulatedInputPin:
    """Implements `hal.pins.InputPin`."""

    def __init__(self, cpu: EmulatedCpu, net: Net) -> None:
        self._cpu = cpu
        self._net = net
        self._line: EmulatedLine | None = None
        self._listening = False
        cpu.reset_hooks.append(self._reset)

    def read(self) -> bool:
        """The electrical level now."""
        self._look()
        self._cpu.poll()
        return self._net.level

    def interrupt_on(self, edge: Edge, line: InterruptLine) -> None:
        """Pend `line` at every such edge; a second call replaces the first."""
        self._forget_line()
        self._line = emulated_line(line)
        for rising in (False, True):
            if edge is Edge.BOTH or rising == (edge is Edge.RISING):
                self._net.listen_edge(rising, self._line.request)

    def _look(self) -> None:
        """Have a lazy driver keep the level up to date."""
        if not self._listening:
            self._listening = True
            self._net.listen(_nothing)

    def _forget_line(self) -> None:
        if self._line is not None:
            self._net.ignore_edges(self._line.request)
            self._line = None

    def _reset(self) -> None:
        self._forget_line()
        if self._listening:
            self._listening = False
            self._net.ignore(_nothing)


def _nothing(_level: bool, _time_ns: int) -> None:
    """Whoever reads a pin's level follows it, but waits for no edge."""
