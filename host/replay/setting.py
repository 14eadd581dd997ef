"""What a captured run was made of: board, profile and scenario from the texts in its manifest."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from typing import Any

from boards.description import Board, load_board
from boards.hints import did_you_mean
from boards.places import board_folder
from boards.validation import DescriptionError, validated
from host.capture.topics import IMPORT_FORMAT
from host.record.errors import UserError
from host.record.manifest import MANIFEST_FORMAT
from host.run.own_modules import make_importable
from host.run.setup import BOARD_PREFIX, PROFILE_PREFIX, Setup
from host.sim.scenario.load import merged, scenario_from
from host.sim.scenario.overrides import apply_overrides
from host.sim.scenario.schema import Scenario

NEEDED: dict[str, type] = {
    "board": str,
    "board_text": str,
    "scenario": str,
    "scenario_text": str,
    "profile": str,
    "seed": int,
    "overrides": list,
}
"""What the manifest of a run tells, and as what."""
INHERITED = "\n# --- inherited: "
"""Stands between the texts of a scenario and of what it inherits (`host.sim.scenario.load.source_text`)."""


def recorded_setup(manifest: Mapping[str, Any], board: str | None, profile: str | None) -> Setup:
    """The setup of a captured run on the present board and firmware.

    `board`, `profile`: others in place of the recorded ones; what the recorded run changed of its own board
    or profile then does not apply. Raises UserError, DescriptionError or ScenarioError.
    """
    check_manifest(manifest)
    if "attached_to" in manifest:
        raise UserError(
            f"the capture is of a real board at {manifest['attached_to']}: its buses were not recorded;"
            " navtwin attach board --port CAPTURE shadows it again"
        )
    overrides = [str(change) for change in manifest["overrides"]]
    scenario = recorded_scenario(manifest)
    name = board or str(manifest["board"])
    described = _board(name, manifest, scenario, overrides, named=board is not None)
    profile_name = profile or str(manifest["profile"])
    if profile_name not in described.profiles:
        hint = did_you_mean(profile_name, described.profiles)
        raise UserError(f"--profile {profile_name}: {described.name} has no such profile; {hint}")
    changes = _with_prefix(overrides, PROFILE_PREFIX) if profile_name == manifest["profile"] else []
    settings = {**described.profiles[profile_name], **scenario.profile.get(profile_name, {})}
    return Setup(described, scenario, profile_name, apply_overrides(settings, changes))


def recorded_board(manifest: Mapping[str, Any]) -> Board:
    """The board as it was when the capture was made. Raises UserError, DescriptionError or ScenarioError."""
    _check_keys(manifest, ("board", "board_text"))
    overrides = [str(change) for change in manifest["overrides"]]
    data = merged(_parsed(str(manifest["board_text"]), "board_text"), recorded_scenario(manifest).board)
    described = apply_overrides(data, _with_prefix(overrides, BOARD_PREFIX))
    return validated(Board, described, f"board {manifest['board']} in the capture")


def check_manifest(manifest: Mapping[str, Any]) -> None:
    """Raises UserError when it is not that of a run, or lacks what that tells."""
    if manifest.get("format") == IMPORT_FORMAT:
        raise UserError(
            "the capture was imported: there is no run in it that could be repeated; drive a board by it with"
            " --board car_mems --mode physical"
        )
    if manifest.get("format") != MANIFEST_FORMAT:
        raise UserError(
            f"the capture's manifest is of format {manifest.get('format')!r}; this version reads"
            f" {MANIFEST_FORMAT!r} as written by navtwin run"
        )
    _check_keys(manifest, NEEDED)


def _check_keys(manifest: Mapping[str, Any], keys: Iterable[str]) -> None:
    for key in keys:
        kind = NEEDED[key]
        if not isinstance(manifest.get(key), kind):
            found = f"is {manifest[key]!r}" if key in manifest else "is missing"
            raise UserError(
                f"the capture's manifest is damaged: {key!r} {found:.60}; a run of navtwin writes a"
                f" {kind.__name__} there"
            )


def board_text_differs(manifest: Mapping[str, Any], board: str | None) -> bool:
    """Whether the board's description is another one than when the capture was made."""
    path = board_folder(board or str(manifest["board"])) / "board.toml"
    return path.read_text(encoding="utf-8") != manifest["board_text"]


def _parsed(text: str, name: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"the capture's manifest is damaged: {name} is not valid TOML: {error}") from None


def recorded_scenario(manifest: Mapping[str, Any]) -> Scenario:
    """The scenario that the capture was made with. Raises UserError or ScenarioError."""
    _check_keys(manifest, ("overrides", "scenario", "scenario_text"))
    overrides = [str(change) for change in manifest["overrides"]]
    data: dict[str, Any] = {}
    own, *inherited = str(manifest["scenario_text"]).split(INHERITED)
    for text in (*(f"# {rest}" for rest in reversed(inherited)), own):
        table = _parsed(text, "scenario_text")
        table.pop("inherit", None)
        data = merged(data, table)
    changes = [change for change in overrides if not change.startswith((BOARD_PREFIX, PROFILE_PREFIX))]
    name = str(manifest["scenario"])
    return scenario_from(apply_overrides(data, changes), name, f"scenario {name} in the capture")


def _board(
    name: str, manifest: Mapping[str, Any], scenario: Scenario, overrides: list[str], *, named: bool
) -> Board:
    recorded = str(manifest["board"])
    try:
        folder_board = load_board(name)
    except DescriptionError as error:
        if named:
            raise
        raise UserError(
            f"the capture is of the board {recorded!r}, which is not found here ({error});"
            " name its folder with --board"
        ) from None
    make_importable(folder_board, board_folder(name))
    if folder_board.name != recorded:
        return folder_board
    changes = _with_prefix(overrides, BOARD_PREFIX)
    return load_board(name, lambda data: apply_overrides(merged(data, scenario.board), changes))


def _with_prefix(overrides: list[str], prefix: str) -> list[str]:
    return [change.removeprefix(prefix) for change in overrides if change.startswith(prefix)]
