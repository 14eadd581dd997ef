"""Which board it is that is attached, and the loop that shadows it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from boards.assembly import installation_of
from boards.description import Board, load_board
from boards.hints import did_you_mean
from boards.places import board_folder
from boards.validation import DescriptionError
from firmware.link.raw_frames import INPUTS, RAW_START
from firmware.numerics.subnormals import check_subnormals
from host.attach.shadow import Loop
from host.record.errors import UserError
from host.record.manifest import build_manifest
from host.replay.setting import check_manifest, recorded_setup
from host.run.intake import HOST_PORT
from host.run.own_modules import make_importable
from host.run.setup import BOARD_PREFIX, PROFILE_PREFIX
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.overrides import apply_overrides

DOOR = "raw_loop"
ATTACHED = "attached"
"""In the place of the scenario of a recording of a real board."""


@dataclass(frozen=True)
class BoardSetup:
    """A board as it is described, with the profile that the real one runs."""

    board: Board
    folder_name: str
    profile_name: str
    profile: dict[str, Any]
    overrides: tuple[str, ...]

    @property
    def port_baud(self) -> int:
        """Of the host port."""
        return self.board.uarts[HOST_PORT].baud

    def manifest(self, source: str) -> dict[str, Any]:
        """Of a recording of this board."""
        text = (board_folder(self.folder_name) / "board.toml").read_text(encoding="utf-8")
        manifest = build_manifest(self.board.name, text, ATTACHED, "", self.profile_name, 0, self.overrides)
        return {**manifest, "attached_to": source}

    def loop(self) -> Loop:
        """The navigation loop of the program behind the host port, all its kernels called once.

        Raises UserError for a program that has none, or not with this profile.
        """
        processor = self.board.uarts[HOST_PORT].processor
        module = self.board.processors[processor].program.partition(":")[0]
        door: Callable[..., Loop] | None = getattr(import_module(module), DOOR, None)
        if door is None:
            raise UserError(
                f"board {self.board.name}: its program {module} cannot be shadowed, it has no {DOOR}(profile,"
                " installation, captures); --no-shadow shows and records it"
            )
        pins = self.board.pins
        captures = [n for n, p in pins.items() if p.use == "capture" and p.wired and p.processor == processor]
        check_subnormals()
        try:
            loop = door(self.profile, installation_of(self.board), captures)
        except ValueError as error:
            raise UserError(f"--profile {self.profile_name}: {error}") from None
        for kind, layout in INPUTS.items():
            loop.take(kind, layout.unpack(bytes(layout.size))[1:])
            loop.solution()
        loop.take(RAW_START, ())
        return loop


def board_setup(board: str, profile: str | None, overrides: tuple[str, ...]) -> BoardSetup:
    """Find, change and validate. Raises UserError."""
    _check_overrides(overrides, (BOARD_PREFIX, PROFILE_PREFIX))
    try:
        return _board_setup(board, profile, overrides)
    except (DescriptionError, ScenarioError) as error:
        raise UserError(str(error)) from None


def setup_of_capture(
    manifest: Mapping[str, Any], board: str | None, profile: str | None, overrides: tuple[str, ...]
) -> BoardSetup:
    """The setup that a capture was made with; `board`, `profile` in place of the recorded ones, `overrides`
    on top. Raises UserError."""
    check_manifest(manifest)
    recorded = tuple(str(change) for change in manifest["overrides"])
    if manifest["scenario"] == ATTACHED:
        kept = () if profile not in (None, manifest["profile"]) else recorded
        return board_setup(
            board or str(manifest["board"]), profile or str(manifest["profile"]), kept + overrides
        )
    try:
        setup = recorded_setup(manifest, board, profile)
        own = [c.removeprefix(PROFILE_PREFIX) for c in overrides if c.startswith(PROFILE_PREFIX)]
        _check_overrides(overrides, (PROFILE_PREFIX,))
        settings = apply_overrides(setup.profile, own)
    except (DescriptionError, ScenarioError) as error:
        raise UserError(str(error)) from None
    name = board or str(manifest["board"])
    return BoardSetup(setup.board, name, setup.profile_name, settings, (*recorded, *overrides))


def _check_overrides(overrides: tuple[str, ...], own: tuple[str, ...]) -> None:
    for change in overrides:
        if not change.startswith(own):
            raise UserError(
                f"--set {change}: only {' and '.join(f'{prefix}…' for prefix in own)} can be set here;"
                " for example --set profile.aiding=false"
            )


def _board_setup(board: str, profile: str | None, overrides: tuple[str, ...]) -> BoardSetup:
    make_importable(load_board(board), board_folder(board))
    board_changes = [c.removeprefix(BOARD_PREFIX) for c in overrides if c.startswith(BOARD_PREFIX)]
    described = load_board(board, lambda data: apply_overrides(data, board_changes))
    if HOST_PORT not in described.uarts:
        raise UserError(f"board {described.name}: it has no UART {HOST_PORT!r}, where boards speak our link")
    name = described.default_profile if profile is None else profile
    if name not in described.profiles:
        hint = did_you_mean(name, described.profiles)
        raise UserError(f"--profile {name}: {described.name} has no such profile; {hint}")
    changes = [c.removeprefix(PROFILE_PREFIX) for c in overrides if c.startswith(PROFILE_PREFIX)]
    return BoardSetup(described, board, name, apply_overrides(described.profiles[name], changes), overrides)
