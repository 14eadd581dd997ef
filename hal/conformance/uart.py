"""Checks for `hal.uart.Uart`."""

from collections.abc import Callable
from typing import Protocol

from hal.interrupts import InterruptLine
from hal.uart import Uart


class UartBench(Protocol):
    """A port with somebody at the other end, who takes in everything at once."""

    port: Uart

    def line(self, handler: Callable[[], None]) -> InterruptLine:
        """An interrupt line for reception with this handler."""
        ...

    def expect(self, data: bytes) -> None:
        """`data` will be written next."""
        ...

    def feed(self, data: bytes) -> None:
        """The other end sends `data`, then nothing for a while."""
        ...

    def settle(self) -> None:
        """Wait until everything under way has arrived, with its interrupts."""
        ...

    def sent(self) -> bytes:
        """Everything that has arrived at the other end."""
        ...


def writes_in_order(bench: UartBench) -> None:
    """What `write` says it took arrives, in order and once."""
    pieces = [b"\x00\xff", b"navigation", bytes(range(256))]
    for piece in pieces:
        bench.expect(piece)
        taken = bench.port.write(piece)
        assert taken == len(piece), f"{taken} of {len(piece)} bytes taken by an empty queue"
        bench.settle()
    assert bench.sent() == b"".join(pieces), bench.sent()


def tells_its_rate(bench: UartBench) -> None:
    """A port has a bit rate at any time."""
    rate = bench.port.baud
    assert isinstance(rate, int), rate
    assert rate > 0, rate


def writes_nothing(bench: UartBench) -> None:
    """An empty write is no error."""
    assert bench.port.write(b"") == 0
    assert bench.sent() == b""


def takes_no_more_than_fits(bench: UartBench) -> None:
    """`write` takes what `tx_free` promises and not more than there is."""
    free = bench.port.tx_free()
    assert free > 0, f"an idle port has room for {free} bytes"
    data = bytes(n % 251 for n in range(min(free, 64)))
    bench.expect(data)
    assert bench.port.write(data) == len(data)
    assert bench.port.tx_free() <= free


def receives_into_the_ring(bench: UartBench) -> None:
    """Bytes stand in the ring, the count runs on behind its end, and the line falling idle interrupts."""
    ring = bytearray(8)
    interrupts: list[int] = []
    line = bench.line(lambda: interrupts.append(1))
    bench.port.start_receive(ring, line)
    assert bench.port.received() == 0
    received = b""
    for piece in (b"abc", b"defgh", b"ijklm"):
        before = len(interrupts)
        bench.feed(piece)
        bench.settle()
        received += piece
        assert bench.port.received() == len(received), f"{bench.port.received()} of {len(received)} bytes"
        assert len(interrupts) > before, f"no interrupt after {piece!r}"
        start = max(0, len(received) - len(ring))
        expected = {n % len(ring): received[n] for n in range(start, len(received))}
        assert all(ring[at] == value for at, value in expected.items()), f"ring {ring!r} after {received!r}"


def starts_reception_anew(bench: UartBench) -> None:
    """A second `start_receive` counts from zero, into the new ring."""
    line = bench.line(lambda: None)
    bench.port.start_receive(bytearray(16), line)
    bench.feed(b"old")
    bench.settle()
    assert bench.port.received() == 3
    ring = bytearray(16)
    bench.port.start_receive(ring, line)
    assert bench.port.received() == 0
    bench.feed(b"new!")
    bench.settle()
    assert bench.port.received() == 4
    assert ring[:4] == b"new!", bytes(ring)


def clean_line_has_no_errors(bench: UartBench) -> None:
    """No framing error or overrun out of nothing."""
    bench.port.start_receive(bytearray(16), bench.line(lambda: None))
    bench.port.take_errors()
    bench.feed(b"\x00\x55\xff")
    bench.settle()
    assert bench.port.take_errors() == 0


CHECKS: tuple[Callable[[UartBench], None], ...] = (
    writes_in_order,
    tells_its_rate,
    writes_nothing,
    takes_no_more_than_fits,
    receives_into_the_ring,
    starts_reception_anew,
    clean_line_has_no_errors,
)
