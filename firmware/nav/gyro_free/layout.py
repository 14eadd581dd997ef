"""Where each quantity of the gyro-free sensor lies in its two flat arrays, `g` (float32) and `n` (int64).

The filters have the arrays of the navigation core (`firmware.nav.layout`), one pair each. Axes b: front,
right, down. Matrices row by row. Nothing is allocated in flight; both arrays are a complete snapshot.
"""

# --- g: the newest sample ---
ACCELERATION = 0
"""A1 … A9, m/s², after scale and offset of each accelerometer."""
ANGULAR_ACCELERATION = 9
"""ω̇, rad/s²; then that of the sample before."""
ANGULAR_ACCELERATION_BEFORE = 12
PRODUCTS = 15
"""ω_x ω_y, ω_y ω_z, ω_x ω_z, rad²/s²; then those of the sample before."""
PRODUCTS_BEFORE = 18
OMEGA = 21
"""ω_ib by the method chosen, calibrated, rad/s."""
FORCE = 24
"""f_b, calibrated, m/s²."""

# --- g: the methods ---
INTEGRAL = 27
"""∫ω̇ dt from the beginning."""
METHOD_RATE = 30
"""What the method chosen gave, before calibration."""
FUSED = 33
"""ω of the filter over ω̇ and the products, its covariance 3 × 3, and a gain."""
FUSED_COVARIANCE = 36
GAIN = 45
WORK = 48
"""3 × 3."""
ANGULAR_ACCELERATION_TWO_BEFORE = 109
FUSED_REST = 112
"""What the float32 of FUSED could not hold."""

# --- g: configuration ---
PER_TWO_ARMS = 57
"""1 / 2l."""
RATE_NOISE_VARIANCE = 58
"""Of ω̇ and of a product, (rad/s²)²: (σ_a / l)²."""
LEAST_PRODUCT = 59
"""Below, a product is no divisor."""
LEAST_CHANGE = 60
"""Below, the change of a product over a sample is no divisor."""
SCALE = 61
"""m/s² a word of the packet, each accelerometer."""
OFFSET = 70
"""m/s², taken off after the scale."""
RATE_MATRIX = 79
"""ω = M (rate of the method) − b."""
RATE_BIAS = 88
FORCE_MATRIX = 91
FORCE_BIAS = 100
COMPASS_DEVIATION = 103
"""A … E, rad."""
DECLINATION = 108
"""rad, east positive."""
INTEGRAL_REST = 115
INCREMENT = 118
"""∫ω̇ dt over the last interval."""
INCREMENT_VARIANCE = 121
"""Per s², of an angular acceleration as the filter takes it."""

# --- g: filters side by side, configuration ---
COMPASS_VARIANCE = 122
"""White, of φ north, east, down, rad²."""
GPS_VARIANCE = 125
"""White, of position (horizontal, vertical) and of velocity, each axis."""
GATE_2 = 128
"""χ² of two measurements, then of three, then of a difference between filters."""
GATE_3 = 129
GATE_DIFFERENCE = 130
NO_INFORMATION = 131
"""Variances of a filter that knows nothing: position, velocity, attitude, biases, error of the compass."""
COMPASS_ERROR_VARIANCE = 137
"""Of the Gauss-Markov error of the compass when nothing is known of it: tilt, heading."""
NOISE_SHARE = 139
"""By how much the process noise of each filter is enlarged at present (3)."""


# --- g: work space of the fusion ---
FACTOR = 144
"""V of P = V Δ V', 18 × 18 column by column, of the estimate being passed on; then V⁻¹ row by row."""
FACTOR_STATES = 18
WHITE = FACTOR + FACTOR_STATES * FACTOR_STATES
FACTOR_D = WHITE + FACTOR_STATES * FACTOR_STATES
DIFFERENCE = FACTOR_D + FACTOR_STATES
"""Estimate less that of the filter that receives it."""
VECTOR = DIFFERENCE + FACTOR_STATES
WORST = VECTOR + FACTOR_STATES
"""Largest normalised difference squared of each sub-filter from the master at the last fusion."""
G_SIZE = WORST + 2

# --- n ---
METHOD = 0
HAVE_SAMPLE = 1
SAMPLES = 2
REFUSED = 3
"""Samples that were no numbers."""
FALLBACKS = 4
"""How often an axis of the square root or differential method had no divisor."""
MODE = 5
"""Of the reset, see RESET_NAMES."""
STATUS = 6
"""Of the compass filter and the GPS filter: 0 trusted, 1 isolated."""
SCORE = 8
"""Refused measurements less accepted ones, not below 0."""
GOOD = 10
"""Accepted in a row."""
LAST = 12
"""Board time of the last measurement, ns."""
USED = 14
REFUSED_MEASUREMENTS = 16
ISOLATIONS = 18
RECOVERIES = 20
FUSIONS = 22
LIMIT_SCORE = 23
"""From which a filter is isolated; each of the two."""
LIMIT_GOOD = 25
"""After which it is trusted again."""
LIMIT_SILENCE = 27
"""ns without a measurement."""
REPEATS = 29
"""Times in a row that the compass said the same."""
LIMIT_REPEATS = 30
COMPASS_WORDS = 31
"""What it said (3)."""
ISOLATED_BY = 34
"""Why, each of the two: see CAUSE_NAMES."""
FUSION_DUE = 36
TICK = 37
"""Time of the last packet, ns."""
TICK_NS = 38
"""Its period."""
REFUSED_IN_A_ROW = 40
LIMIT_REFUSED = 42
"""In a row, of compass and GPS: then the global state may be the wrong one."""
REOPENED = 44
"""How often it was taken for that, each of the two."""
TICK_OFFSET = 46
"""ns that packets' times are behind; not 0 once the acquisition began anew."""
RESTARTS = 47
"""How often it did."""
RATE_IS_OWN = 48
"""1: the rate comes from the nine accelerometers, and its bias goes back into it at a fusion."""
FUSION_NS = 49
"""From one fusion to the next."""
N_SIZE = 50


INTEGRATION = 0
SQUARE_ROOT = 1
DIFFERENTIAL = 2
FUSION = 3
METHOD_NAMES = ("integration", "square_root", "differential", "fused")

COMPASS = 0
GPS = 1
TRUSTED = 0
ISOLATED = 1
NO_RESET = 0
FUSION_FEEDBACK = 1
ZERO_RESET = 2
PROPORTIONAL = 3
RESET_NAMES = ("no_reset", "fusion_feedback", "zero_reset", "proportional")
NO_CAUSE = 0
CONTRADICTED = 1
SILENT = 2
DIFFERENT = 3
BROKEN = 4
CAUSE_NAMES = ("none", "measurements refused", "silent", "differs from the others", "state not sound")
