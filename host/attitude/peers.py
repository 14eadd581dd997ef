"""Filters of others, from PyPI: vqf (D. Laidig) and imufusion (x-io), each with its own usual settings."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

import numpy as np

from host.attitude.estimates import Estimate
from host.attitude.recording import AttitudeRecording
from host.attitude.scoring import product

PEERS: Final = ("vqf", "imufusion")
STANDARD_GRAVITY = 9.80665
IMUFUSION = {
    "gain": 0.5,
    "acceleration_rejection": 10.0,
    "magnetic_rejection": 10.0,
    "rejection_timeout": 60.0,
}
"""Gain and rejections of its authors' examples. Of time-outs from 1 to 300 s this serves it best here: 5 s
give four times the error."""
NORTH_WEST_UP = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
"""Turned into east-north-up."""


def is_installed(peer: str) -> bool:
    """Whether a peer can be asked."""
    return find_spec(peer) is not None


def by_peer(peer: str, recording: AttitudeRecording) -> Estimate:
    """One of PEERS on the recording's samples as they are; ValueError for another name."""
    if peer == "vqf":
        return _by_vqf(recording)
    if peer == "imufusion":
        return _by_imufusion(recording)
    raise ValueError(f"{peer!r} is none of {', '.join(PEERS)}")


def _by_vqf(recording: AttitudeRecording) -> Estimate:
    from vqf import VQF

    gyro, force, field = (
        np.ascontiguousarray(values) for values in (recording.omega, recording.force, recording.field)
    )
    result = VQF(recording.interval).updateBatch(gyro, force, field)
    return Estimate(np.asarray(result["quat9D"], np.float64), samples=len(recording))


def _by_imufusion(recording: AttitudeRecording) -> Estimate:
    import imufusion

    rate = recording.rate_hz
    settings = imufusion.AhrsSettings(sample_rate=rate, convention=imufusion.CONVENTION_NWU, **IMUFUSION)
    ahrs = imufusion.Ahrs().set_settings(settings)
    bias = imufusion.Bias().set_settings(imufusion.BiasSettings(sample_rate=rate))
    rates, forces = np.degrees(recording.omega), recording.force / STANDARD_GRAVITY
    quaternions = np.empty((len(recording), 4))
    for row in range(len(recording)):
        ahrs.update(bias.update(rates[row]), forces[row], recording.field[row])
        quaternions[row] = ahrs.get_quaternion()
    return Estimate(product(NORTH_WEST_UP, quaternions), samples=len(recording))
