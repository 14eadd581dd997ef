"""HMC6343: tilt-compensated compass on I²C, commands and responses."""

from boards.chips.hmc6343.chip import Hmc6343

__all__ = ["Hmc6343"]
