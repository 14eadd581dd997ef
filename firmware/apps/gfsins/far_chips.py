"""Which of seven accelerometers on one rigid body is far from the others.

All sit alike, so all feel the same force but for what turning makes at the end of an arm (ω² l: 0.06 g at
90°/s, 0.25 m). A chip of which the running mean of an axis is further from the median of all than offsets and
sensitivities allow is turned, or has run away.
"""

from __future__ import annotations

import numpy as np

from firmware.apps.gfsins.accelerations import CHIPS
from firmware.apps.gfsins.agreement_step import SIZE, chips_far_off
from firmware.numerics.dialect import entry_point
