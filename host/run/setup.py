"""From what was asked to what is run: board, profile and scenario, found, overridden and validated."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from boards.description import Board, load_board
from boards.hints import did_you_mean
from boards.places import board_folder
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.own_modules import make_importable
from host.sim.scenario.load import load_scenario, merged
from host.sim.scenario.overrides import apply_overrides
from host.sim.scenario.schema import Scenario
from host.sim.seeding import LARGEST_SEED

BOARD_PREFIX = "board."
PROFILE_PREFIX = "profile."


@dataclass(frozen=True)
class Setup:
    """Everything that decides a run, besides the seed."""

    board: Board
    scenario: Scenario
    profile_name: str
    profile: dict[str, Any]


def resolve(request: RunRequest) -> Setup:
    """Find, override and validate. Raises UserError, DescriptionError or ScenarioError."""
    if not 0 <= request.seed <= LARGEST_SEED:
        raise UserError(
            f"--seed {request.seed}: a seed is a whole number in 0 … {LARGEST_SEED}, for example --seed 1"
        )
    board_changes = _with_prefix(request.overrides, BOARD_PREFIX)
    profile_changes = _with_prefix(request.overrides, PROFILE_PREFIX)
    others = [change for change in request.overrides if not change.startswith((BOARD_PREFIX, PROFILE_PREFIX))]
    folder_board = load_board(request.board)
    make_importable(folder_board, board_folder(request.board))
    scenario = load_scenario(
        scenario_path(request.board, _or(request.scenario, folder_board.default_scenario)), others
    )
    board = load_board(
        request.board, lambda data: apply_overrides(merged(data, scenario.board), board_changes)
    )
    profile_name = _or(request.profile, board.default_profile)
    if profile_name not in board.profiles:
        hint = did_you_mean(profile_name, board.profiles)
        raise UserError(f"--profile {profile_name}: {board.name} has no such profile; {hint}")
    profile = apply_overrides(
        {**board.profiles[profile_name], **scenario.profile.get(profile_name, {})}, profile_changes
    )
    return Setup(board, scenario, profile_name, profile)


def _or(asked: str | None, default: str) -> str:
    """An empty name is a name, and a wrong one."""
    return default if asked is None else asked


def scenario_names(board: str) -> list[str]:
    """The scenarios that come with a board, in alphabetical order."""
    return sorted(path.stem for path in (board_folder(board) / "scenarios").glob("*.toml"))


def scenario_path(board: str, scenario: str) -> Path:
    """The file of a scenario given by name or by path. Raises UserError."""
    given = Path(scenario)
    if given.suffix == ".toml" or given.parent != Path():
        if not given.is_file():
            raise UserError(f"--scenario {scenario}: no such file; for example --scenario my-drive.toml")
        return given
    names = scenario_names(board)
    if scenario not in names:
        raise UserError(
            f"--scenario {scenario}: {board} has no such scenario; {did_you_mean(scenario, names)}"
            " (a file of your own is given by its path, e.g. ./drive.toml)"
        )
    return board_folder(board) / "scenarios" / f"{scenario}.toml"


def _with_prefix(overrides: tuple[str, ...], prefix: str) -> list[str]:
    return [change.removeprefix(prefix) for change in overrides if change.startswith(prefix)]
