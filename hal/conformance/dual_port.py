"""Checks for `hal.dual_port.DualPortMemory`."""

from collections.abc import Callable
from typing import Protocol

from hal.dual_port import DualPortMemory


class DualPortBench(Protocol):
    """One side of a memory, with the other one at hand."""

    near: DualPortMemory
    rings: list[int]
    """What was in the mailbox each time that the near side was interrupted."""

    def expect_write(self, address: int, data: bytes) -> None:
        """These words will be written next."""
        ...

    def expect_read(self, address: int, data: bytes) -> None:
        """These words will be read next."""
        ...

    def expect_ring(self, value: int) -> None:
        """The near side will ring next."""
        ...

    def far_read(self, address: int, count: int) -> bytes:
        """What the other side reads."""
        ...

    def far_write(self, address: int, data: bytes) -> None:
        """The other side writes."""
        ...

    def far_ring(self, value: int) -> None:
        """The other side rings."""
        ...

    def far_rung(self) -> int:
        """What is in the other side's mailbox."""
        ...


def _data(bench: DualPortBench, count: int, seed: int) -> bytes:
    return bytes((37 * n + seed) % 256 for n in range(count * bench.near.word_bytes))


def other_side_reads_what_is_written(bench: DualPortBench) -> None:
    """Whole words at any address, the last one too; what stands around them stays."""
    last = bench.near.words - 3
    for address, count in ((0, 1), (1, 5), (last, 3)):
        data = _data(bench, count, address)
        bench.expect_write(address, data)
        bench.near.write(address, data)
        assert bench.far_read(address, count) == data, f"{count} words from {address}"
    assert bench.far_read(0, 1) == _data(bench, 1, 0), "word 0 was not written again"


def what_the_other_side_writes_is_read(bench: DualPortBench) -> None:
    """The other direction, also over what this side has written."""
    for seed in (1, 2):
        first = _data(bench, 4, seed)
        bench.expect_write(8, first)
        bench.near.write(8, first)
        second = _data(bench, 2, seed + 100)
        bench.far_write(9, second)
        width = bench.near.word_bytes
        whole = first[:width] + second + first[3 * width :]
        bench.expect_read(8, whole)
        assert bench.near.read(8, 4) == whole, f"round {seed}"


def mailboxes_interrupt_the_other_side(bench: DualPortBench) -> None:
    """Each ring once, with its word; the word stays until the next."""
    assert bench.near.rung() == 0, "something was in the mailbox before the first ring"
    for value in (1, 0xFFFF, 0):
        bench.far_ring(value)
        assert bench.near.rung() == value, f"{value} was rung, {bench.near.rung()} is in the mailbox"
    assert bench.rings == [1, 0xFFFF, 0], bench.rings
    bench.expect_ring(7)
    bench.near.ring(7)
    assert bench.far_rung() == 7, bench.far_rung()
    assert bench.near.rung() == 0, "ringing changed this side's own mailbox"
    assert bench.rings == [1, 0xFFFF, 0], "ringing interrupted this side itself"


def what_is_no_word_of_it_is_refused(bench: DualPortBench) -> None:
    """Outside the memory, and parts of words; nothing is written."""
    near, word = bench.near, bytes(bench.near.word_bytes)
    attempts: tuple[Callable[[], object], ...] = (
        lambda: near.write(near.words, word),
        lambda: near.write(near.words - 1, 2 * word),
        lambda: near.write(-1, word),
        lambda: near.write(0, word[:-1]),
        lambda: near.write(0, b""),
        lambda: near.read(near.words - 1, 2),
        lambda: near.read(-1, 1),
        lambda: near.read(0, 0),
    )
    for number, attempt in enumerate(attempts):
        try:
            attempt()
        except ValueError:
            continue
        raise AssertionError(f"attempt {number} was not refused")


CHECKS: tuple[Callable[[DualPortBench], None], ...] = (
    other_side_reads_what_is_written,
    what_the_other_side_writes_is_read,
    mailboxes_interrupt_the_other_side,
    what_is_no_word_of_it_is_refused,
)
