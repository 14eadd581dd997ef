"""A receiver with two antennas: position, velocity, and the direction of the baseline between them."""

from boards.chips.dual_antenna.receiver import DualAntennaReceiver

__all__ = ["DualAntennaReceiver"]
