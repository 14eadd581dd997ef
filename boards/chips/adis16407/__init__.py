"""ADIS16407: gyros, accelerometers, magnetometers and barometer behind 16-bit SPI words."""

from boards.chips.adis16407.chip import Adis16407

__all__ = ["Adis16407"]
