"""Checks for `hal.i2c_slave.I2cSlavePort`."""

from collections.abc import Callable
from typing import Protocol

from hal.i2c_slave import I2cSlavePort


class I2cSlaveBench(Protocol):
    """A slave that has begun, with its master at hand."""

    slave: I2cSlavePort
    heard: list[bytes]
    """What was taken at each interrupt."""

    def expect_answer(self, data: bytes) -> None:
        """This answer will be set next."""
        ...

    def master_writes(self, data: bytes) -> None:
        """The master writes."""
        ...

    def master_reads(self, length: int) -> bytes:
        """What the master reads."""
        ...


def writes_interrupt_and_are_taken_once(bench: I2cSlaveBench) -> None:
    """Each with all its bytes."""
    for data in (b"\x10", bytes(range(7)), b"\xff\x00"):
        bench.master_writes(data)
        assert bench.heard[-1] == data, f"{bench.heard[-1].hex(' ')}, expected {data.hex(' ')}"
        assert bench.slave.taken() == b"", "taken twice"
    assert len(bench.heard) == 3, bench.heard


def reads_give_the_answer(bench: I2cSlaveBench) -> None:
    """The latest; beyond its end the idle wire."""
    for answer in (b"\x01\x02\x03", b"\x47"):
        bench.expect_answer(answer)
        bench.slave.answer(answer)
        for length in (1, 3, 5):
            expected = answer[:length].ljust(length, b"\xff")
            assert bench.master_reads(length) == expected, f"{length} bytes of {answer.hex(' ')}"


CHECKS: tuple[Callable[[I2cSlaveBench], None], ...] = (
    writes_interrupt_and_are_taken_once,
    reads_give_the_answer,
)
