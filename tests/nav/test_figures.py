"""The figures that are asked for, offline: one drive at once, ten seeds as soak."""

import dataclasses
import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from nav_drive import Drive, make_drive
from nav_run import Figures, figures, rms, run

from firmware.nav.config import NavConfig

CONFIG = NavConfig(latency_sigma=0.0)
THESIS = {"sample_period": 0.1, "two_sample": False}
UNAIDED = {"constraint": False, "standstill": False}
SEEDS = range(1, 11)
needs_recording = pytest.mark.skipif(not os.environ.get("NAVTWIN_DATA"), reason="NAVTWIN_DATA is not set")


@cache
def drive(scenario: str, seed: int, thesis: bool = False) -> Drive:
    """One run of the world."""
    return make_drive(scenario, seed, thesis=thesis)


def of_seeds(scenario: str, config: NavConfig, thesis: bool = False) -> list[Figures]:
    """Figures of ten seeds."""
    return [figures(run(d, config), d) for d in (drive(scenario, seed, thesis) for seed in SEEDS)]


def mean(results: list[Figures], name: str) -> float:
    """Over the seeds."""
    return float(np.mean([getattr(r, name) for r in results]))


def test_town_open() -> None:
    """Twenty minutes: better than the receiver, and honest."""
    d = drive("town-open", 1)
    told = figures(run(d, CONFIG), d)
    assert told.horizontal_m < told.gnss_horizontal_m
    assert told.velocity_mps < 0.05
    assert max(told.roll_deg, told.pitch_deg) < 0.3
    assert told.yaw_deg < 0.5
    assert 4.5 < told.nees < 18.0


@pytest.mark.soak
def test_town_open_ten_seeds() -> None:
    results = of_seeds("town-open", CONFIG)
    for told in results:
        assert told.horizontal_m < told.gnss_horizontal_m
        assert told.velocity_mps < 0.05
        # one specimen of ten has a misalignment of 0.76°, 3.8 σ: nothing tells it from a tilt of the sensor
        assert max(told.roll_deg, told.pitch_deg) < 0.6
        assert told.yaw_deg < 0.5
    assert sorted(max(told.roll_deg, told.pitch_deg) for told in results)[-2] < 0.4
    assert 4.5 < mean(results, "nees") < 18.0


@pytest.mark.soak
def test_outages_ten_seeds() -> None:
    """40 outages of 60 s: what vehicle aiding brings. The limit without is held on the board: tests/soak."""
    aided = [d for told in of_seeds("outages", CONFIG) for d in told.drifts_m]
    free = [d for told in of_seeds("outages", dataclasses.replace(CONFIG, **UNAIDED)) for d in told.drifts_m]
    assert len(aided) == 40
    assert np.median(aided) < 4.0
    assert np.median(aided) < np.median(free) / 3.0


@pytest.mark.soak
def test_full_rate_beats_thesis_on_a_rough_road() -> None:
    """Paired over ten seeds; the 95 % interval of the mean difference lies on one side."""
    full = of_seeds("rough", CONFIG)
    thesis = of_seeds("rough", dataclasses.replace(CONFIG, **THESIS), thesis=True)
    for name in ("velocity_mps", "yaw_deg", "horizontal_m"):
        difference = np.array(
            [getattr(b, name) - getattr(a, name) for a, b in zip(full, thesis, strict=True)]
        )
        half_width = 2.26 * difference.std(ddof=1) / np.sqrt(len(difference))
        assert difference.mean() - half_width > 0.0, name


@needs_recording
@pytest.mark.recording
def test_real_drive_is_no_worse_than_its_receiver() -> None:
    """A real car that is never at rest, 0.07 rad/s of gyro bias, the device pitched by −4°."""
    d = make_drive("real-drive", gnss_rate=5.0, burst_s=0.06, data_dir=Path(os.environ["NAVTWIN_DATA"]))
    result = run(d, CONFIG)
    aligned = result.t[np.argmax(result.mode >= 3)]
    assert aligned < 5.0
    after = result.t > aligned + 10.0
    fixes = d.fixes[d.fixes[:, 0] > aligned + 10.0]
    assert rms(result.position[after, :2]) <= rms(fixes[:, 1:3])
    assert rms(result.velocity[after]) < 0.15
    assert abs(np.degrees(result.biases[-1, 7]) - 4.3) < 0.5


@needs_recording
@pytest.mark.recording
def test_real_drive_with_cuts() -> None:
    """Four cuts of ten seconds: at most 5 m at their end."""
    d = make_drive("real-drive-cuts", gnss_rate=5.0, burst_s=0.06, data_dir=Path(os.environ["NAVTWIN_DATA"]))
    result = run(d, CONFIG)
    drifts = [result.horizontal[result.at(end)] for _, end in d.outages]
    assert len(drifts) == 4
    assert max(drifts) < 5.0
