"""Power modes of the three sensors and how long their changes take (fact sheet sections 2 and 5).

PMU_STATUS shows the old mode until the change is complete. Durations that the sheet leaves open:
going to a mode that needs less (suspend, or out of normal) is immediate, fast start-up from suspend takes
as long as normal from suspend, and the magnetometer interface takes 1 ms whenever it is switched on.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

MILLISECOND = 1_000_000

ACCEL_START_NS = 3_800_000
GYRO_START_NS = 80 * MILLISECOND
GYRO_FROM_FAST_START_NS = 10 * MILLISECOND
MAG_START_NS = 1 * MILLISECOND

SUSPEND, NORMAL, LOW_POWER, FAST_START = 0, 1, 2, 3
"""Mode codes of PMU_STATUS; LOW_POWER for accelerometer and magnetometer, FAST_START for the gyroscope."""


class Sensor(IntEnum):
    """A field of PMU_STATUS; the value is its lowest bit."""

    MAG = 0
    GYRO = 2
    ACCEL = 4


MODE_COMMANDS = {
    0x10: (Sensor.ACCEL, SUSPEND),
    0x11: (Sensor.ACCEL, NORMAL),
    0x12: (Sensor.ACCEL, LOW_POWER),
    0x14: (Sensor.GYRO, SUSPEND),
    0x15: (Sensor.GYRO, NORMAL),
    0x17: (Sensor.GYRO, FAST_START),
    0x18: (Sensor.MAG, SUSPEND),
    0x19: (Sensor.MAG, NORMAL),
    0x1A: (Sensor.MAG, LOW_POWER),
}
"""CMD code -> which sensor goes to which mode."""


@dataclass(slots=True)
class PowerModes:
    """The modes the sensors are in."""

    modes: dict[Sensor, int] = field(default_factory=lambda: dict.fromkeys(Sensor, SUSPEND))

    @property
    def accel(self) -> int:
        """Mode of the accelerometer."""
        return self.modes[Sensor.ACCEL]

    @property
    def gyro(self) -> int:
        """Mode of the gyroscope."""
        return self.modes[Sensor.GYRO]

    @property
    def any_normal(self) -> bool:
        """Whether accelerometer or gyroscope is in normal mode (fast register access)."""
        return NORMAL in (self.accel, self.gyro)

    def status(self) -> int:
        """The register PMU_STATUS."""
        modes = self.modes
        return modes[Sensor.MAG] | modes[Sensor.GYRO] << Sensor.GYRO | modes[Sensor.ACCEL] << Sensor.ACCEL

    def change_duration(self, sensor: Sensor, mode: int) -> int:
        """Time (ns) from the command to the mode."""
        now = self.modes[sensor]
        if mode in (now, SUSPEND):
            return 0
        if sensor is Sensor.MAG:
            return MAG_START_NS
        if sensor is Sensor.ACCEL:
            return ACCEL_START_NS if mode == NORMAL or now == SUSPEND else 0
        if now == FAST_START:
            return GYRO_FROM_FAST_START_NS
        return 0 if now == NORMAL else GYRO_START_NS
