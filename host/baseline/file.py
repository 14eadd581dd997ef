"""The baseline file: JSON, a run a line, so that a change of it is read in a merge request.

{"format": "navtwin-baseline-1", "board": …, "scenario": …, "scenario_digest": …, "overrides": [],
 "runs": [{"profile": "full-rate", "set": {}, "seed": 1, "figures": {"yaw_rms_deg": 0.14, …}}, …]}
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from host.baseline.gated import DID_NOT_FINISH, gated
from host.campaign.row import FINISHED
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.record.result import BusUse, CpuUse, FaultUse, RunResult
from host.score.expectations import flat_figures

BASELINE_FORMAT = "navtwin-baseline-1"
SetupKey = tuple[str, tuple[tuple[str, str], ...]]
"""Profile and swept values, these by the names of their keys."""


@dataclass(frozen=True)
class BaselineRun:
    """The figures of one run."""

    profile: str
    swept: tuple[tuple[str, str], ...]
    seed: int
    figures: Mapping[str, float | None]

    @property
    def setup(self) -> SetupKey:
        """All but the seed; keys of `--set` in any order are the same set-up."""
        return self.profile, tuple(sorted(self.swept))


@dataclass(frozen=True)
class Baseline:
    """Figures to hold others against."""

    path: Path
    board: str
    scenario: str
    scenario_digest: str
    overrides: tuple[str, ...]
    runs: tuple[BaselineRun, ...]


def parse_tolerance(text: str) -> float:
    """`5%` or `0.05`. Raises UserError."""
    try:
        tolerance = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        tolerance = -1.0
    if not 0 <= tolerance <= 10:
        raise UserError(f"--tolerance {text}: must lie in 0 … 1000 %; for example --tolerance 5%")
    return tolerance


def read_baseline(path: Path) -> Baseline:
    """Raises UserError when it cannot be read or is of another version."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"), parse_constant=_refused)
    except FileNotFoundError:
        raise UserError(
            f"--baseline {path}: no such file; make it: navtwin baseline update {path} runs/FOLDER"
        ) from None
    except OSError as error:
        raise UserError(f"--baseline {path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise UserError(f"--baseline {path}: is not valid JSON ({error})") from None
    form = found.get("format") if isinstance(found, dict) else None
    if form != BASELINE_FORMAT:
        raise UserError(
            f"--baseline {path}: is of format {form!r}, this navtwin reads {BASELINE_FORMAT!r};"
            f" make it anew: navtwin baseline update {path} runs/FOLDER"
        )
    try:
        runs = tuple(_run_of_line(one) for one in found["runs"])
        board, scenario, digest = (_text(found, name) for name in ("board", "scenario", "scenario_digest"))
        overrides = tuple(str(change) for change in found["overrides"])
        keys = [(one.setup, one.seed) for one in runs]
        if len(set(keys)) != len(keys):
            raise ValueError("the same run stands in it twice")
        return Baseline(path, board, scenario, digest, overrides, runs)
    except KeyError as error:
        raise UserError(f"--baseline {path}: is not complete ({error} is missing); make it anew") from None
    except (ValueError, TypeError, AttributeError) as error:
        raise UserError(f"--baseline {path}: cannot be used ({error}); make it anew") from None


def _run_of_line(line: Mapping[str, Any]) -> BaselineRun:
    """One run of the file. KeyError, ValueError, TypeError, AttributeError: it is none."""
    seed, swept = line["seed"], line["set"]
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise ValueError(f"seed = {seed!r} must be a whole number")
    run = BaselineRun(
        _text(line, "profile"),
        tuple((key, str(value)) for key, value in swept.items()),
        seed,
        line["figures"],
    )
    for name, value in run.figures.items():
        if value is not None and not _is_figure(value):
            raise ValueError(f"seed {seed}: {name} = {value!r} must be a number or null")
    if run.figures[DID_NOT_FINISH] not in (0, 1):
        raise ValueError(f"seed {seed}: {DID_NOT_FINISH} must be 0 or 1")
    return run


def _is_figure(value: Any) -> bool:
    """A number that floating point holds."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _text(table: Mapping[str, Any], key: str) -> str:
    if not isinstance(table[key], str):
        raise ValueError(f"{key} = {table[key]!r} must be a text")
    return str(table[key])


def _refused(constant: str) -> float:
    raise ValueError(f"{constant} is no number of JSON")


def write_baseline(path: Path, manifest: Mapping[str, Any], runs: Sequence[BaselineRun]) -> None:
    """Raises UserError when the file cannot be written."""
    head = {
        "format": BASELINE_FORMAT,
        "board": manifest["board"],
        "scenario": manifest["scenario"],
        "scenario_digest": scenario_digest(manifest),
        "overrides": list(manifest["overrides"]),
        "versions": manifest["versions"],
    }
    lines = [
        json.dumps(
            {"profile": one.profile, "set": dict(one.swept), "seed": one.seed, "figures": dict(one.figures)}
        )
        for one in runs
    ]
    text = json.dumps(head, indent=1)[:-2] + ',\n "runs": [\n  ' + ",\n  ".join(lines) + "\n ]\n}\n"
    write_whole(path, text)


def scenario_digest(manifest: Mapping[str, Any]) -> str:
    """Of the scenario's text, with what it inherits."""
    return hashlib.sha256(str(manifest["scenario_text"]).encode()).hexdigest()[:16]


def campaign_runs(rows: Sequence[Mapping[str, Any]], manifest: Mapping[str, Any]) -> list[BaselineRun]:
    """The rows of a campaign's result as runs of a baseline."""
    swept = manifest["swept"]
    runs = []
    for row in rows:
        values = tuple((key, str(row[f"set.{key}"])) for key in swept)
        done = row["status"] == FINISHED
        figures = gated(row) if done else {}
        runs.append(
            BaselineRun(row["profile"], values, row["seed"], {**figures, DID_NOT_FINISH: float(not done)})
        )
    return runs


def run_of_result(result: RunResult) -> BaselineRun:
    """A run that has just ended."""
    figures = flat_figures(result.metrics, result.gnss, result.cpu, result.buses, result.faults)
    return BaselineRun(result.profile, (), result.seed, {**gated(figures), DID_NOT_FINISH: 0.0})


def run_of_document(document: Mapping[str, Any]) -> BaselineRun:
    """A run as `result.json` tells it."""
    figures = flat_figures(
        document["metrics"],
        document["gnss"],
        [CpuUse(**one) for one in document["cpu"]],
        [BusUse(**one) for one in document["buses"]],
        [FaultUse(**one) for one in document["faults"]],
    )
    return BaselineRun(document["profile"], (), document["seed"], {**gated(figures), DID_NOT_FINISH: 0.0})
