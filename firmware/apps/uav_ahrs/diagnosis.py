"""DIAG_STAT of the ADIS16407 in words (fact sheet section 5)."""

from __future__ import annotations

FLAGS = {
    0: "supply below 4.75 V",
    1: "supply above 5.25 V",
    2: "flash update failed",
    3: "SPI error",
    4: "over-range",
    5: "self-test error",
    6: "flash checksum",
    7: "barometer failed",
    8: "alarm 1",
    9: "alarm 2",
    10: "gyro x failed",
    11: "gyro y failed",
    12: "gyro z failed",
    13: "accelerometer x failed",
    14: "accelerometer y failed",
    15: "accelerometer z failed",
}


def flags_in_words(diagnosis: int) -> str:
    """All flags that are set, and the word itself."""
    names = [name for bit, name in FLAGS.items() if diagnosis >> bit & 1]
    return f"{', '.join(names) or 'no flag'} (0x{diagnosis:04X})"
