"""Where each quantity of the navigation state lies in the two flat arrays.

`f` (float32) and `i` (int64) are all the memory that navigation has: nothing is allocated in flight, and a
copy of both is a complete snapshot. Vectors take 3 places, matrices are row by row, quaternions q_nb scalar
first. Axes: n = north-east-down, b = the body axes of the board description (front, right, down),
s = the sensor's own axes, v = the vehicle's.

Error state (36), each the truth minus the estimate, in this order:

    0  δr      position, m, NED            15  GNSS position error, m, NED (first-order Gauss-Markov)
    3  δv      velocity, m/s, NED          18  mounting yaw, pitch of the vehicle in body axes, rad
    6  φ       attitude, rad, NED          20  GNSS latency beyond what the time tag allows for, s
    9  δb_g    gyro bias, rad/s, body      21  response of gyros x, y, z to the yaw rate
    12 δb_a    accelerometer bias, m/s²    24  response of accelerometers x, y, z to f_x, 27 to f_y
                                           30  gyro bias per kelvin of the chip, rad/s/K
                                           33  gyro instability, rad/s (first-order Gauss-Markov)

A response is what a sensor shows per unit of the quantity beyond what it should: a scale factor error on its
own axis, a misalignment on the others. Those to f_z, which is gravity, are part of the biases.
"""

# --- error state ---
STATES = 36
DYNAMIC_STATES = 9
X_POSITION = 0
X_VELOCITY = 3
X_ATTITUDE = 6
X_GYRO_BIAS = 9
X_ACCEL_BIAS = 12
X_GNSS_ERROR = 15
X_MOUNTING = 18
X_LATENCY = 20
X_YAW_RESPONSE = 21
X_FORCE_RESPONSE = 24
X_GYRO_PER_KELVIN = 30
X_GYRO_INSTABILITY = 33

# --- f: estimate ---
QUATERNION = 0
VELOCITY = 4
HEIGHT = 7
"""m above the ellipsoid; HEIGHT_REST is what one float32 cannot hold of it."""
HEIGHT_REST = 8
GYRO_BIAS = 9
"""From here 27 parameters, in the order of the error state."""
ACCEL_BIAS = 12
GNSS_ERROR = 15
MOUNTING = 18
LATENCY = 20
YAW_RESPONSE = 21
FORCE_RESPONSE = 24
GYRO_PER_KELVIN = 30
GYRO_INSTABILITY = 33
PARAMETERS = 27

C_N_B = 36
"""Direction cosines of QUATERNION."""
OMEGA_B = 45
"""Last compensated rate ω_ib, rad/s."""
FORCE_B = 48
"""Last compensated specific force, m/s²."""
DELTA_ANGLE = 51
"""Angle increment of the last step, rad, and velocity increment, m/s: the first of the two samples."""
DELTA_VELOCITY = 54
RAW = 57
"""Last sample as it came (6), in sensor axes: for stuck sensors."""

# --- f: the Earth at the present place (refreshed at each check) ---
EARTH_RATE_N = 63
EARTH_RATE_D = 64
PER_MERIDIAN_RADIUS = 65
"""1 / (R_M + h)."""
PER_NORMAL_RADIUS = 66
"""1 / (R_N + h)."""
TAN_LATITUDE = 67
PER_COS_LATITUDE = 68
GRAVITY = 69
MERIDIAN_RADIUS = 70
PARALLEL_RADIUS = 71
"""(R_N + h) cos φ."""

# --- f: since the covariance was last propagated ---
SINCE_TIME = 72
SINCE_VELOCITY = 73
SINCE_YAW_ANGLE = 76
"""∫ω_z dt, then ∫f_x dt and ∫f_y dt."""
SINCE_FORCE = 77
SINCE_C_N_B = 79
"""Direction cosines when the interval began; at rest those of its first interval, whatever is corrected."""
PARAMETER_TIME = 88
"""s since process noise was last added to the parameters."""
LOST_TILT = 89
"""Extra variances of dead time: tilt and yaw rad², velocity (m/s)², position m²."""
LOST_YAW = 90
LOST_VELOCITY = 91
LOST_POSITION = 92

# --- f: covariance P = U D Uᵀ ---
U = 96
"""Unit upper triangular, column by column: U[k, j] at U + 36 j + k; the ones are not stored."""
D = U + STATES * STATES
ROWS = D + STATES
"""Measurement rows H of up to six scalars."""
ROW_LIMIT = 6
PROJECTED = ROWS + ROW_LIMIT * STATES
"""Uᵀ hᵀ of the same."""
GAIN = PROJECTED + ROW_LIMIT * STATES
CORRECTION = GAIN + STATES
"""Estimated error, waiting for its feedback."""
RESIDUAL = CORRECTION + STATES
VARIANCE = RESIDUAL + ROW_LIMIT
INNOVATION_SIGMA = VARIANCE + ROW_LIMIT
TRIANGLE = INNOVATION_SIGMA + ROW_LIMIT
"""3 x 3 innovation covariance of the group under test, then its weighted residual."""
WEIGHT = TRIANGLE + 12
"""Work space of the attitude reset: three weights, three columns of nine."""
TURNED = WEIGHT + 3
LAST_INNOVATION = TURNED + 27
"""Of the last GNSS epoch: position NED m, velocity m/s (NED, or along and across the course, 0)."""
LAST_INNOVATION_SIGMA = LAST_INNOVATION + 6

# --- f: history ---
RING_SIZE = 128
RING_MASK = RING_SIZE - 1
RING_FLOATS = 8
RING_F = LAST_INNOVATION_SIGMA + 6
"""Velocity 3, quaternion 4, height."""
AGO = RING_F + RING_SIZE * RING_FLOATS
"""The state looked up in the history: velocity 3, quaternion 4, height, acceleration 3, rate ω_nb 3."""
AGO_VELOCITY = AGO
AGO_QUATERNION = AGO + 3
AGO_HEIGHT = AGO + 7
AGO_ACCELERATION = AGO + 8
AGO_RATE = AGO + 11
LOG_SIZE = 32
LOG_MASK = LOG_SIZE - 1
LOG_F = AGO + 14
"""Corrections made, 9 each: what the states in the ring do not know yet."""

# --- f: alignment and stillness ---
WINDOW_REFERENCE = LOG_F + 9 * LOG_SIZE
"""First sample of the window (6): sums are of differences to it."""
WINDOW_SUM = WINDOW_REFERENCE + 6
WINDOW_SQUARES = WINDOW_SUM + 6
"""Sum of squared differences: of the rates, of the specific forces."""
WINDOW_TIME = WINDOW_SQUARES + 2
WINDOW_MEAN = WINDOW_TIME + 1
WINDOW_VELOCITY = WINDOW_MEAN + 6
"""Velocity (n) when the window began."""
LEVEL_SUM = WINDOW_VELOCITY + 3
"""Sum of the means of still windows, and of the temperature."""
REST_RATE = LEVEL_SUM + 7
"""Mean rate at rest, with Earth rate in it, and the attitude and time span it belongs to."""
REST_QUATERNION = REST_RATE + 3
REST_TIME = REST_QUATERNION + 4
REST_TEMPERATURE = REST_TIME + 1
START_INTEGRALS = REST_TEMPERATURE + 1
"""At the start of an alignment in motion: ∫f dt 3, ∫ω dt 3, speed, course, sink rate."""
SIDE_SPEED = START_INTEGRALS + 9
"""Sums over the interval between two constraints of the vehicle: v_b 3 and their number."""
GNSS_SPEED = SIDE_SPEED + 4
"""Low-passed GNSS velocity NED: is it standing?"""
GNSS_FIX = GNSS_SPEED + 3
"""Last fix: height, velocity 3, speed, horizontal 1 σ, vertical 1 σ."""
EPOCH_WEIGHT = GNSS_FIX + 7
"""Factor on the variances of the present epoch."""
GOOD_HEIGHT = EPOCH_WEIGHT + 1
AT_REST = GOOD_HEIGHT + 1
"""1 from a window at rest to one that is not."""

# --- f: configuration (see NavConfig) ---
TEMPERATURE = AT_REST + 1
"""Of the chip, °C: the one that counts, the one the gyro bias was brought to, the last one told."""
BIAS_TEMPERATURE = TEMPERATURE + 1
TOLD_TEMPERATURE = TEMPERATURE + 2
SCATTER = TEMPERATURE + 3
"""White variance of the receiver's position as met, m², and what the last epoch left of its residuals."""
LEFT_RESIDUAL = SCATTER + 1
SCATTER_COUNT = SCATTER + 3
SCATTER_SHARE = SCATTER + 4
"""Which share of the configured white variance is enough."""
AXIS_REPEATS = SCATTER + 5
"""For how many samples in a row each axis (gyros, then accelerometers) has read the same."""
CONFIG = AXIS_REPEATS + 6
F_SIZE = CONFIG + 92

# --- i ---
TIME = 0
"""Board clock of the state, ns; the other times below too."""
LATITUDE = 1
"""2⁻⁴⁰ rad."""
LONGITUDE = 2
MODE = 3
RING_HEAD = 4
RING_COUNT = 5
LOG_HEAD = 6
LOG_COUNT = 7
HAVE_SAMPLE = 8
"""1 when the sample before can serve as one end of an interval."""
GOOD_SAMPLE_TIME = 9
"""Of the last plausible sample."""
UNCHANGED = 10
"""Samples in a row equal to the one before."""
WINDOW_SAMPLES = 11
LEVEL_WINDOWS = 12
LEVELLED_AT = 13
START_TIME = 14
"""First epoch of the alignment in motion; NEVER before it."""
EPOCH_TIME_OF_DAY = 15
"""ms; of the last GNSS epoch, and its validity on the board clock."""
EPOCH_VALID = 16
EPOCHS_TO_WAIT = 17
"""Epochs to wait for until a new time of day is believed."""
FIX_TIME = 18
"""Validity of the last usable fix, and its place (2⁻⁴⁰ rad)."""
FIX_LATITUDE = 19
FIX_LONGITUDE = 20
POSITION_REFUSED_SINCE = 21
"""First of the refused epochs in a row; NEVER when the last one was accepted."""
VELOCITY_REFUSED_SINCE = 22
HEADING_WRONG_SINCE = 23
PATIENCE_NS = 24
"""For how long a measurement is refused before the gate is widened."""
GOOD_TIME = 25
"""Last state that was checked and sound (place below, height in f)."""
GOOD_LATITUDE = 26
GOOD_LONGITUDE = 27
INNOVATION_TIME = 28
INNOVATION_MASK = 29
"""Bit k: row k of the innovation was used."""
CONSTRAINT_DUE = 30
AGO_LATITUDE = 31
AGO_LONGITUDE = 32
DEAD_UNTIL = 33
"""End of the last dead time."""
CHECK_DUE = 34
QUIET_IS_NO_REST = 35
"""1: this stretch of quiet windows began in motion, as GNSS told."""
SENSOR_REPEATS = 36
"""1: this sensor was seen to repeat its readings at rest (no noise): repetition alone tells nothing."""
UPDATES = 37
"""GNSS epochs absorbed."""
SCATTER_TIME = 38
"""Of the epoch that LEFT_RESIDUAL is of; NEVER when it was not absorbed."""
POSITION_TIME = 39
"""Of the last position absorbed, where its lasting error is weighed (gnss_noise)."""

EVENT_TIME = 40
"""When each event last happened, in the order of `flags`."""
EVENT_COUNT = 56
EVENT_KINDS = 16

RING_I = 72
"""Time, latitude, longitude."""
LOG_TIME = RING_I + 3 * RING_SIZE
SWITCHES = LOG_TIME + LOG_SIZE
"""Configuration in integers."""
I_SIZE = SWITCHES + 24
NEVER = -(2**62)
NO_TEMPERATURE = -1.0e3
