"""Messages with values that fit their fields exactly, for round trips."""

import numpy as np

from firmware.drivers.satellite_lists import SatelliteInView
from firmware.link import frames
from host.link import messages as msg


def floats(count: int, seed: int = 1) -> tuple[float, ...]:
    """Numbers that float32 holds exactly."""
    return tuple(np.random.default_rng(seed).normal(size=count).astype(np.float32).tolist())


SOLUTION = msg.Solution(
    123_456_789_012, 34_045_000, 16_140, 3, 0x1234, 50_502_057_500, -4_259_053_500, *floats(19)
)
COVARIANCE = msg.Covariance((10**12, *floats(45)))
INNOVATION = msg.Innovation((10**12 + 1, 0b10_1111, *floats(12)))
BIAS = msg.Bias((10**12 + 2, *floats(18)))
STATUS = msg.Status(10**12 + 3, 4, 0x2001, 1, 2**32 - 1, 3, 4, 5, 65535, 7, 8, 1)
GNSS = msg.Gnss(
    10**12 + 4, 86_399_999, 0, 0x1FF, -(90 * 10**9), 180 * 10**9, -400_000, 2**31 - 1, 1, 35_999_999,
    -1, 2, -3, 255, 9999, 2**32 - 1, 4,
)  # fmt: skip
FIXED = (
    (frames.SOLUTION, SOLUTION),
    (frames.COVARIANCE, COVARIANCE),
    (frames.INNOVATION, INNOVATION),
    (frames.BIAS, BIAS),
    (frames.STATUS, STATUS),
    (frames.GNSS, GNSS),
)
TASKS = tuple(msg.TaskFigures(f"task {n}", n, 7 * n, 10 * n, n) for n in range(15))
SATELLITES = tuple(
    SatelliteInView(system, n, None if n % 7 == 0 else n % 90, n * 9, None if n % 5 == 0 else n, n % 2 == 0)
    for n, system in enumerate(["GPS", "GLONASS", "Galileo", "BeiDou", "QZSS", "SBAS", "other"] * 6, start=1)
)


def transmission(writer: frames.FrameWriter) -> tuple[bytes, list[tuple[int, msg.Message]]]:
    """(bytes, messages) of one frame of every type."""
    data = b"".join(writer.pack(kind, *values) for kind, values in FIXED) + writer.text("IMU silent: ± ok")
    return data, [*FIXED, (frames.TEXT, "IMU silent: ± ok")]
