"""What a program finds wired to its processor: interfaces of `hal`, by the names of the description."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

from hal.can import CanController
from hal.clock import Clock
from hal.cpu import Cpu
from hal.dual_port import DualPortMemory
from hal.flash import FlashMemory
from hal.i2c import I2cBus
from hal.i2c_slave import I2cSlavePort
from hal.interrupts import InterruptController
from hal.packet_link import PacketReceiver, PacketSender
from hal.pins import InputPin, OutputPin
from hal.spi import SpiDevice
from hal.storage import LogFile
from hal.timers import CaptureTimer, PeriodicTimer
from hal.uart import Uart
from hal.watchdog import Watchdog


class NotNamedError(KeyError):
    """The program asks for something that the description of its board does not name."""

    def __init__(self, kind: str, name: str, known: Mapping[str, Any]) -> None:
        names = ", ".join(sorted(known)) or "none"
        super().__init__(
            f"the program asks for {kind} {name!r}, which the board does not name; it names: {names}"
        )

    def __str__(self) -> str:
        return str(self.args[0])


class Named(dict[str, Any]):
    """Parts of one kind by name; asking for one that is not there raises NotNamedError."""

    def __init__(self, kind: str, parts: Mapping[str, Any]) -> None:
        super().__init__(parts)
        self._kind = kind

    def __missing__(self, name: str) -> Any:
        raise NotNamedError(self._kind, name, self)


@dataclass
class BoardIo:
    """One processor's view of its board. A name that is missing from a mapping is not wired."""

    cpu: Cpu
    clock: Clock
    interrupts: InterruptController
    watchdog: Watchdog
    spi: Mapping[str, SpiDevice] = field(default_factory=dict)
    i2c: Mapping[str, I2cBus] = field(default_factory=dict)
    uart: Mapping[str, Uart] = field(default_factory=dict)
    can: Mapping[str, CanController] = field(default_factory=dict)
    outputs: Mapping[str, OutputPin] = field(default_factory=dict)
    inputs: Mapping[str, InputPin] = field(default_factory=dict)
    captures: Mapping[str, CaptureTimer] = field(default_factory=dict)
    timers: Mapping[str, PeriodicTimer] = field(default_factory=dict)
    logs: Mapping[str, LogFile] = field(default_factory=dict)
    flash: Mapping[str, FlashMemory] = field(default_factory=dict)
    memories: Mapping[str, DualPortMemory] = field(default_factory=dict)
    """This processor's side of each."""
    packet_senders: Mapping[str, PacketSender] = field(default_factory=dict)
    packet_receivers: Mapping[str, PacketReceiver] = field(default_factory=dict)
    command_buses: Mapping[str, I2cBus] = field(default_factory=dict)
    """I²C buses on which another processor is the slave …"""
    i2c_slaves: Mapping[str, I2cSlavePort] = field(default_factory=dict)
    """… and the slaves there."""

    def __post_init__(self) -> None:
        for kind in fields(self):
            parts = getattr(self, kind.name)
            if isinstance(parts, Mapping):
                setattr(self, kind.name, Named(kind.name, parts))


class Program(Protocol):
    """What `program(io, profile, installation)` of a board's firmware returns: the image in flash.

    `profile` is the chosen table of the board's profiles, `installation` what calibration would have put
    into its flash: for each device by firmware name its mounting `C_b_s` and `lever_arm_m`.
    """

    def main(self) -> None:
        """From the reset vector; called again after a reset. Need not return."""
        ...

    def spoil(self) -> None:
        """Leave NaN in the navigation state, as a defective kernel would: the fault injector's door."""
        ...

    def memory(self) -> bytes:
        """The navigation state as it lies in memory, for comparing runs."""
        ...
