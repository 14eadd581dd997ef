"""Which inertial sensors' traffic on a bus is understood, by part."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

from host.capture.adis16407_traffic import Adis16407Traffic
from host.capture.blocks import SpiTransaction
from host.capture.inertial_samples import Bmi160Traffic, InertialSamples


class SensorTraffic(Protocol):
    """Follows one chip through its transactions."""

    def add(self, transactions: Iterable[SpiTransaction]) -> None:
        """Further transactions, in their order."""
        ...

    def glimpse(self, block: bytes | bytearray, sent: Iterable[bytes]) -> tuple[float, ...] | None:
        """The last sample in a block of records as a row of `inertial_samples.IMU`. `sent`: MOSI of the
        two-byte transactions in it."""
        ...

    def samples(self) -> InertialSamples:
        """All samples so far."""
        ...


DECODERS: dict[str, Callable[[], SensorTraffic]] = {
    "BMI160": Bmi160Traffic,
    "ADIS16407": Adis16407Traffic,
}
