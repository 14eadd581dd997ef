"""Where each quantity of the gyro-free sensor lies in its two flat arrays, `g` (float32) and `n` (int64).

The filters have the arrays of the navigation core (`firmware.nav.layout`), one pair each. Axes b: front,
right, down. Matrices row by row. Nothing is allocated in flight; a copy of both arrays is a complete snapshot.
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
G_SIZE = 124

# --- n ---
METHOD = 0
HAVE_SAMPLE = 1
SAMPLES = 2
REFUSED = 3
"""Samples that were no numbers."""
FALLBACKS = 4
"""How often an axis of the square root or differential method had no divisor."""
N_SIZE = 8

INTEGRATION = 0
SQUARE_ROOT = 1
DIFFERENTIAL = 2
FUSION = 3
METHOD_NAMES = ("integration", "square_root", "differential", "fused")
