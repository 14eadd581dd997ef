"""A BMI160 whose FIFO is on: both sensors at 100 Hz, motions that are known."""

from __future__ import annotations

from math import radians
from typing import Any

from bmi160_rig import MS, G, Rig

GYRO_ON, ACCEL_ON, HEADER, TIME = 0x80, 0x40, 0x10, 0x02


def steady(_t: Any) -> dict[str, float]:
    """100 °/s about x, −100 about z; 0.5 g along x, 1 g along z."""
    return {"fx": 0.5 * G, "fz": G, "wx": radians(100.0), "wz": radians(-100.0), "temperature": 25.0}


def counting(t: Any) -> dict[str, Any]:
    """Accelerometer x counts 16384 a second, gyroscope x 1640 a second."""
    return {"fx": (t % 1.0) * G, "wx": radians(100.0) * (t % 10.0)}


def fifo_rig(
    config: int, motion: Any = steady, *writes: tuple[int, int], listen: str = "", **options: Any
) -> Rig:
    """Both sensors at 100 Hz; FIFO switched on and emptied between 299 and 300 ms."""
    rig = Rig(motion, listen=listen, **options)
    rig.start()
    for register, value in writes:
        rig.write(register, value, gap_ns=2_000)
    rig.until(299 * MS)
    rig.write(0x47, config, gap_ns=2_000)
    rig.write(0x7E, 0xB0, gap_ns=2_000)
    return rig


def length(rig: Rig) -> int:
    """Bytes in the FIFO, as the chip tells."""
    return int.from_bytes(rig.read(0x22, 2), "little")
