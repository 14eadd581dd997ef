"""Where each quantity of the drift compensation lies in its two flat arrays.

`d` (float32) and `k` (int64) are all its memory; a copy of both is a complete snapshot. Frames: b = body,
free = follows the gyros alone and drifts slowly, level = its z axis points down, n = north-east-down.
A smoother of n channels takes 2 n places: n of its first integrator, n of its second (see `smoothing`).
"""

from typing import Final

# --- d: the solution ---
Q_NB: Final = 0
"""Body to north-east-down, scalar first: the result."""
Q_FREE: Final = 4
"""Body to the free frame."""
Q_LEVEL: Final = 8
"""Free to the level frame."""
HEADING: Final = 12
"""Level to north-east-down, rad, (−π, π]."""
GYRO_BIAS: Final = 13
"""rad/s, body axes."""
BIAS_COVARIANCE: Final = 16
"""(rad/s)²: xx, xy, xz, yy, yz, zz."""

# --- d: smoothers ---
FORCE_AGE: Final = 22
"""s for which the mean of force and motion has been taken; at its time constant the filter proper begins."""
FORCE: Final = 23
"""Specific force in the free frame, 3 channels."""
MOTION: Final = 29
MOTION_CHANNELS: Final = 9
"""Direction cosines body to level north and east (6), bias in north and east (2), rate about the vertical."""
REST_RATE_AGE: Final = 53
REST_RATE: Final = 54
REST_FORCE_AGE: Final = 60
REST_FORCE: Final = 61
FIELD_AGE: Final = 67
FIELD: Final = 68
"""Norm and dip of the magnetic field."""

# --- d: rest, field, heading ---
REST_TIME: Final = 72
FIELD_NORM: Final = 74
"""Of the undisturbed field as it is known; 0 while it is not. Unit as fed."""
FIELD_DIP: Final = 75
"""rad, positive downwards."""
UNDISTURBED_TIME: Final = 76
REJECTED_TIME: Final = 77
CANDIDATE_NORM: Final = 78
CANDIDATE_DIP: Final = 79
CANDIDATE_TIME: Final = 80
HEADING_AGE: Final = 81
HEADING_VARIANCE: Final = 82
"""rad²."""
LEVEL_RATE: Final = 83
"""Rate about north and east with which levelling turned in the last sample, rad/s."""

# --- d: rates ---
RATE: Final = 85
"""Last good rate as measured."""
SLOPE: Final = 88
"""rad/s², of the last two good rates."""
CLIPPED_TIME: Final = 91
"""s for which an axis has been saturated, 0 otherwise."""
ENTRY_SLOPE: Final = 94
ENTRY_RATE: Final = 97
"""Last rate before saturation."""
MISSING_TIME: Final = 100
"""s without a usable rate."""
BIAS_PAUSE: Final = 101
"""s for which motion tells nothing about the bias, after an angle was lost."""

# --- d: coefficients of the present sample interval ---
DT: Final = 102
USUAL_DT: Final = 103
FORCE_GAIN: Final = 104
"""Two numbers of `smoothing.coefficients`; so for the next two."""
REST_GAIN: Final = 106
FIELD_GAIN: Final = 108

# --- d: settings ---
RATE_LIMIT: Final = 110
"""Rates of this magnitude are saturated, rad/s; 0: never."""
DECLINATION: Final = 111
"""rad, east positive."""
GYRO_DELAY: Final = 112
"""s by which rates are older than the time they are told for."""
D_SIZE: Final = 113

# --- k ---
FLAGS: Final = 0
SAMPLES: Final = 1
"""Since the start; 0 before the first."""
SATURATED_SAMPLES: Final = 2
GAPS: Final = 3
BAD_RATES: Final = 4
BAD_FORCES: Final = 5
MISSING_FIELDS: Final = 6
BAD_INTERVALS: Final = 7
LOSSES: Final = 8
"""Times that an angle was lost, so that the attitude had to be regained."""
LEAVING: Final = 9
"""3 places: 1 for an axis whose first unsaturated rate has come."""
K_SIZE: Final = 12

# --- bits of k[FLAGS]: what was so at the last sample ---
AT_REST: Final = 1
FIELD_DISTURBED: Final = 2
FIELD_MISSING: Final = 4
SATURATED: Final = 8
REGAINING: Final = 16
"""An angle was lost, or the start; levelling or heading are still being averaged."""
NO_RATE: Final = 32
NO_FORCE: Final = 64
GAP: Final = 128

# --- a sample for `step` ---
SAMPLE_DT: Final = 0
SAMPLE_OMEGA: Final = 1
SAMPLE_FORCE: Final = 4
SAMPLE_FIELD: Final = 7
SAMPLE_SIZE: Final = 10
