"""ADXL345: 3-axis accelerometer with SPI and I²C faces."""

from boards.chips.adxl345.chip import Adxl345

__all__ = ["Adxl345"]
