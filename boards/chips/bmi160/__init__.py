"""BMI160: 6-axis inertial sensor (accelerometer, gyroscope, temperature) with SPI and I²C faces."""

from boards.chips.bmi160.chip import Bmi160

__all__ = ["Bmi160"]
