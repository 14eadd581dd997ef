"""Checks for `hal.spi.SpiDevice`."""

from collections.abc import Callable
from typing import Protocol

from hal.spi import SpiDevice


class SpiBench(Protocol):
    """A slave whose answers are known (a jumper from MOSI to MISO will do)."""

    device: SpiDevice
    absent: SpiDevice | None
    """A chip select with nothing behind it."""

    def prepare(self, mosi: bytes) -> bytes:
        """`mosi` will be sent next: what must come back."""
        ...


def exchanges_in_place(bench: SpiBench) -> None:
    """The buffer holds MISO afterwards; its length and identity stay."""
    for length in (1, 2, 3, 16, 64):
        buffer = bytearray((37 * n + length) % 256 for n in range(length))
        view = memoryview(buffer)
        expected = bench.prepare(bytes(buffer))
        bench.device.transaction(buffer)
        assert bytes(buffer) == expected, f"{length} bytes: {buffer.hex(' ')}, expected {expected.hex(' ')}"
        assert bytes(view) == expected, f"{length} bytes: the buffer was moved"
        view.release()


def transactions_are_independent(bench: SpiBench) -> None:
    """The same buffer serves again; nothing of one transaction is left in the next."""
    buffer = bytearray(4)
    for value in (0x00, 0xFF, 0xA5):
        buffer[:] = bytes((value, 1, 2, 3))
        expected = bench.prepare(bytes(buffer))
        bench.device.transaction(buffer)
        assert bytes(buffer) == expected, (
            f"after {value:02x}: {buffer.hex(' ')}, expected {expected.hex(' ')}"
        )


def absent_slave_reads_as_a_floating_line(bench: SpiBench) -> None:
    """No error, but all ones or all zeros."""
    if bench.absent is None:
        return
    buffer = bytearray(b"\x80\x12\x34")
    bench.absent.transaction(buffer)
    assert bytes(buffer) in (b"\xff" * 3, b"\x00" * 3), f"an absent slave gave {buffer.hex(' ')}"


CHECKS: tuple[Callable[[SpiBench], None], ...] = (
    exchanges_in_place,
    transactions_are_independent,
    absent_slave_reads_as_a_floating_line,
)
