"""Checks for `hal.can.CanController`."""

from collections.abc import Callable, Sequence
from typing import Protocol

from hal.can import CanController, CanFrame, CanSet

FRAMES = (
    CanFrame(0x000, b""),
    CanFrame(0x7FF, bytes(range(8))),
    CanFrame(0x123, b"\xff" * 8),
    CanFrame(0x00000000, b"\x00", extended=True),
    CanFrame(0x1FFFFFFF, b"\x00" * 8, extended=True),
    CanFrame(0x123, b"\x01\x02\x03", extended=True),
)


class CanBench(Protocol):
    """A controller with another node on its bus."""

    controller: CanController

    def expect(self, frames: Sequence[CanFrame]) -> None:
        """`frames` will be sent next."""
        ...

    def feed(self, frame: CanFrame) -> None:
        """The other node sends `frame`."""
        ...

    def settle(self) -> None:
        """Wait until everything under way has arrived."""
        ...

    def sent(self) -> list[CanFrame]:
        """Everything that has arrived at the other node, in order."""
        ...


def sends_in_order(bench: CanBench) -> None:
    """Frames queued in one call arrive in that order, with identifier, kind and data."""
    bench.expect(FRAMES)
    assert bench.controller.send(FRAMES) == len(FRAMES)
    bench.settle()
    assert bench.sent() == list(FRAMES), bench.sent()


def sends_a_set(bench: CanBench) -> None:
    """A set goes as its frames do, also a second time and as a part of it."""
    whole = CanSet((0x310, 0x7FF, 0x000), bytes(range(16)) + b"\xff" * 8)
    frames = list(whole)
    assert [frame.data for frame in frames] == [bytes(range(8)), bytes(range(8, 16)), b"\xff" * 8]
    bench.expect([*frames, *frames, frames[1]])
    assert bench.controller.send(whole) == 3
    bench.settle()
    assert bench.controller.send(whole) == 3
    bench.settle()
    assert bench.controller.send(whole[1:2]) == 1
    bench.settle()
    assert bench.sent() == [*frames, *frames, frames[1]], bench.sent()


def sends_nothing(bench: CanBench) -> None:
    """No frames are no error."""
    assert bench.controller.send(()) == 0


def receives_in_order(bench: CanBench) -> None:
    """The oldest frame first; None when there is none."""
    assert bench.controller.receive() is None
    for frame in FRAMES:
        bench.feed(frame)
        bench.settle()
    for frame in FRAMES:
        received = bench.controller.receive()
        assert received == frame, f"{received} instead of {frame}"
    assert bench.controller.receive() is None


def does_not_hear_itself(bench: CanBench) -> None:
    """A frame sent is not received."""
    bench.expect(FRAMES[:1])
    bench.controller.send(FRAMES[:1])
    bench.settle()
    assert bench.controller.receive() is None


CHECKS: tuple[Callable[[CanBench], None], ...] = (
    sends_in_order,
    sends_a_set,
    sends_nothing,
    receives_in_order,
    does_not_hear_itself,
)
