"""`navtwin proof`: figures beside the document's; the fast parts, and that a wrong simulator is found out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from host.cli.main import app
from host.sim.trajectory.motion import Motion
from host.simulate.proof.figure import Figure
from host.simulate.proof.noise import inside_share


def proof(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["proof", *[str(one) for one in arguments]])


def figures(*arguments: object) -> tuple[int, dict[str, Any]]:
    result = proof(*arguments, "--json", "-", "-q")
    assert result.exit_code in (0, 1), result.output
    told = json.loads(result.stdout)
    return result.exit_code, {one["what"]: one for one in told["figures"]}


def test_truth_on_paper_and_joints(tmp_path: Path) -> None:
    code, found = figures("closed-forms", "joints")
    assert code == 0
    assert len(found) == 7
    assert all(one["met"] for one in found.values())
    shown = proof("joints", "--json", tmp_path / "f.json")
    assert "3 of 3 figures met" in shown.output
    assert json.loads((tmp_path / "f.json").read_text())["format"] == "navtwin-proof-1"


def test_truth_that_is_off_by_a_millionth_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = Motion.rows

    def wrong(self: Motion, times_ns: Any) -> Any:
        found = rows(self, times_ns)
        found[:, 15:21] *= 1.000001
        return found

    monkeypatch.setattr(Motion, "rows", wrong)
    code, found = figures("closed-forms")
    assert code == 1
    assert not any(one["met"] for one in found.values())


def test_share_of_runs_inside_their_interval() -> None:
    """Of Gauss–Markov runs 95 %; of runs with a tenth more σ hardly any."""
    random = np.random.default_rng(4)
    keep = np.exp(-10.0 / 3600.0)
    runs = np.empty((200, 16_200))
    runs[:, 0] = random.standard_normal(200)
    for k in range(1, runs.shape[1]):
        runs[:, k] = keep * runs[:, k - 1] + np.sqrt(1 - keep**2) * random.standard_normal(200)
    assert inside_share(2.0 * runs, 2.0, 3600.0) == pytest.approx(0.95, abs=0.04)
    assert inside_share(2.4 * runs, 2.0, 3600.0) < 0.1


def test_verdicts() -> None:
    assert Figure("p", "w", "m", 1.0).met is None
    assert Figure("p", "w", "m", 1.0, most=1.0).met is True
    assert Figure("p", "w", "m", 1.1, most=1.0).met is False
    assert Figure("p", "w", "m", 0.9, least=1.0).met is False
    assert Figure("p", "w", "m", float("nan"), most=1.0).met is False


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("clsure",), "did you mean 'closure'"),
        (("joints", "--json", "no/such/x.json"), "does not exist"),
    ],
)
def test_mistakes_are_told(arguments: tuple[str, ...], words: str) -> None:
    result = proof(*arguments)
    assert result.exit_code == 2, result.output
    assert words in result.stderr


def test_without_recordings_the_part_that_needs_them_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NAVTWIN_DATA", raising=False)
    result = proof("bmi160")
    assert result.exit_code == 2
    assert "NAVTWIN_DATA=~/recordings" in result.stderr


@pytest.mark.soak
@pytest.mark.filterwarnings("ignore:The copy keyword is deprecated")
@pytest.mark.parametrize("part", ["closure", "independent", "noise", "drift"])
def test_every_part_is_met(part: str) -> None:
    code, found = figures(part)
    assert [what for what, one in found.items() if one["met"] is False] == []
    assert code == 0
