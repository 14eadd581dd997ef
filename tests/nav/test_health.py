"""What is wrong with the inputs or the state: told, survived, recovered from, never raised."""

import math

import numpy as np
import pytest
from nav_drive import NS, Drive, part, rows, without_samples
from nav_run import run

from firmware.nav import layout as at
from firmware.nav import solution as out
from firmware.nav.config import NavConfig, new_state
from firmware.nav.flags import DEGRADED, FLAG_NAMES, IMU_NOT_FINITE, LEVELLING, NAVIGATING
from firmware.nav.gnss import gnss_step
from firmware.nav.imu import imu_step

CONFIG = NavConfig(latency_sigma=0.0)


def test_bad_samples_one_by_one(town: Drive) -> None:
    """Three samples of NaN and one of infinity cost nothing."""
    drive = part(town, 0.0, 150.0)
    start = rows(drive, 120.0, 121.0).start
    drive.samples[start : start + 3] = math.nan
    drive.samples[start + 50, 2] = math.inf
    result = run(drive, CONFIG)
    assert result.i[at.EVENT_COUNT + IMU_NOT_FINITE] == 4
    assert np.any(result.seen("imu_not_finite"))
    after = result.t > 120.0
    assert np.max(result.horizontal[after]) < 3.0
    assert np.max(np.linalg.norm(result.velocity[after], axis=1)) < 0.3
    assert np.all(result.mode[after] == NAVIGATING)


@pytest.mark.parametrize("gap_s", [0.1, 0.3, 0.8, 1.5, 5.0])
def test_gap_is_bridged_by_velocity(town: Drive, gap_s: float) -> None:
    """Missing samples: the covariance grows, GNSS goes on, attitude is not spoilt by what nobody measured."""
    result = run(without_samples(part(town, 0.0, 160.0), 120.0, 120.0 + gap_s), CONFIG)
    assert np.any(result.seen("imu_gap"))
    assert result.horizontal[result.at(120.2 + gap_s)] < 2.0 + 2.5 * gap_s
    settled = result.t > 128.0 + gap_s
    assert np.max(result.horizontal[settled]) < 3.0
    assert np.max(np.linalg.norm(result.velocity[settled], axis=1)) < 0.3
    assert np.max(np.abs(np.degrees(result.attitude[settled]))) < 1.5


def test_covariance_grows_with_the_gap(town: Drive) -> None:
    """Without GNSS meanwhile, and honestly: the errors stay within four sigma."""
    sigmas = []
    for gap_s in (0.5, 1.0, 2.0):
        drive = without_samples(part(town, 0.0, 140.0), 120.0, 120.0 + gap_s)
        drive.epochs = [(t, e) for t, e in drive.epochs if not 119.5 * NS < t < 124.0 * NS]
        result = run(drive, CONFIG)
        k = result.at(120.2 + gap_s)
        sigmas.append(np.linalg.norm(result.sigma[k, 3:5]))
        assert np.linalg.norm(result.velocity[k, :2]) < 4.0 * sigmas[-1]
    assert sigmas[0] < sigmas[1] < sigmas[2]


def test_long_silence_aligns_again(town: Drive) -> None:
    """Half a minute without the sensor in motion: attitude is lost, alignment in motion brings it back."""
    result = run(without_samples(part(town, 0.0, 160.0), 90.0, 118.0), CONFIG)
    assert result.mode[result.at(119.0)] == LEVELLING
    assert result.mode[result.at(128.0)] == NAVIGATING
    assert np.max(result.horizontal[result.t > 135.0]) < 4.0


def test_stuck_sensor_in_motion_is_dead_time(town: Drive) -> None:
    """Readings that freeze for six seconds while the car accelerates."""
    drive = part(town, 0.0, 160.0)
    frozen = rows(drive, 120.0, 126.0)
    drive.samples[frozen] = drive.samples[frozen.start]
    result = run(drive, CONFIG)
    assert np.any(result.seen("imu_stuck"))
    assert result.mode[result.at(123.0)] == DEGRADED
    assert np.max(result.horizontal[(result.t > 120.0) & (result.t < 127.0)]) < 6.0
    assert np.max(result.horizontal[result.t > 135.0]) < 3.0


def test_sensor_without_noise_is_not_stuck(town: Drive) -> None:
    """Repetition at rest, before it ever moved, tells that this sensor has no noise: it is used."""
    drive = part(town, 0.0, 160.0)
    rest = rows(drive, 0.0, 72.0)
    drive.samples[rest] = np.mean(drive.samples[rest], axis=0)
    result = run(drive, CONFIG)
    assert result.mode[result.at(90.0)] == NAVIGATING
    assert np.max(result.horizontal[result.t > 100.0]) < 3.0


def test_saturation_is_refused(town: Drive) -> None:
    """Half a second at the rail."""
    drive = part(town, 0.0, 150.0)
    drive.samples[rows(drive, 120.0, 120.5), 3] = 160.0
    result = run(drive, CONFIG)
    assert np.any(result.seen("imu_saturated"))
    assert np.max(result.horizontal[result.t > 119.0]) < 4.0
    assert np.max(np.abs(np.degrees(result.attitude[result.t > 126.0]))) < 1.5


def test_dead_sensor_leaves_the_receiver(town: Drive) -> None:
    """No sample after 110 s: epochs alone carry the position on."""
    drive = part(town, 0.0, 125.0)
    f, i = new_state(CONFIG)
    samples = dict(zip(drive.times_ns.tolist(), drive.samples.tolist(), strict=True))
    epochs = iter(drive.epochs)
    arrival, record = next(epochs)
    last = 0
    for t in drive.times_ns.tolist():
        while arrival <= t:
            gnss_step(f, i, record)
            arrival, record = next(epochs, (1 << 62, record))
        if t < 110 * NS:
            imu_step(f, i, t, (t - last) * 1e-9, *samples[t])
            last = t
    floats, integers = np.zeros(out.SOLUTION_FLOATS, np.float32), np.zeros(out.SOLUTION_INTEGERS, np.int64)
    out.solution(f, i, floats, integers)
    k = round(integers[out.TIME_NS] / (NS // 10)) - 1
    north = (math.radians(integers[out.LAT_NANODEG] * 1e-9) - town.truth.latitude[k]) * 6.37e6
    assert integers[out.TIME_NS] > 122 * NS
    assert integers[out.MODE] != NAVIGATING
    assert abs(north) < 10.0


@pytest.fixture(scope="module")
def rolling(town: Drive):
    """A state in the middle of the drive, and what comes next."""
    drive = part(town, 0.0, 125.0)
    f, i = new_state(CONFIG)
    coming = list(drive.epochs)
    for t, sample in zip(drive.times_ns.tolist(), drive.samples.tolist(), strict=True):
        if t >= 100 * NS:
            break
        while coming[0][0] <= t:
            gnss_step(f, i, coming.pop(0)[1])
        imu_step(f, i, t, 0.01, *sample)
    after = drive.times_ns >= 100 * NS
    return f, i, drive.times_ns[after].tolist(), drive.samples[after].tolist(), coming, town.truth


SPOILT = sorted(
    {
        *range(0, at.U, 3),
        *range(at.U, at.CONFIG, 61),
        at.GRAVITY,
        at.WINDOW_TIME,
        at.SINCE_TIME,
        at.PARAMETER_TIME,
    }
)


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e30])
def test_spoilt_memory_is_found_and_navigation_recovers(rolling, value: float) -> None:
    """Any number of the state turned into NaN, infinity or nonsense: 25 s later all is well again."""
    f0, i0, times, samples, epochs, truth = rolling
    floats, integers = np.zeros(out.SOLUTION_FLOATS, np.float32), np.zeros(out.SOLUTION_INTEGERS, np.int64)
    restarted = 0
    for place in SPOILT:
        f, i, coming = f0.copy(), i0.copy(), list(epochs)
        f[place] = value
        for t, sample in zip(times, samples, strict=True):
            while coming and coming[0][0] <= t:
                gnss_step(f, i, coming.pop(0)[1])
            imu_step(f, i, t, 0.01, *sample)
        out.solution(f, i, floats, integers)
        k = round(times[-1] / (NS // 10)) - 1
        north = (math.radians(integers[out.LAT_NANODEG] * 1e-9) - truth.latitude[k]) * 6.37e6
        assert np.all(np.isfinite(floats)), place
        assert integers[out.MODE] == NAVIGATING, place
        assert abs(north) < 10.0, place
        restarted += int(i[at.EVENT_COUNT + FLAG_NAMES.index("numeric_restart")])
    assert restarted > 5


def test_time_never_goes_back(town: Drive) -> None:
    """A sample with an old or equal time is left out."""
    drive = part(town, 0.0, 150.0)
    k = rows(drive, 120.0, 120.1).start
    drive.times_ns[k + 1] = drive.times_ns[k]
    drive.times_ns[k + 5] = drive.times_ns[k] - 10 * NS
    result = run(drive, CONFIG)
    assert np.max(result.horizontal[result.t > 100.0]) < 3.0
    assert np.max(np.linalg.norm(result.velocity[result.t > 100.0], axis=1)) < 0.3


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"C_b_s": (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0)}, "no rotation matrix"),
        ({"sample_period": 0.0}, "sample_period = 0.0 must be finite and positive"),
        ({"latency_sigma": -0.01}, "latency_sigma = -0.01 must be finite and not negative"),
        ({"velocity_noise": math.nan}, "velocity_noise = nan"),
        ({"antenna_lever_arm": (1.0, math.inf, 0.0)}, "antenna_lever_arm"),
        ({"antenna_lever_arm": (1.0, 2.0)}, "must have three values"),
    ],
)
def test_configuration_is_checked(changes: dict, told: str) -> None:
    """One message with the field and its value."""
    with pytest.raises(ValueError, match=told):
        new_state(NavConfig(**changes))
