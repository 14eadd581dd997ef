"""Where each quantity lies, and its Q format: value = integer · 2^(−Q).

`d` (int32) holds everything that is read with a format; `k` (int64) flags, counters, and what is kept finer
than 32 bits. Angles that stand for themselves are binary (a turn is 2³²). Ranges:

    quantity                        Q    range            unit
    quaternions, direction cosines  30   ±2               1e-9
    rates as measured               25   ±64 rad/s        3e-8 (2000 °/s are 35)
    bias, rates of levelling        34   ±0.125 rad/s     6e-11 (the bias is held within 0.035)
    turn of a sample                32   ±0.5 rad         2e-10
    specific force                  22   ±512 m/s²        2e-7; limited to ±160 before it is smoothed
    magnetic field                  41   ±9.8e-4 T        5e-13; beyond 5e-4 T there is no Earth's field
    smoothing gains g               31   ±1               5e-10
    variance of the bias            30   ±2 (°/s)²        1e-9
    1/T of the heading              24   ±128 1/s         6e-8
"""

from typing import Final

# --- d: solution ---
Q_NB: Final = 0
Q_FREE: Final = 4
Q_LEVEL: Final = 8
HEADING: Final = 12
"""Binary."""
GYRO_BIAS: Final = 13

# --- d: smoothers ---
FORCE: Final = 16
MOTION: Final = 22
MOTION_CHANNELS: Final = 9
REST_RATE: Final = 40
REST_FORCE: Final = 46
FIELD: Final = 52
"""Norm and dip (binary)."""

# --- d: the rest of the state ---
BIAS_VARIANCE: Final = 56
"""About the vertical."""
HEADING_PACE: Final = 57
"""1/T of the heading."""
FIELD_NORM: Final = 58
FIELD_DIP: Final = 59
CANDIDATE_NORM: Final = 60
CANDIDATE_DIP: Final = 61
LEVEL_RATE: Final = 62
RATE: Final = 64
TURN: Final = 67
"""Of the last sample, bias taken off."""

# --- d: settings ---
PERIOD: Final = 70
PER_PERIOD: Final = 71
FORCE_GAIN: Final = 72
"""g and 1/(1 + √2 g + g²); so for the next two."""
REST_GAIN: Final = 74
FIELD_GAIN: Final = 76
REFERENCE_SHARE: Final = 78
RATE_LIMIT: Final = 79
"""0: never saturated."""
DECLINATION: Final = 80
D_SIZE: Final = 81

# --- k: the first places are those of `..layout` ---
FLAGS: Final = 0
SAMPLES: Final = 1
SATURATED_SAMPLES: Final = 2
BAD_FORCES: Final = 5
MISSING_FIELDS: Final = 6
LOSSES: Final = 8
FORCE_AGE: Final = 12
"""Ages and times in samples."""
REST_AGE: Final = 13
FIELD_AGE: Final = 14
HEADING_AGE: Final = 15
REST_TIME: Final = 16
UNDISTURBED_TIME: Final = 17
REJECTED_TIME: Final = 18
CANDIDATE_TIME: Final = 19
BIAS_PAUSE: Final = 20
FINE_BIAS: Final = 21
"""GYRO_BIAS in Q50 (3)."""
FINE_HEADING: Final = 24
"""HEADING · 2¹⁶."""
FINE_PACE: Final = 26
"""HEADING_PACE in Q40."""
SATURATIONS: Final = 27
"""Numbers that did not fit their format, or were limited to it."""
SETTLED: Final = 28
"""Samples in 3 s, 0.5 s, 0.05 s, 5 s: when the means become filters."""
REST_AFTER: Final = 32
BELIEVED_AFTER: Final = 33
LONGEST_REJECTION: Final = 34
NEW_AFTER: Final = 35
FIRST_AFTER: Final = 36
PAUSE: Final = 37
YOUNG: Final = 38
"""Age that is left to the mean of the force after saturation."""
UNLEVELLED_AGE: Final = 39
ALIGNED_AGES: Final = 40
"""Ages of the mean force and of the mean heading that the loop's alignment counts for."""
FINE_COVARIANCE: Final = 42
"""Of the bias: xx, xy, xz, yy, yz, zz in (°/s)², Q50."""
MISSING_TIME: Final = 48
"""Samples without rates in a row."""
LONGEST_MISSING: Final = 49
"""More in a row, and all is lost."""
K_SIZE: Final = 50

# --- a sample for `step` ---
SAMPLE_OMEGA: Final = 0
SAMPLE_FORCE: Final = 3
SAMPLE_FIELD: Final = 6
SAMPLE_SIZE: Final = 9
MISSING: Final = -(1 << 31)
"""A value that is none."""

Q_UNIT: Final = 30
Q_RATE: Final = 25
Q_BIAS: Final = 34
Q_FINE_BIAS: Final = 50
Q_TURN: Final = 32
Q_FORCE: Final = 22
Q_FIELD: Final = 41
Q_GAIN: Final = 31
Q_PERIOD: Final = 36
Q_PER_PERIOD: Final = 20
Q_VARIANCE: Final = 30
Q_FINE_VARIANCE: Final = 50
Q_PACE: Final = 24
Q_FINE_PACE: Final = 40
