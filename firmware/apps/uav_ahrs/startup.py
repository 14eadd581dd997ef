"""From power-on to the first word on the bus: the document's order of initialisation (section 4.2).

    InitSysCtrl       PLL (30 MHz · 10 / 2), watchdog, clocks of the peripherals
    DINT, IER, IFR    interrupts off, flags cleared
    InitPieCtrl       the interrupt expansion to its defaults
    InitPieVectTable  its vectors
    InitSpiaGpio      GPIO54 … 56 to SPI-A; GPIO57 stays a plain pin, the chip select
    SPI-A             the five registers below

The registers of SPI-A and what they mean for the wire (sections 4.3.2 and 4.3.3):

    bit rate  = LSPCLK / (SPIBRR + 1)                  SPICCR bit 6  clock idles high
    word      = SPICCR bits 3 … 0, plus 1              SPICTL bit 3  phase, bit 2 master, bit 1 transmit

Clock idle high and phase 0 mean: data go out at the falling edge and are sampled at the rising one, which the
sensor's sheet calls mode 3.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from hal.cpu import Cpu

LSPCLK_HZ: Final = 37_500_000
STEPS: Final = ("system_control", "interrupts_off", "pie_control", "pie_vectors", "spi_gpio", "spi_registers")
"""Names of the costs, in order."""


class SpiRegisters(NamedTuple):
    """SPI-A as the document sets it up."""

    spiccr: int = 0x00CF
    """Written as 0x004F before the others: bit 7 clear holds the module in reset meanwhile."""
    spictl: int = 0x0007
    spibrr: int = 0x0031
    spipri: int = 0x0020

    @property
    def bit_rate_hz(self) -> int:
        """On the wire."""
        return LSPCLK_HZ // (self.spibrr + 1)

    @property
    def bits_per_word(self) -> int:
        """Character length."""
        return (self.spiccr & 0xF) + 1

    @property
    def mode(self) -> int:
        """Of the usual four: 2·polarity + phase, where phase 0 of this module shifts out half a clock before
        the edge that samples."""
        idle_high = self.spiccr >> 6 & 1
        delayed = self.spictl >> 3 & 1
        return 2 * idle_high + (1 - delayed)

    @property
    def is_master(self) -> bool:
        """And may transmit."""
        return self.spictl & 0x6 == 0x6


SPI_A: Final = SpiRegisters()


def initialise(cpu: Cpu) -> None:
    """Take the time that the steps take; nothing may interrupt yet."""
    for step in STEPS:
        cpu.spend(cpu.cost(step))
