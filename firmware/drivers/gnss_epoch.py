"""One GNSS epoch as the firmware passes it on: a flat int64 record, integers only.

The parser kernels write it, the navigation kernels read it, the link sends it. A field means something
only when the flag of its group is set; without its flag it is zero.

Frames and units: WGS-84, NED; degrees here are what the receiver prints, exact to its last digit
(1 nanodegree is 0.11 mm). Accuracies are one sigma; the horizontal one is the root of the sum of both axes.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FLAGS = 0
TIME_OF_DAY_MS = 1
"""UTC; 86 400 000 and more within a leap second."""
DATE_DAYS = 2
"""UTC date as days since 1980-01-06."""
LAT_NANODEG = 3
LON_NANODEG = 4
HEIGHT_MM = 5
"""Above the ellipsoid (HAS_HEIGHT)."""
HEIGHT_MSL_MM = 6
"""Above mean sea level (HAS_HEIGHT_MSL)."""
SPEED_MMPS = 7
"""Over ground."""
COURSE_E5DEG = 8
"""Over ground, from true north, 0 … 35 999 999 in units of 1e-5 degree."""
VEL_N_MMPS = 9
VEL_E_MMPS = 10
VEL_D_MMPS = 11
FIX_QUALITY = 12
"""As in GGA: 0 none, 1 autonomous, 2 differential, 4 RTK fixed, 5 RTK float, 6 dead reckoning."""
SATELLITES = 13
"""Used in the solution."""
HDOP_CENTI = 14
VDOP_CENTI = 15
H_ACC_MM = 16
V_ACC_MM = 17
S_ACC_MMPS = 18
"""0 when the receiver gives position accuracies only (PUBX,00 and GST)."""
LEAP_SECONDS = 19
"""GPS time − UTC as the receiver knows it; 0 while it has not said so."""
BURST_START_NS = 20
"""Board clock at the first bit of the burst that carried this epoch."""
BURST_END_NS = 21
"""Board clock at the last bit of the epoch's last message."""
VALID_NS = 22
"""Board clock at the time of validity; written by the application, not by the parser."""
PDOP_CENTI = 23
FIX_TYPE = 24
"""0 not told, 1 none, 2 two-dimensional (the height is held, not measured), 3 three-dimensional."""
HEADING_E5DEG = 25
"""True heading of a two-antenna receiver (HDT, THS, attitude sentences)."""
PITCH_E5DEG = 26
"""Nose up positive."""
ROLL_E5DEG = 27
"""Right side down positive."""
HEADING_SIGMA_E5DEG = 28
PITCH_SIGMA_E5DEG = 29
ROLL_SIGMA_E5DEG = 30
"""One sigma as the receiver claims it, each 0 when it does not (HAS_ATTITUDE_ACCURACY: it claims the
heading's)."""
BASELINE_MM = 31
"""Between the antennas, as this epoch measured it (HAS_BASELINE): a wrong length tells wrong ambiguities."""
RECORD_SIZE = 32
ONE_ANTENNA_SIZE = 26
"""What a receiver with one antenna can tell stands before this."""

HAS_TIME = 1
HAS_DATE = 2
HAS_POSITION = 4
"""Latitude and longitude of a valid fix; dead reckoning, manual and simulator modes are not valid."""
HAS_HEIGHT = 8
HAS_SPEED = 16
HAS_COURSE = 32
HAS_VELOCITY = 64
HAS_ACCURACY = 128
HAS_HEIGHT_MSL = 256
HAS_HEADING = 512
HAS_PITCH = 1024
HAS_ROLL = 2048
HAS_ATTITUDE_ACCURACY = 4096
HAS_BASELINE = 8192


def new_epoch() -> NDArray[np.int64]:
    """An empty record."""
    return np.zeros(RECORD_SIZE, np.int64)


FIELD_NAMES = (
    "flags", "time_of_day_ms", "date_days", "lat_nanodeg", "lon_nanodeg", "height_mm", "height_msl_mm",
    "speed_mmps", "course_e5deg", "vel_n_mmps", "vel_e_mmps", "vel_d_mmps", "fix_quality", "satellites",
    "hdop_centi", "vdop_centi", "h_acc_mm", "v_acc_mm", "s_acc_mmps", "leap_seconds", "burst_start_ns",
    "burst_end_ns", "valid_ns", "pdop_centi", "fix_type", "heading_e5deg", "pitch_e5deg", "roll_e5deg",
    "heading_sigma_e5deg", "pitch_sigma_e5deg", "roll_sigma_e5deg", "baseline_mm",
)  # fmt: skip
"""In the order of the record, for people and logs."""


def as_dict(epoch: NDArray[np.int64]) -> dict[str, Any]:
    """The record by field name."""
    return dict(zip(FIELD_NAMES, epoch.tolist(), strict=True))
