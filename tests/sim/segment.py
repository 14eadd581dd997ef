"""A segment of motion for tests: given rates, nothing read from a file."""

from dataclasses import dataclass, field

import numpy as np

from host.sim.trajectory.motion import Motion
from host.sim.trajectory.segments import MotionState, SegmentRates

WUHAN = (0.5328, 1.9959, 30.0)
SECOND = 1_000_000_000


@dataclass
class Plain:
    """A segment with fixed rates."""

    duration_s: float
    what: SegmentRates = field(default_factory=SegmentRates)

    def rates(self, speed, blend_s):
        return self.what


def motion(segments=(), state=None, origin=WUHAN, disturbance=None):
    return Motion(list(segments) or [Plain(1.0)], state or MotionState(), origin, 0.5, disturbance)


def row(m, seconds):
    """The row of truth at one time."""
    return m.rows(np.array([round(seconds * SECOND)]))[0]


def c_nb(r):
    return r[6:15].reshape(3, 3)
