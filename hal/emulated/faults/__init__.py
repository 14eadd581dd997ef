"""Faults on wires: each is at work from `start_ns` to `end_ns` and counts in `fired` how often it struck.

    fault = SpiBitErrors(start_ns=10 * SECOND, end_ns=11 * SECOND, probability=1e-4, seed=1, name="imu")
    fault.install(device)

A fault may be installed at any moment before its end, several at once; outside its time it costs nothing.
Random ones draw from a PCG64 generator seeded by (seed, name), so that no other draw changes theirs.
"""

from hal.emulated.faults.can import CanDisturbance
from hal.emulated.faults.chance import BitErrors
from hal.emulated.faults.fault import Fault
from hal.emulated.faults.i2c import I2cBitErrors, I2cClockStretch, I2cFault, I2cNack, I2cStuckLine
from hal.emulated.faults.packets import PacketBitErrors, PacketFault, PacketLoss, PacketWordSlip
from hal.emulated.faults.pins import PinStuck
from hal.emulated.faults.spi import (
    SpiBitErrors,
    SpiByteSlips,
    SpiFault,
    SpiLateAnswers,
    SpiMissingChip,
    SpiRegisterOverride,
    SpiStuckMiso,
    SpiWordSlip,
)
from hal.emulated.faults.spi_chips import SpiFrozenAnswers, SpiSwappedChips
from hal.emulated.faults.uart import (
    UartBitErrors,
    UartByteDuplication,
    UartByteLoss,
    UartCut,
    UartFault,
    UartFramingErrors,
    UartGarbage,
    UartOverrun,
    UartParity,
    UartTruncation,
    UartWrongBaud,
)

__all__ = [
    "BitErrors",
    "CanDisturbance",
    "Fault",
    "I2cBitErrors",
    "I2cClockStretch",
    "I2cFault",
    "I2cNack",
    "I2cStuckLine",
    "PacketBitErrors",
    "PacketFault",
    "PacketLoss",
    "PacketWordSlip",
    "PinStuck",
    "SpiBitErrors",
    "SpiByteSlips",
    "SpiFault",
    "SpiFrozenAnswers",
    "SpiLateAnswers",
    "SpiMissingChip",
    "SpiRegisterOverride",
    "SpiStuckMiso",
    "SpiSwappedChips",
    "SpiWordSlip",
    "UartBitErrors",
    "UartByteDuplication",
    "UartByteLoss",
    "UartCut",
    "UartFault",
    "UartFramingErrors",
    "UartGarbage",
    "UartOverrun",
    "UartParity",
    "UartTruncation",
    "UartWrongBaud",
]
