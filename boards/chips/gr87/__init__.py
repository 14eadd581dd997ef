"""HOLUX GR-87: a SiRF III receiver that speaks NMEA."""

from boards.chips.gr87.receiver import Gr87

__all__ = ["Gr87"]
