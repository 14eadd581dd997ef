"""Where each quantity of the attitude computer lies in its two flat arrays.

`s` holds what has fractions: float32, float64 or, in the fixed-point loop, int32 in the formats of
`fixed.formats`. `i` (int64) holds the rest. The places are the same for all three, nothing is allocated in
flight, and a copy of both arrays is a complete snapshot. Vectors take 3 places, matrices are row by row,
q_nb is scalar first. Axes: n = north-east-down, b = body (front, right, down), s = the sensor's own.
"""

# --- s: estimate ---
QUATERNION = 0
"""q_nb."""
VELOCITY = 4
"""m/s, NED."""
GYRO_BIAS = 7
"""rad/s, body axes; taken off each rate inside of `iterate`."""

# --- s: samples, mounting applied ---
OMEGA = 10
"""ω_ib as measured, rad/s: three at t, t + T/2 and t + T."""
FORCE = 19
"""f_b as measured less ACCEL_BIAS, m/s², at the same times."""
FIELD = 28
"""m_b, newest, T."""
NEWEST = 6
"""OMEGA + NEWEST and FORCE + NEWEST are of the newest sample."""
C_N_B = 31
"""Direction cosines of q_nb as it was at the beginning of the last iteration."""

# --- s: the Earth here, refreshed every 16 iterations ---
EARTH_RATE_N = 40
EARTH_RATE_D = 41
PER_MERIDIAN_RADIUS = 42
"""1 / (R_M + h)."""
PER_NORMAL_RADIUS = 43
"""1 / (R_N + h)."""
TAN_LATITUDE = 44
PER_COS_LATITUDE = 45
GRAVITY = 46

# --- s: alignment ---
SUM_OMEGA = 47
"""Of the samples so far. The fixed-point loop keeps its sums in `i`."""
SUM_FORCE = 50
SUM_FIELD = 53

# --- s: what the integers of the position left over ---
LATITUDE_REST = 56
LONGITUDE_REST = 57
HEIGHT_REST = 58

# --- s: configuration ---
PERIOD = 59
"""T of an iteration, s."""
C_B_S = 60
GYRO_SCALE = 69
"""rad/s a count; then m/s² and T a count."""
ACCEL_SCALE = 70
FIELD_SCALE = 71
ACCEL_BIAS = 72
DECLINATION = 75
"""rad, east positive."""
GIVEN_YAW = 76
REST_RATE = 77
"""The largest rate on any axis that is still rest, rad/s."""
REST_FORCE = 78
"""How far |f| may be from gravity at rest, m/s²."""
PER_ALIGNMENT = 79
"""1 / number of samples of the alignment."""
LEAST_FIELD = 80
"""|m| between these two is the Earth's, T."""
MOST_FIELD = 81
S_SIZE = 96

# --- i ---
MODE = 0
METHOD = 1
ITERATIONS = 2
IN_RING = 3
"""Samples waiting for the next iteration, the shared one included: 3 are enough."""
LATITUDE = 4
"""2⁻⁴⁰ rad."""
LONGITUDE = 5
HEIGHT = 6
"""2⁻²⁰ m above the ellipsoid."""
NOTICED = 7
"""What was noticed about the newest sample (flags.py)."""
NOTICED_SINCE = 8
"""The same of all samples since the last `solution`."""
BRIDGED_IN_A_ROW = 9
ALIGNMENT_COUNT = 10
FIELD_COUNT = 11
"""Samples of the alignment with a field that can be the Earth's."""
ALIGNMENT_SAMPLES = 12
USE_FIELD = 13
"""1: yaw from the magnetometer."""
NULL_GYROS = 14
"""1: GYRO_BIAS from the mean rate of the alignment."""
DRIFT_COMPENSATION = 15
"""1: the drift filter corrects after each iteration; `iterate` itself does not look at it."""
GYRO_LIMIT = 16
"""Counts from which a rate is beyond the range."""
LONGEST_BRIDGE = 17
"""Samples in a row; more, and the rates are lost."""
SAMPLES = 18
"""Taken so far, the bridged ones included."""
NOTICES = 24
"""How often each bit of NOTICED was set (16)."""
SATURATIONS = 40
"""Of the fixed-point loop, by kind (flags.SATURATION_NAMES, 8)."""
FIXED_SUMS = 48
"""Sums of the alignment in fixed point (9)."""
FIXED_REST = 57
"""What the integers of the position left over in fixed point (3)."""
VELOCITY_REST = 60
"""What VELOCITY left over in fixed point (3)."""
QUATERNION_REST = 64
"""What QUATERNION left over in fixed point (4)."""
I_SIZE = 72

# --- the record of `solution`, int64, the same for every arithmetic ---
OUT_YAW = 0
"""1e-9 rad, [0, 2π); then pitch and roll."""
OUT_PITCH = 1
OUT_ROLL = 2
OUT_RATE = 3
"""ω_ib less GYRO_BIAS, newest, 1e-9 rad/s, body axes."""
OUT_VELOCITY = 6
"""1e-6 m/s, NED."""
OUT_LATITUDE = 9
"""1e-9 degree."""
OUT_LONGITUDE = 10
OUT_HEIGHT = 11
"""1e-6 m."""
OUT_MODE = 12
OUT_FLAGS = 13
OUT_SATURATIONS = 14
"""All kinds together."""
OUT_ITERATIONS = 15
OUT_QUATERNION = 16
"""q_nb, 1e-9."""
OUT_GYRO_BIAS = 20
"""1e-9 rad/s, body axes."""
OUT_SIZE = 24
