"""Drift over outages of a minute: `navtwin evaluate` with what it does unasked."""

from __future__ import annotations

from collections.abc import Iterator

from host.sim.scenario.load import load_scenario
from host.simulate.drift import Plan
from host.simulate.drives import DRIVES
from host.simulate.outage_page import PUBLISHED
from host.simulate.outage_test import drift_of
from host.simulate.proof.figure import Figure

SCENARIO = DRIVES / "long-legs.toml"
SEEDS = range(1, 6)


def figures() -> Iterator[Figure]:
    """Each grade, and the warm one that is only told."""
    scenario = load_scenario(SCENARIO)
    for preset, known in PUBLISHED.items():
        drift = drift_of(scenario, Plan(), preset, SEEDS, None)
        low, high = known.band or (None, None)
        simulated = "" if known.simulated is None else " / ".join(f"{one:.2f}" for one in known.simulated)
        document = f"{simulated}, real {known.real:.2f}".lstrip(", ")
        words = f"{preset}: horizontal RMS after 60 s, {len(SEEDS)} drives"
        yield Figure("drift", words, "m", drift.horizontal_rms_m(), document, low, high)
