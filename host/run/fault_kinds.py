"""The kinds of faults that strike a board: on wires, in chips, in sensor elements, in processors.

| kind | target | parameters |
| --- | --- | --- |
| spi-bit-errors | SPI device | probability a bit, line = "miso" or "mosi" |
| spi-missing | SPI device | level = true: reads 0xFF, false: 0x00 |
| spi-stuck | SPI device | the same, but the chip hears |
| spi-register | SPI device | register, value: reads of one register give value |
| spi-word-slip | SPI device | bits: answers come so many clocks late |
| spi-late | SPI device | each answer is that of the transaction before |
| spi-frozen | SPI device | every request gets the answer that it got first |
| spi-swapped | SPI device | with: the device whose chip has its wires; "" the next of its part |
| spi-byte-loss, spi-byte-duplication | SPI device | probability a byte of the answer |
| i2c-nack | I²C device or command channel | byte = −1: the address is refused; 0, 1, …: from that byte on |
| i2c-bit-errors | the same | probability a bit, line = "read" or "write" |
| i2c-clock-stretch | the same | hold_ms: the clock is held low so long |
| i2c-stuck | I²C bus or command channel | line = "sda" or "scl", level |
| uart-… | UART | line = "rx": into the processor, "tx": out of it |
| can-disturbance | CAN bus | no frame gets through |
| packet-loss, packet-word-slip | packet link | probability a packet |
| packet-bit-errors | packet link | probability a bit |
| pin-stuck | net | level: a data-ready or time pulse that nobody sees |
| sensor-frozen | reference designator | quantity = "all" or one, axis |
| sensor-stuck, -saturated, -drift | reference designator | quantity = "" (its first) or one, axis |
| sensor-turned | reference designator | quantity = "all" or one, axis about which it is turned by 180° |
| chip-reset | reference designator | a dip of the supply: brown-out reset |
| chip-off | reference designator | supply off for the duration |
| chip-wrong-id | reference designator | id that it answers with |
| chip-clock | reference designator | ppm by which its clock is fast |
| chip-halt | reference designator | its sample clock stands still: stale data |
| chip-flags | reference designator | flags that it raises with every sample |
| chip-supply | reference designator | volts of its supply |
| chip-busy | reference designator | factor by which the delays of its commands are longer, nack |
| log-removed | log | the card is pulled |
| nav-nan | processor | a kernel leaves NaN behind in its state |
| cpu-reset | processor | reset of the processor |

Defaults and meaning stand in docs/scenarios.md. What the simulated receiver itself gets wrong is in
`host.sim.gnss.faults`.
"""

from __future__ import annotations

from boards.sense import Drift, Frozen, Saturated, Stuck, Turned
from hal.emulated import faults
from host.run.chip_faults import (
    halt_chip,
    keep_busy,
    mistake_id,
    pull_card,
    put_clock_off,
    raise_flags,
    reset_chip,
    reset_cpu,
    sag_supply,
    spoil_state,
    switch_chip_off,
)
from host.run.fault_site import Maker
from host.run.sensor_faults import (
    in_sensor,
)
from host.run.wire_faults import (
    disturb_can,
    on_i2c,
    on_packets,
    on_spi,
    on_uart,
    override_register,
    overrun_port,
    stick_i2c,
    stick_pin,
    swap_chips,
)

KINDS: dict[str, Maker] = {
    "spi-bit-errors": on_spi(faults.SpiBitErrors, probability=1e-4, line="miso"),
    "spi-missing": on_spi(faults.SpiMissingChip, level=True),
    "spi-stuck": on_spi(faults.SpiStuckMiso, level=True),
    "spi-register": override_register,
    "spi-word-slip": on_spi(faults.SpiWordSlip, bits=1),
    "spi-late": on_spi(faults.SpiLateAnswers),
    "spi-frozen": on_spi(faults.SpiFrozenAnswers),
    "spi-swapped": swap_chips,
    "spi-byte-loss": on_spi(faults.SpiByteSlips, probability=1e-3),
    "spi-byte-duplication": on_spi(faults.SpiByteSlips, {"doubled": True}, probability=1e-3),
    "i2c-nack": on_i2c(faults.I2cNack, byte=-1),
    "i2c-bit-errors": on_i2c(faults.I2cBitErrors, probability=1e-4, line="read"),
    "i2c-clock-stretch": on_i2c(faults.I2cClockStretch, hold_ms=2.0),
    "i2c-stuck": stick_i2c,
    "uart-cut": on_uart(faults.UartCut),
    "uart-bit-errors": on_uart(faults.UartBitErrors, probability=1e-3),
    "uart-byte-loss": on_uart(faults.UartByteLoss, probability=1e-2),
    "uart-byte-duplication": on_uart(faults.UartByteDuplication, probability=1e-2),
    "uart-framing-errors": on_uart(faults.UartFramingErrors, probability=1e-2),
    "uart-parity": on_uart(faults.UartParity),
    "uart-overrun": overrun_port,
    "uart-truncation": on_uart(faults.UartTruncation, keep=20),
    "uart-wrong-baud": on_uart(faults.UartWrongBaud, baud=38_400),
    "uart-garbage": on_uart(faults.UartGarbage, length=500),
    "can-disturbance": disturb_can,
    "packet-loss": on_packets(faults.PacketLoss, 1.0),
    "packet-bit-errors": on_packets(faults.PacketBitErrors, 1e-4),
    "packet-word-slip": on_packets(faults.PacketWordSlip, 0.01),
    "pin-stuck": stick_pin,
    "sensor-frozen": in_sensor(Frozen, "all", receiver_too=True),
    "sensor-stuck": in_sensor(Stuck, "", value=0.0),
    "sensor-saturated": in_sensor(Saturated, "", negative=False),
    "sensor-drift": in_sensor(Drift, "", rate=0.01),
    "sensor-turned": in_sensor(Turned, "all", axis="z"),
    "chip-reset": reset_chip,
    "chip-off": switch_chip_off,
    "chip-wrong-id": mistake_id,
    "chip-clock": put_clock_off,
    "chip-halt": halt_chip,
    "chip-flags": raise_flags,
    "chip-supply": sag_supply,
    "chip-busy": keep_busy,
    "log-removed": pull_card,
    "nav-nan": spoil_state,
    "cpu-reset": reset_cpu,
}
