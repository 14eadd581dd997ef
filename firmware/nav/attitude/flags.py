"""Modes, update methods and what is noticed about samples, by name."""

ALIGNING = 0
RUNNING = 1
MODE_NAMES = ("aligning", "running")

RK4 = 0
ROTATION_VECTOR_1 = 1
ROTATION_VECTOR_2 = 2
ROTATION_VECTOR_3 = 3
ROTATION_VECTOR_4 = 4
TWO_SAMPLE = 5
EULER_ANGLES = 6
DIRECTION_COSINES = 7
METHOD_NAMES = (
    "rk4", "rotation_vector_1", "rotation_vector_2", "rotation_vector_3", "rotation_vector_4",
    "two_sample", "euler_angles", "direction_cosines",
)  # fmt: skip

# Bits of layout.NOTICED and of the flags of a solution.
STALE = 1
"""ND is missing: an inertial register was read before, its value stands for this time too."""
CHIP_ERROR = 2
"""EA: the chip reports an error or alarm."""
SUPPLY = 4
"""Outside 4.75 V … 5.25 V."""
GYRO_SATURATED = 8
NO_ANSWER = 16
"""All words 0x0000 or all 0xFFFF."""
SLIPPED = 32
"""Supply or pressure cannot be what they say: words stand in each other's places."""
FIELD_IMPLAUSIBLE = 64
"""The magnetometer is missing, or something else than the Earth is near."""
BRIDGED = 128
"""This sample was not used; the one before stands for it."""
MOVED = 256
"""Not at rest: the alignment began anew."""
RATES_LOST = 512
"""Bridged for longer than allowed: attitude is not known any more."""
OVERRUN = 1024
"""A sample came before `iterate` had used those before it."""
YAW_GIVEN = 2048
"""Yaw wanted the magnetometer, which had no field to tell: it is the one given."""
NOTICE_NAMES = (
    "stale", "chip_error", "supply", "gyro_saturated", "no_answer", "slipped", "field_implausible",
    "bridged", "moved", "rates_lost", "overrun", "yaw_given",
)  # fmt: skip

# Kinds of saturation in fixed point: places after layout.SATURATIONS.
SATURATED_RATE = 0
SATURATED_FORCE = 1
SATURATED_FIELD = 2
SATURATED_ANGLE = 3
SATURATED_ATTITUDE = 4
SATURATED_VELOCITY = 5
SATURATED_EARTH = 6
SATURATED_HEIGHT = 7
SATURATION_NAMES = (
    "rate", "force", "field", "angle", "attitude", "velocity", "earth", "height",
)  # fmt: skip
