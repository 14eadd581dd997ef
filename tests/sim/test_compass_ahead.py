"""A compass that foresees its samples feels what it would have felt without."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from host.sim.compass import FeltCompass
from host.sim.compass_ahead import CompassAhead
from host.sim.scenario.load import load_scenario
from host.sim.world import World

SCENARIOS = Path(__file__).parents[2] / "boards" / "gfsins" / "scenarios"
STEP_NS = 99_960_016


def compass(scenario: str, *, ahead: bool) -> FeltCompass | CompassAhead:
    world = World(load_scenario(SCENARIOS / f"{scenario}.toml"), seed=3)
    made = world.compass("U8")
    assert isinstance(made, CompassAhead)
    return made if ahead else made.compass


@pytest.mark.parametrize("scenario", ["chapter5", "static"])
def test_foreseen_or_not_the_same_is_felt(scenario: str) -> None:
    asked = compass(scenario, ahead=True)
    plain = compass(scenario, ahead=False)
    assert isinstance(asked, CompassAhead)
    times = np.cumsum(np.full(60, STEP_NS))
    asked.foresee(times[:20])
    got = [asked.sample(times[k : k + 1])[0] for k in range(12)]
    got += list(asked.sample(times[12:15]))  # several at once
    asked.foresee(times[15:35])
    got += [asked.sample(times[15:16])[0]]
    asked.foresee(times[17:40])  # before the last were asked for, and one is left out
    got += [asked.sample(times[k : k + 1])[0] for k in range(17, 20)]
    asked.forget()
    got += [asked.sample(times[k : k + 1])[0] for k in range(20, 22)]
    wanted = [plain.sample(times[k : k + 1])[0] for k in range(22) if k != 16]
    assert np.allclose(got, wanted, rtol=1e-12, atol=0.0)
    assert len(np.unique(np.array(got)[:, 0])) == len(got)
