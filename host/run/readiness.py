"""All that comes before virtual time: setup, world, and a board in its surroundings with its faults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from boards.assembly import AssembledBoard, assemble
from boards.description import Board
from boards.hints import did_you_mean
from boards.places import board_folder
from boards.validation import DescriptionError
from firmware.numerics.subnormals import check_subnormals
from hal.board_io import NotNamedError
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.faults import Placed, name_of, place_faults
from host.run.intake import HOST_PORT
from host.run.panel import Panel, panel_of
from host.run.setup import Setup, resolve
from host.run.surroundings import Surroundings
from host.run.warm_up import warm_up
from host.score.expectations import check_names
from host.sim.scenario.errors import ScenarioError
from host.sim.world import World


@dataclass(frozen=True)
class StandIn:
    """What takes a chip's place on the board: `model` ("module:name") is called as a chip model is, with
    these parameters, which may be any objects."""

    model: str
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Ready:
    """A board in its surroundings, with all faults in place; nothing has been written yet."""

    surroundings: Surroundings
    board: AssembledBoard
    faults: list[Placed]
    panel: Panel | None
    """None: the board has no keys, display or mode switch."""


def prepared(request: RunRequest) -> tuple[Setup, World]:
    """What is to run, and its world. Raises UserError for whatever the user can mend."""
    check_subnormals()
    with user_errors():
        setup = resolve(request)
        scenario = setup.scenario
        source = str(scenario.path or scenario.name)
        check_names(scenario.expect, _parts(setup), source, scenario.kind == "recording")
    _check_host_port(setup)
    with user_errors():
        world = World(setup.scenario, request.seed, request.data_dir)
    return setup, world


def make_ready(
    request: RunRequest, setup: Setup, world: World, stand_ins: Mapping[str, StandIn] | None = None
) -> Ready:
    """Compile what will be called, and put the board together; chips of `stand_ins`, by their reference
    designators, are exchanged. Raises UserError."""
    with user_errors(board_source(request)):
        warm_up(setup, world.another, request.notice)
        surroundings = Surroundings(world, request.out_dir)
        board = assemble(_exchanged(setup.board, stand_ins or {}), setup.profile, surroundings)
        faults = place_faults(
            world.scenario.fault, board, surroundings.sights, request.seed, world.duration_ns
        )
        panel = panel_of(board, world.scenario.panel)
    return Ready(surroundings, board, faults, panel)


def board_source(request: RunRequest) -> str:
    """How messages about the board's description begin."""
    return f"{board_folder(request.board) / 'board.toml'}: "


@contextmanager
def user_errors(source: str = "") -> Iterator[None]:
    """Turn errors of descriptions into the one error that the command line shows without a traceback."""
    try:
        yield
    except (DescriptionError, ScenarioError) as error:
        raise UserError(str(error)) from None
    except NotNamedError as error:
        raise UserError(f"{source}{error}") from None


def _exchanged(description: Board, stand_ins: Mapping[str, StandIn]) -> Board:
    for refdes in stand_ins:
        if refdes not in description.chips:
            hint = did_you_mean(refdes, description.chips)
            raise UserError(f"board {description.name} has no chip {refdes!r} to be replaced; {hint}")
    chips = dict(description.chips)
    for refdes, other in stand_ins.items():
        changes = {"model": other.model, "parameters": dict(other.parameters)}
        chips[refdes] = chips[refdes].model_copy(update=changes)
    return description.model_copy(update={"chips": chips}) if stand_ins else description


def _check_host_port(setup: Setup) -> None:
    """What comes over the UART called "host" is what is scored."""
    if HOST_PORT not in setup.board.uarts:
        known = ", ".join(setup.board.uarts) or "none"
        processor = next(iter(setup.board.processors))
        raise UserError(
            f"board {setup.board.name}: no UART {HOST_PORT!r} for the solution (there is: {known});"
            f' for example [uarts.{HOST_PORT}] processor = "{processor}", baud = 230_400'
        )


def _parts(setup: Setup) -> dict[str, list[str]]:
    board = setup.board
    return {
        "cpu": list(board.processors),
        "buses": [
            *board.buses,
            *(f"{name}.{direction}" for name in board.uarts for direction in ("rx", "tx")),
            *board.can,
            *(f"{name}.{end}" for name, joined in board.interconnects.items() for end in joined.processors),
        ],
        "faults": [name_of(fault) for fault in setup.scenario.fault],
    }
