"""The attitude computer's kernels fed directly: exact rates and forces, no chip and no bus."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig
from firmware.nav.attitude.profiles import load_loop

Array = NDArray[np.float64]
NANO = 1e-9


@dataclass(frozen=True, slots=True)
class Computed:
    """What an arithmetic made of the samples: one row an iteration."""

    angles: Array
    """(n, 3) pitch, roll, yaw in rad."""
    q_nb: Array
    """(n, 4)."""
    saturations: int


def compute(profile: str, config: AttitudeConfig, samples: Array) -> Computed:
    """Iterations over `samples` (2 n + 1, 9: ω, f, m in SI and body axes), the first one at the beginning.

    `config` must give the attitude to begin with.
    """
    loop = load_loop(profile)
    s, i, out = loop.new_state(config)
    records = np.empty((len(samples) // 2, at.OUT_SIZE), np.int64)
    fed = loop.samples(samples)
    loop.take_rates(s, i, fed[0])
    for place in range(len(records)):
        loop.take_rates(s, i, fed[2 * place + 1])
        loop.take_rates(s, i, fed[2 * place + 2])
        loop.iterate(s, i)
        loop.solution(s, i, out)
        records[place] = out
    wanted = [at.OUT_PITCH, at.OUT_ROLL, at.OUT_YAW]
    quaternion = records[:, at.OUT_QUATERNION : at.OUT_QUATERNION + 4]
    angles = np.asarray(records[:, wanted] * NANO, np.float64)
    return Computed(angles, np.asarray(quaternion * NANO, np.float64), int(records[-1, at.OUT_SATURATIONS]))


def level_at(latitude: float, height: float, method: str) -> AttitudeConfig:
    """Level and heading north at a place, without alignment."""
    return AttitudeConfig(latitude=latitude, height=height, method=method, attitude=(0.0, 0.0, 0.0))
