"""SSD1325: a 128 × 64 OLED of 16 grey levels on SPI, and the keypad beside it."""

from boards.chips.ssd1325.display import Ssd1325
from boards.chips.ssd1325.keypad import Keypad

__all__ = ["Keypad", "Ssd1325"]
