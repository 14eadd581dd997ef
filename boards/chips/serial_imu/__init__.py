"""Framed inertial measurement unit on a serial line (RS-422)."""

from boards.chips.serial_imu.chip import SerialImu

__all__ = ["SerialImu"]
