"""Where the words come from, a scenario that is run now or a capture, and what the computer is told."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from boards.assembly import installation_of
from boards.description import Board, load_board
from firmware.apps.uav_ahrs.attitude import attitude_config
from firmware.apps.uav_ahrs.settings import Settings
from firmware.nav.attitude.config import AttitudeConfig
from host.capture.places import capture_path
from host.capture.reader import CaptureReader
from host.record.errors import UserError
from host.record.result import RunRequest
from host.replay.setting import recorded_setup
from host.run.runner import run
from host.run.setup import Setup, resolve

PROGRAM = "firmware.apps.uav_ahrs"


@dataclass(frozen=True, slots=True)
class Source:
    """A capture with bursts, and what its board was."""

    capture: Path
    config: AttitudeConfig
    name: str


@contextmanager
def from_run(request: RunRequest) -> Iterator[Source]:
    """The words of a run made now, whose capture is gone afterwards. Raises UserError."""
    _check_program(load_board(request.board))
    setup = resolve(request)
    config = _config(setup)
    with tempfile.TemporaryDirectory(prefix="navtwin-compare-") as folder:
        made = RunRequest(
            board=request.board,
            scenario=request.scenario,
            profile=request.profile,
            seed=request.seed,
            overrides=request.overrides,
            data_dir=request.data_dir,
            out_dir=Path(folder) / "run",
            progress=request.progress,
        )
        run(made)
        name = f"{setup.board.name} {setup.scenario.name}, seed {request.seed}"
        yield Source(Path(folder) / "run" / "run.mcap", config, name)


def from_capture(given: Path) -> Source:
    """The words of a capture, and the configuration in its manifest. Raises UserError."""
    path = capture_path(given)
    reader = CaptureReader(path)
    next(iter(reader.windows()), None)
    return Source(path, _config(recorded_setup(reader.manifest, None, None)), str(given))


def _check_program(board: Board) -> None:
    programs = [one.program for one in board.processors.values()]
    if not any(program.startswith(PROGRAM) for program in programs):
        raise UserError(
            f"board {board.name}: its firmware exists in one arithmetic; compare takes boards with the"
            " attitude computer, for example navtwin compare uav_ahrs"
        )


def _config(setup: Setup) -> AttitudeConfig:
    _check_program(setup.board)
    try:
        settings = Settings.of(setup.profile)
    except ValueError as error:
        raise UserError(f"profile {setup.profile_name}: {error}") from None
    return attitude_config(settings, installation_of(setup.board))
