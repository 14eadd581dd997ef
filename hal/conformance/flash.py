"""Checks for `hal.flash.FlashMemory`."""

from collections.abc import Callable
from typing import Protocol

from hal.flash import FlashMemory


class FlashBench(Protocol):
    """A memory, all 0xFF at first, with at least two blocks of at least 600 bytes."""

    flash: FlashMemory

    def expect(self, action: str, reply: str = "") -> None:
        """The call `action` (as in a transcript) comes next, and gives that."""
        ...


def _read(bench: FlashBench, place: int, wanted: bytes) -> None:
    bench.expect(f"flash settings read {place} {len(wanted)}", wanted.hex(" "))
    got = bench.flash.read(place, len(wanted))
    assert got == wanted, f"from {place} on {got.hex(' ')}, expected {wanted.hex(' ')}"


def _program(bench: FlashBench, place: int, data: bytes) -> None:
    bench.expect(f"flash settings program {place} {data.hex(' ')}")
    assert bench.flash.program(place, data)


def begins_clear(bench: FlashBench) -> None:
    """Nothing was ever written."""
    _read(bench, 0, b"\xff" * 5)


def keeps_what_was_programmed(bench: FlashBench) -> None:
    """Across pages, and nothing beside it."""
    data = bytes(k % 251 for k in range(600))
    _program(bench, 0, data)
    _read(bench, 0, data)
    _read(bench, bench.flash.block_bytes, b"\xff\xff")


def programming_clears_bits_only(bench: FlashBench) -> None:
    """What is there AND what comes."""
    _program(bench, 7, b"\xf0\x0f")
    _program(bench, 7, b"\xaa\xff")
    _read(bench, 6, b"\xff\xa0\x0f\xff")


def erases_one_block(bench: FlashBench) -> None:
    """The other keeps what it holds."""
    second = bench.flash.block_bytes
    _program(bench, second - 2, b"\x01\x02")
    _program(bench, second, b"\x03\x04")
    bench.expect("flash settings erase 0")
    assert bench.flash.erase(0)
    _read(bench, second - 2, b"\xff\xff\x03\x04")


def refuses_what_it_does_not_have(bench: FlashBench) -> None:
    """Places beyond its end, and what goes over the end of a block."""
    flash = bench.flash
    end = flash.blocks * flash.block_bytes
    for wrong in (
        lambda: flash.read(end, 1),
        lambda: flash.read(-1, 1),
        lambda: flash.erase(flash.blocks),
        lambda: flash.program(flash.block_bytes - 1, b"\x00\x00"),
    ):
        try:
            wrong()
        except ValueError:
            continue
        raise AssertionError("a place that is not there was taken")


CHECKS: tuple[Callable[[FlashBench], None], ...] = (
    begins_clear,
    keeps_what_was_programmed,
    programming_clears_bits_only,
    erases_one_block,
    refuses_what_it_does_not_have,
)
