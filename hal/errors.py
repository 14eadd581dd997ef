"""Errors of a bus operation: each keeps its detail and maps to a small closed kind."""

from enum import Enum


class ErrorKind(Enum):
    """What went wrong on a wire, in words that every backend shares."""

    ADDRESS_NACK = "address not acknowledged"
    DATA_NACK = "data not acknowledged"
    TIMEOUT = "timeout"
    OVERRUN = "overrun"
    FRAMING = "framing"
    BUS_OFF = "bus off"
    OTHER = "other"


class BusError(Exception):
    """A bus operation failed. `kind` is for the driver's decision, the message for people."""

    def __init__(self, kind: ErrorKind, detail: str) -> None:
        super().__init__(f"{kind.value}: {detail}")
        self.kind = kind
        self.detail = detail
