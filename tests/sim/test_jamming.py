"""Jamming and spoofing: what a receiver with weak or false signals reports."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from boards.chips.world import GnssEpoch
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import scenario_from
from host.sim.world import World

SECOND = 1_000_000_000
METRES_PER_RAD = 6.36e6


def world(kind: str, seed: int = 1, **parameters: float) -> World:
    fault = {
        "kind": kind,
        "target": "U3",
        "at_s": 10.0,
        "duration_s": 400.0,
        "parameters": parameters,
        "name": "f",
    }
    data = {
        "duration_s": 420.0,
        "place": {"latitude_deg": 47.0, "longitude_deg": 8.0, "height_m": 400.0},
        "gnss": {"position_markov_m": 0.0},
        "fault": [fault],
    }
    return World(scenario_from(data, "t", "t.toml"), seed)


def epochs(here: World) -> list[GnssEpoch]:
    receiver = here.gnss("U3")
    return [receiver.epoch(k * SECOND) for k in range(420)]


def test_spoofing_pulls_position_and_velocity_away_alike() -> None:
    plain = epochs(world("gnss-position-jump", north_m=1e-9))
    pulled = epochs(world("gnss-spoofing", north_mps=2.0, down_mps=-1.0))
    for k, (good, bad) in enumerate(zip(plain, pulled, strict=True)):
        struck = 10 <= k < 410
        north = (bad.latitude - good.latitude) * METRES_PER_RAD
        assert north == pytest.approx(2.0 * (k - 10) if struck else 0.0, rel=0.01, abs=1e-6)
        assert bad.height - good.height == pytest.approx(k - 10.0 if struck else 0.0, abs=1e-6)
        off = np.subtract(bad.velocity_ned, good.velocity_ned)
        np.testing.assert_allclose(off, (2.0, 0.0, -1.0) if struck else 0.0, atol=1e-12)


def test_weak_signals_make_the_errors_as_large_as_claimed() -> None:
    plain, jammed = (
        epochs(world("gnss-position-jump", north_m=1e-9)),
        epochs(world("gnss-jamming", loss_db=8)),
    )
    for good, bad in zip(plain[10:410], jammed[10:410], strict=True):
        for before, now in zip(good.satellites, bad.satellites, strict=True):
            left = before.cn0_dbhz - 8.0
            assert now.cn0_dbhz == pytest.approx(left if left >= 20.0 else 0.0)
            assert now.used == (before.used and left >= 25.0)
        assert bad.fix
        assert bad.hdop >= good.hdop
        assert bad.h_acc >= good.h_acc * 10 ** (8 / 20) * 0.999
    truth = math.radians(47.0)
    scaled = [(e.latitude - truth) * METRES_PER_RAD / (e.h_acc / math.sqrt(2.0)) for e in jammed[10:410]]
    assert np.std(scaled) == pytest.approx(1.0, abs=0.12)  # 3.4 σ of 400 draws
    speeds = [v / (e.s_acc / math.sqrt(3.0)) for e in jammed[10:410] for v in e.velocity_ned]
    assert np.std(speeds) == pytest.approx(1.0, abs=0.07)
    assert jammed[:10] == plain[:10]
    assert jammed[5].satellites == plain[5].satellites


def test_strong_jamming_leaves_no_fix_and_the_sky_comes_back() -> None:
    jammed = epochs(world("gnss-jamming", loss_db=40))
    assert [e.fix for e in jammed] == [not 10 <= k < 410 for k in range(420)]
    assert all(s.cn0_dbhz == 0.0 and not s.used for s in jammed[50].satellites)
    assert any(s.used for s in jammed[415].satellites)


def test_jamming_is_the_seeds_and_is_counted() -> None:
    first, again = epochs(world("gnss-jamming", loss_db=6)), epochs(world("gnss-jamming", loss_db=6))
    assert first == again
    here = world("gnss-jamming", seed=2, loss_db=6)
    receiver: Any = here.gnss("U3")
    assert receiver.epoch(20 * SECOND).latitude != first[20].latitude
    assert [glitch.fired for glitch in receiver.glitches] == [1]


@pytest.mark.parametrize(
    ("kind", "parameters", "words"),
    [
        ("gnss-jamming", {}, "loss_db = 12.0"),
        ("gnss-jamming", {"loss_db": -3.0}, "loss_db = -3 must lie above 0"),
        ("gnss-jamming", {"loss_db": 1e300}, "outside -100 … 100"),
        ("gnss-jamming", {"power": 3.0}, "parameters.power"),
        ("gnss-spoofing", {}, "north_mps = 1.0"),
        ("gnss-spoofing", {"north_m": 1.0}, "parameters.north_m"),
    ],
)
def test_mistakes_are_told(kind: str, parameters: dict[str, float], words: str) -> None:
    with pytest.raises(ScenarioError) as told:
        world(kind, 1, **parameters).gnss("U3")
    assert words in str(told.value)
