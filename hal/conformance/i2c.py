"""Checks for `hal.i2c.I2cBus`."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from hal.errors import BusError, ErrorKind
from hal.i2c import I2cBus


class I2cCase(NamedTuple):
    """One transaction and what must come of it: the bytes read or the kind of error."""

    address: int
    write: bytes
    read_length: int
    outcome: bytes | ErrorKind


class I2cBench(Protocol):
    """A bus with devices whose behaviour the cases describe, in the order in which they are run.

    At least one case each: presence (nothing written or read), write, read, write then read, address not
    acknowledged. Data not acknowledged and time-out where the backend can bring them about.
    """

    bus: I2cBus
    cases: Sequence[I2cCase]


def behaves_as_described(bench: I2cBench) -> None:
    """Every case gives its bytes or its error, and an error does not hurt what follows."""
    for case in bench.cases:
        outcome: bytes | ErrorKind
        detail = "none"
        try:
            outcome = bench.bus.transaction(case.address, case.write, case.read_length)
        except BusError as error:
            outcome, detail = error.kind, error.detail
        assert detail, f"{case}: an error without detail"
        assert outcome == case.outcome, f"{case}: got {outcome!r}"


def cases_are_complete(bench: I2cBench) -> None:
    """The bench itself: it describes every kind of transaction."""
    good = [case for case in bench.cases if isinstance(case.outcome, bytes)]
    shapes = {(bool(case.write), bool(case.read_length)) for case in good}
    assert len(shapes) == 4, f"cases cover only (write, read) = {sorted(shapes)}"
    assert any(case.outcome is ErrorKind.ADDRESS_NACK for case in bench.cases), "no absent address"


CHECKS: tuple[Callable[[I2cBench], None], ...] = (cases_are_complete, behaves_as_described)
