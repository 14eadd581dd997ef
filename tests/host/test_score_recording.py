"""Constants of a real recording: what its description says must come out of the fit."""

import os
from pathlib import Path

import numpy as np
import pymap3d
import pytest
from scipy.spatial.transform import Rotation, Slerp

from host.score.recording_fit import fit_shift_and_offset

FOLDER = os.environ.get("NAVTWIN_DATA")


@pytest.mark.recording
@pytest.mark.skipif(FOLDER is None, reason="needs NAVTWIN_DATA")
def test_time_shift_of_the_recorded_receiver():
    """GNSS against the reference is 1.47 m RMS at its own time, about 0.5 m after a time shift of 0.08 s."""
    drive = np.load(Path(FOLDER) / "comma2k19" / "example_1.npz")
    t, gnss = drive["gnss_t"], drive["gnss"]
    ecef = np.stack([np.interp(t, drive["pose_t"], column) for column in drive["pose_position_ecef"].T])
    v_ecef = np.stack([np.interp(t, drive["pose_t"], column) for column in drive["pose_velocity_ecef"].T])
    latitude, longitude, height = pymap3d.ecef2geodetic(*ecef)
    error = pymap3d.geodetic2ned(gnss[:, 0], gnss[:, 1], gnss[:, 4], latitude, longitude, height)
    velocity = np.stack(pymap3d.ecef2enuv(*v_ecef, latitude, longitude), axis=1)[:, [1, 0, 2]] * [1, 1, -1]
    q_eb = Slerp(drive["pose_t"], Rotation.from_quat(drive["pose_orientation_ecef"], scalar_first=True))(t)
    angles = np.stack((longitude, -(latitude + 90)), axis=1)
    C_e_n = Rotation.from_euler("ZY", angles, degrees=True)
    q_nb = (C_e_n.inv() * q_eb).as_quat(scalar_first=True)
    found = fit_shift_and_offset(np.stack(error, axis=1), velocity, q_nb)
    assert found["before_position_horizontal_rms_m"] == pytest.approx(1.47, abs=0.1)
    assert found["time_shift_s"] == pytest.approx(-0.08, abs=0.02)
    assert found["after_position_horizontal_rms_m"] < 0.6
