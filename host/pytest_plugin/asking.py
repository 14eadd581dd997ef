"""From the marks of a test and the arguments of `navtwin_run(...)` to a run, made once in a session."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from boards.hints import did_you_mean
from host.pytest_plugin.checked_run import CheckedRun
from host.record.command_line import command_line, toml
from host.record.errors import UserError
from host.record.result import RunRequest, RunResult

KEYS = ("board", "scenario", "profile", "seed", "overrides", "faults", "data")
RUNS_KEPT = 64
"""With its series, a run of 20 minutes takes 2 MB."""
_RESULTS = pytest.StashKey[dict[RunRequest, RunResult]]()


class Asking:
    """The fixture `navtwin_run` of one test."""

    def __init__(self, request: pytest.FixtureRequest) -> None:
        self._node = request.node
        self._config = request.config

    def __call__(self, board: str | Path | None = None, **wanted: Any) -> CheckedRun:
        """Run what the test's marks say, changed by the arguments; the same run is made once a session.

        `board`: name or path; `scenario`, `profile`, `seed` as those of `navtwin run`; `overrides`: what
        `--set` changes, `{"gnss.latency_s": 0.1}`; `faults`: tables as under `[[fault]]`, in place of the
        scenario's; `data`: folder of recordings. Paths are relative to pytest's rootdir.
        """
        __tracebackhide__ = True
        if board is not None:
            wanted["board"] = board
        try:
            request = self._request(wanted)
            return CheckedRun(self._result(request), request, self._note)
        except UserError as error:
            mistake = str(error)
        pytest.fail(f"navtwin_run: {mistake}", pytrace=False)  # not in the handler: it would be told twice

    def _request(self, wanted: Mapping[str, Any]) -> RunRequest:
        """Marks from the module's to the test's own, then the arguments."""
        chosen: dict[str, Any] = {}
        marks = [_settings(mark) for mark in self._node.iter_markers("navtwin")]
        for level in (*reversed(marks), wanted):
            _check_keys(level)
            overrides = {**chosen.get("overrides", {}), **level.get("overrides", {})}
            chosen |= {**level, "overrides": overrides}
        if chosen.get("board") is None:
            raise UserError('no board; for example @pytest.mark.navtwin(board="car_mems", scenario="town")')
        scenario, data = chosen.get("scenario"), chosen.get("data")
        return RunRequest(
            board=self._board(str(chosen["board"])),
            scenario=None if scenario is None else self._scenario(str(scenario)),
            profile=chosen.get("profile"),
            seed=_seed(chosen.get("seed", 1)),
            overrides=_overrides(chosen["overrides"], chosen.get("faults")),
            data_dir=None if data is None else self._config.rootpath / data,
            capture=False,
        )

    def _board(self, name_or_path: str) -> str:
        """A board below the rootdir where there is one; else the name as it is."""
        below = self._config.rootpath / name_or_path
        holds_one = any((below / file).is_file() for file in ("board.toml", "pyproject.toml"))
        return str(below) if holds_one or below.is_file() else name_or_path

    def _scenario(self, name_or_path: str) -> str:
        """A name stays; a path, which shows by its ending or its folder, is below the rootdir."""
        path = Path(name_or_path)
        is_path = path.suffix == ".toml" or path.parent != Path()
        return str(self._config.rootpath / path) if is_path else name_or_path

    def _result(self, request: RunRequest) -> RunResult:
        made = self._config.stash.setdefault(_RESULTS, {})
        if request not in made:
            if len(made) >= RUNS_KEPT:
                del made[next(iter(made))]
            made[request] = _run(replace(request, out_dir=self._folder(request)))
        return made[request]

    def _folder(self, request: RunRequest) -> Path | None:
        """Where a run is kept: a folder of its own below --navtwin-out, and for each worker of xdist."""
        place = self._config.getoption("--navtwin-out")
        if not place:
            return None
        parts = [Path(request.board).stem, Path(request.scenario or "default").stem, str(request.seed)]
        if request.overrides or request.profile:
            parts.append(hashlib.sha256(repr(request).encode()).hexdigest()[:8])
        return Path(place, os.environ.get("PYTEST_XDIST_WORKER", ""), "-".join(parts))

    def _note(self, name: str, text: str) -> None:
        """Figure and limit as a property of the test: `--junitxml` writes them."""
        self._node.user_properties.append((name, text))


def _run(request: RunRequest) -> RunResult:
    from host.run.runner import run

    try:
        return run(request)
    except UserError:
        raise
    except Exception as error:
        error.add_note(f"seed {request.seed}\nreproduce: {command_line(request)}")
        raise


def _settings(mark: pytest.Mark) -> dict[str, Any]:
    """`navtwin("car_mems", seed=3)` is `navtwin(board="car_mems", seed=3)`."""
    if len(mark.args) > 1:
        raise UserError(f'mark navtwin{mark.args!r}: name what comes after the board, e.g. scenario="town"')
    return dict(zip(("board",), mark.args, strict=False), **mark.kwargs)


def _check_keys(level: Mapping[str, Any]) -> None:
    for key in level:
        if key not in KEYS:
            raise UserError(f"{key} = {level[key]!r}: no such setting of a run; {did_you_mean(key, KEYS)}")
    if not isinstance(level.get("overrides", {}), Mapping):
        raise UserError(
            f'overrides = {level["overrides"]!r}: must be a dict, e.g. overrides={{"gnss.latency_s": 0.1}}'
        )


def _seed(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise UserError(f"seed = {value!r}: must be a whole number, for example seed=3")
    return value


def _overrides(changes: Mapping[str, Any], faults: Sequence[Mapping[str, Any]] | None) -> tuple[str, ...]:
    every: dict[str, Any] = dict(changes)
    if faults is not None:
        every["fault"] = list(faults)
    return tuple(f"{key}={toml(value)}" for key, value in every.items())
