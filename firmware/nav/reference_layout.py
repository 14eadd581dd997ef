"""Where the attitude reference keeps its things: behind the arrays of navigation, on boards that have one.

The reference is what measures attitude from outside: two antennas, or a compass. A board without one leaves
this memory out and uses the places for its own (layout). Angles stand in the order of ANGLES everywhere:
heading, pitch, roll.
"""

from firmware.nav import layout as at

ANGLES = 3
HEADING = 0
PITCH = 1
ROLL = 2

# --- f: the last record used ---
INNOVATION = at.F_SIZE
"""rad; and √S of each. 0 where the record held no such angle."""
INNOVATION_SIGMA = INNOVATION + ANGLES
PREDICTED = INNOVATION_SIGMA + ANGLES
"""Angles of the reference's axes as navigation has them."""

# --- f: yaw at the beginning ---
START_TURN = PREDICTED + ANGLES
"""Mean angle from the level axes to north, of the records that agreed so far."""
COMPASS_SUM = START_TURN + 1
"""Sum of the mean rates of quiet windows in a row (3), and their time in s."""
COMPASS_SECONDS = COMPASS_SUM + 3
FIRST_FORCE = COMPASS_SECONDS + 1
"""Mean specific force of the first window of them, and of the last."""
LAST_FORCE = FIRST_FORCE + 3

# --- f: heading refused for long ---
REFUSED_MEAN = LAST_FORCE + 3
"""Residual of the headings refused in a row, low-passed."""
AGAINST_INERTIAL = REFUSED_MEAN + 1
"""Sum of squared differences of the course from the inertial heading, and from the reference's."""
AGAINST_REFERENCE = AGAINST_INERTIAL + 1

# --- f: configuration ---
C_B_A = AGAINST_REFERENCE + 1
"""From the axes that the angles belong to, to body axes, row by row."""
LENGTH = C_B_A + 9
LENGTH_TOLERANCE = LENGTH + 1
WHITE_VARIANCE = LENGTH_TOLERANCE + 1
ERROR_VARIANCE = WHITE_VARIANCE + ANGLES
ERROR_MEMORY = ERROR_VARIANCE + ANGLES
"""s over which a correlated error counts once: twice its correlation time."""
COMPASS_TIME = ERROR_MEMORY + 1
COMPASS_LEAST_TIME = COMPASS_TIME + 1
SMALL_REFUSAL = COMPASS_LEAST_TIME + 1
F_END = SMALL_REFUSAL + 1

# --- i ---
TIME = at.I_SIZE
"""Validity of the last record with an angle, board clock, ns."""
MASK = at.I_SIZE + 1
"""Bit k: angle k of it was used."""
YAW_SOURCE = at.I_SIZE + 2
USED = at.I_SIZE + 3
REFUSED = at.I_SIZE + 4
FLIPPED = at.I_SIZE + 5
WRONG_LENGTH = at.I_SIZE + 6
MISSING = at.I_SIZE + 7
LAST_USED = at.I_SIZE + 8
"""Validity of the last heading, pitch and roll used; NEVER before the first."""
START_COUNT = LAST_USED + ANGLES
REFUSED_SINCE = START_COUNT + 1
"""Validity of the first of the headings refused in a row; NEVER when the last one was used."""
WITNESSED = START_COUNT + 2
"""Epochs among them that the course judged."""
VELOCITY_TOO = START_COUNT + 3
"""1: meanwhile the velocity was refused as well, for some seconds in a row."""
FIRST_EPOCHS = START_COUNT + 4
REJOIN_NS = START_COUNT + 5
LOST_NS = START_COUNT + 6
I_END = START_COUNT + 7

# --- values of YAW_SOURCE ---
NO_YAW = 0
GIVEN = 1
COURSE = 2
BASELINE = 3
GYROCOMPASS = 4
YAW_SOURCE_NAMES = ("none", "given", "course", "baseline", "gyro-compass")
