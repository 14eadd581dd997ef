"""Checks for `hal.interrupts` and the sleep of `hal.cpu`."""

from collections.abc import Callable
from typing import Protocol

from hal.cpu import Cpu
from hal.interrupts import InterruptController, InterruptLine


class InterruptBench(Protocol):
    """A controller with the lines "urgent", "middle" and "background" in this order of priority."""

    controller: InterruptController
    cpu: Cpu
    nests: bool
    """Whether a more urgent line interrupts a handler (a backend without real interrupts cannot)."""
    knows_names: bool
    """Whether only the names of a board description can be attached."""

    def settle(self) -> None:
        """Let pending handlers run."""
        ...


def runs_a_pended_line_once(bench: InterruptBench) -> None:
    """One request, one run; not before it is pended."""
    ran: list[str] = []
    line = bench.controller.attach("middle", lambda: ran.append("middle"))
    bench.settle()
    assert ran == []
    line.pend()
    bench.settle()
    bench.settle()
    assert ran == ["middle"], ran


def disabled_line_waits(bench: InterruptBench) -> None:
    """A request to a disabled line stays pending, once, until it is enabled."""
    ran: list[str] = []
    line = bench.controller.attach("middle", lambda: ran.append("middle"))
    line.disable()
    line.pend()
    line.pend()
    bench.settle()
    assert ran == [], "a disabled line ran"
    line.enable()
    bench.settle()
    assert ran == ["middle"], ran


def serves_by_urgency(bench: InterruptBench) -> None:
    """Within a handler a more urgent line nests at once, a less urgent one waits for its end."""
    order: list[str] = []
    lines: dict[str, InterruptLine] = {}

    def middle() -> None:
        order.append("middle begins")
        lines["background"].pend()
        lines["urgent"].pend()
        order.append("middle ends")

    for name in ("background", "urgent"):
        lines[name] = bench.controller.attach(name, lambda name=name: order.append(name))  # type: ignore[misc]
    lines["middle"] = bench.controller.attach("middle", middle)
    lines["middle"].pend()
    bench.settle()
    if bench.nests:
        assert order == ["middle begins", "urgent", "middle ends", "background"], order
    else:
        assert order[:2] == ["middle begins", "middle ends"], order
        assert sorted(order[2:]) == ["background", "urgent"], order


def sleep_ends_with_a_handler(bench: InterruptBench) -> None:
    """`wait_for_interrupt` returns after a handler has run, also one that was pending before."""
    ran: list[str] = []
    line = bench.controller.attach("middle", lambda: ran.append("middle"))
    line.disable()
    line.pend()
    line.enable()
    if not ran:
        bench.cpu.wait_for_interrupt()
    assert ran == ["middle"], ran


def unknown_line_is_told(bench: InterruptBench) -> None:
    """A name that the board does not have raises KeyError that lists the names it has."""
    if not bench.knows_names:
        return
    try:
        bench.controller.attach("no such line", lambda: None)
    except KeyError as error:
        message = str(error)
    else:
        raise AssertionError("an unknown line was attached")
    assert "no such line" in message, message
    assert all(name in message for name in ("urgent", "middle", "background")), message


def counts_activations(bench: InterruptBench) -> None:
    """Lines that have run are listed with how often; one that has not is left out."""
    line = bench.controller.attach("middle", lambda: None)
    bench.controller.attach("background", lambda: None)
    for _ in range(3):
        line.pend()
        bench.settle()
    assert {one.name: one.activations for one in bench.controller.figures()} == {"middle": 3}


CHECKS: tuple[Callable[[InterruptBench], None], ...] = (
    runs_a_pended_line_once,
    counts_activations,
    disabled_line_waits,
    serves_by_urgency,
    sleep_ends_with_a_handler,
    unknown_line_is_told,
)
