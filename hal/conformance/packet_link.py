"""Checks for `hal.packet_link.PacketSender` and `PacketReceiver`, each with the other end at hand."""

from collections.abc import Callable
from typing import Protocol

from hal.packet_link import PacketReceiver, PacketSender


class PacketBench(Protocol):
    """Both ends."""

    sender: PacketSender
    receiver: PacketReceiver
    whole: list[int]
    """What `received` told at each interrupt for a whole packet."""

    def begin(self, ring: bytearray, packet_bytes: int) -> None:
        """Begin to receive, the interrupt noting in `whole`."""
        ...

    def expect_send(self, data: bytes, busy: bool = False) -> None:
        """These bytes will be handed to the sender next."""
        ...

    def carried(self) -> bytes:
        """Let time pass until the wire is free; the bytes that went over it last."""
        ...

    def bring(self, data: bytes) -> None:
        """Let these bytes come over the wire."""
        ...


def packets_go_over_the_wire(bench: PacketBench) -> None:
    """One after the other; while one is under way the next is refused."""
    for length in (2, 96, 4):
        data = bytes((7 * k + length) & 0xFF for k in range(length))
        bench.expect_send(data)
        assert bench.sender.send(data), f"a packet of {length} bytes was refused on a free wire"
        bench.expect_send(data[::-1], busy=True)
        assert not bench.sender.send(data[::-1]), "a packet was taken while another was under way"
        assert bench.carried() == data, f"{length} bytes"


def whole_packets_interrupt(bench: PacketBench) -> None:
    """Words are counted, whatever pieces they come in; the ring wraps."""
    ring = bytearray(16)
    bench.begin(ring, 8)
    stream = bytes(range(1, 33))
    for piece in (stream[:8], stream[8:14], stream[14:16], stream[16:24], stream[24:32]):
        bench.bring(piece)
    assert bench.receiver.received() == 32, bench.receiver.received()
    assert bench.whole == [8, 16, 24, 32], bench.whole
    assert bytes(ring) == stream[16:], ring.hex(" ")


def reception_begins_anew(bench: PacketBench) -> None:
    """Counts and places start from nothing."""
    bench.begin(bytearray(16), 8)
    bench.bring(bytes(6))
    ring = bytearray(16)
    bench.begin(ring, 8)
    assert bench.receiver.received() == 0
    bench.bring(bytes(range(8)))
    assert (bench.receiver.received(), bytes(ring[:8])) == (8, bytes(range(8)))


def parts_of_words_are_refused(bench: PacketBench) -> None:
    """And rings that hold no whole packets."""
    attempts: tuple[Callable[[], object], ...] = (
        lambda: bench.sender.send(b""),
        lambda: bench.sender.send(b"\x01\x02\x03"),
        lambda: bench.begin(bytearray(), 8),
        lambda: bench.begin(bytearray(12), 8),
        lambda: bench.begin(bytearray(9), 3),
    )
    for number, attempt in enumerate(attempts):
        try:
            attempt()
        except ValueError:
            continue
        raise AssertionError(f"attempt {number} was not refused")


CHECKS: tuple[Callable[[PacketBench], None], ...] = (
    packets_go_over_the_wire,
    whole_packets_interrupt,
    reception_begins_anew,
    parts_of_words_are_refused,
)
