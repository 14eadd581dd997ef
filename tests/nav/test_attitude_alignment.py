"""Static coarse alignment: attitude, yaw by field or given, gyro nulling, and what it refuses."""

import numpy as np
import pytest
from attitude_rig import DEG, EVERY_PROFILE, LATITUDE, Ride, angle_between_deg, at_rest, bursts

from firmware.nav.attitude import flags as fl
from firmware.nav.attitude import layout as at
from firmware.nav.attitude.config import AttitudeConfig, quaternion

ATTITUDES = [(0.0, 0.0, 0.0), (2.0, 0.3, -0.5), (6.2, -1.2, 3.0), (3.2, 1.4, -3.1), (4.0, 0.0, 1.5708)]
COUNT = 50


def config(**settings):
    return AttitudeConfig(latitude=LATITUDE, alignment_time=COUNT * 0.004, **settings)


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("angles", ATTITUDES)
@pytest.mark.parametrize("declination", [0.0, 4.0 * DEG, -17.0 * DEG])
def test_attitude_of_a_rest(profile, angles, declination):
    """The field points to the magnetic north, `declination` east of the true one."""
    ride = Ride(profile, config(declination=declination)).drive(at_rest(angles, COUNT, declination))
    assert ride.i[at.MODE] == fl.RUNNING
    bound = 2e-4 if profile == "float32" else 1e-5
    assert angle_between_deg(ride.quaternion(), np.array(quaternion(angles))) < bound


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_attitude_from_words_is_as_good_as_their_counts(profile):
    """Half of 3.333 mg is 0.1° of tilt, half of 0.5 mgauss 0.07° of yaw; tilt turns the field too."""
    angles = (2.0, 0.3, -0.5)
    ride = Ride(profile, config()).drive_words(bursts(at_rest(angles, COUNT)))
    assert angle_between_deg(ride.quaternion(), np.array(quaternion(angles))) < 0.1 + 0.07 + 2.05 * 0.1


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_given_yaw_is_taken_when_the_magnetometer_is_not_wanted(profile):
    one = Ride(profile, config(magnetometer=False, yaw=1.25)).drive(at_rest((0.7, 0.1, 0.2), COUNT))
    assert angle_between_deg(one.quaternion(), np.array(quaternion((1.25, 0.1, 0.2)))) < 2e-4
    assert one.i[at.NOTICES + 11] == 0


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("strength", [0.0, 0.05, 40.0])
def test_missing_or_disturbed_magnetometer_falls_back_to_the_given_yaw(profile, strength):
    samples = at_rest((0.7, 0.1, 0.2), COUNT)
    samples[:, 6:9] *= strength
    one = Ride(profile, config(yaw=1.25)).drive(samples)
    assert angle_between_deg(one.quaternion(), np.array(quaternion((1.25, 0.1, 0.2)))) < 2e-4
    assert one.record()[at.OUT_FLAGS] & fl.YAW_GIVEN


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_field_that_is_bad_for_a_while_is_left_out(profile):
    samples = at_rest((0.7, 0.1, 0.2), COUNT)
    samples[10:30, 6:9] = (0.0, 9e-4, 0.0)
    one = Ride(profile, config(yaw=1.25)).drive(samples)
    assert angle_between_deg(one.quaternion(), np.array(quaternion((0.7, 0.1, 0.2)))) < 2e-4


@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("part", [0, 5])
def test_motion_begins_the_alignment_anew(profile, part):
    """A turn of 20 °/s or a push of 8 m/s² at the 40th sample: it takes 50 more from there."""
    samples = at_rest((0.7, 0.1, 0.2), 2 * COUNT)
    samples[39, part] += 20.0 * DEG if part < 3 else 8.0
    one = Ride(profile, config())
    one.drive(samples[: 39 + COUNT])
    assert one.i[at.MODE] == fl.ALIGNING
    assert one.record()[at.OUT_FLAGS] & fl.MOVED
    one.drive(samples[39 + COUNT : 40 + COUNT])
    assert one.i[at.MODE] == fl.RUNNING
    assert angle_between_deg(one.quaternion(), np.array(quaternion((0.7, 0.1, 0.2)))) < 2e-4


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_bridged_samples_do_not_count(profile):
    bad = np.full((20, 14), 0xFFFF, np.int64)
    good = bursts(at_rest((0.7, 0.1, 0.2), COUNT - 1))
    one = Ride(profile, config()).drive_words(np.concatenate((good, bad)))
    assert one.i[at.MODE] == fl.ALIGNING
    one.drive_words(good[:1])
    assert one.i[at.MODE] == fl.RUNNING


@pytest.mark.parametrize("profile", EVERY_PROFILE)
def test_nulled_gyros_know_the_rate_of_the_earth(profile):
    bias = np.array([0.5, -2.0, 0.01]) * DEG
    samples = at_rest((0.7, 0.1, 0.2), COUNT)
    samples[:, 0:3] += bias
    one = Ride(profile, config(null_gyros=True)).drive(samples)
    found = one.record()[at.OUT_GYRO_BIAS : at.OUT_GYRO_BIAS + 3] * 1e-9
    assert found == pytest.approx(bias, abs=2e-8)
    samples = at_rest((0.7, 0.1, 0.2), 5000)
    samples[:, 0:3] += bias
    one.drive(samples)
    assert angle_between_deg(one.quaternion(), np.array(quaternion((0.7, 0.1, 0.2)))) < 1e-3


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("latitude", 2.0, "latitude is 2.0; possible: -1.5708 rad to 1.5708 rad"),
        ("method", "rk5", "method is 'rk5'; possible: rk4"),
        ("period", 0.1, "period is 0.1; possible: 0.0005 s to 0.02 s"),
        ("velocity", (0.0, 600.0, 0.0), "velocity[1] is 600.0"),
        ("gyro_range_dps", 250, "gyro_range_dps is 250; possible: 75, 150, 300"),
        ("C_b_s", (1.0, 2.0, 3.0), "9 numbers, row by row, of a rotation"),
        ("yaw", float("nan"), "yaw is nan"),
        ("gyro_bias", (0.0, 0.0, 2.0), "gyro_bias[2] is 2.0; possible: -1 rad/s to 1 rad/s"),
        ("rest_rate", -1.0, "rest_rate is -1.0; possible: 0 rad/s to 15 rad/s"),
        ("most_field", float("inf"), "most_field is inf; possible: 0 T to 0.0009 T"),
    ],
)
def test_impossible_configuration_is_told(name, value, text):
    with pytest.raises(ValueError, match="is") as caught:
        AttitudeConfig(**{name: value})
    assert text in str(caught.value)
