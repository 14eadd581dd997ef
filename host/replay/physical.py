"""Physical replay: the present board, with any profile, on the road and the measurements of a capture.

The chips are whole again and feel what the recorded ones measured, linear between the recorded samples; their
own ranges, rates, quantisation, texts and wires apply on top. Noise is that of the recorded sensor: none is
added. The result is scored against the recorded truth, or else against the recorded solution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from boards.places import board_folder
from host.capture.reader import CaptureReader
from host.record.errors import UserError
from host.record.manifest import build_manifest
from host.record.result import RunRequest, RunResult
from host.replay.recorded_world import CaptureContent, RecordedVehicle, RecordedWorld
from host.replay.request import REPLAY_FORMAT, ReplayRequest
from host.replay.setting import recorded_board, recorded_setup
from host.run.runner import run_in_world
from host.run.setup import BOARD_PREFIX, PROFILE_PREFIX, Setup

AGAINST_TRUTH, AGAINST_SOLUTION = "truth", "recorded solution"


@dataclass(frozen=True, slots=True)
class PhysicalResult:
    """A run on a capture, and what its errors are measured against."""

    capture: str
    scored_against: str
    result: RunResult

    def to_dict(self) -> dict[str, Any]:
        """The figures of a run, and what is special about them."""
        return {
            **self.result.to_dict(),
            "replay": REPLAY_FORMAT,
            "mode": "physical",
            "capture": self.capture,
            "scored_against": self.scored_against,
        }


def replay_physical(request: ReplayRequest) -> PhysicalResult:
    """Replay a capture. Raises UserError for whatever the user can mend."""
    reader = CaptureReader(request.capture)
    next(iter(reader.windows()), None)
    setup = recorded_setup(reader.manifest, request.board, request.profile)
    board = recorded_board(reader.manifest)
    content = CaptureContent(reader, board)
    duration_ns = reader.end_ns or content.end_ns
    scenario = setup.scenario.model_copy(update={"expect": {}, "duration_s": duration_ns / 1e9})
    vehicle = RecordedVehicle(scenario, board, content, duration_ns)
    if len(vehicle.road) < 2:
        raise UserError(
            f"capture {request.capture}: it holds no navigation solution, so nothing could be scored"
        )
    run = RunRequest(
        board=request.board or str(reader.manifest["board"]),
        profile=setup.profile_name,
        seed=int(reader.manifest["seed"]),
        out_dir=request.out_dir,
        progress=request.progress,
        notice=request.notice,
    )
    world = RecordedWorld(scenario, vehicle)
    result = run_in_world(run, setup, world, _manifest(reader, setup, run))
    against = AGAINST_TRUTH if vehicle.road.from_truth else AGAINST_SOLUTION
    return PhysicalResult(str(request.capture), against, result)


def _manifest(reader: CaptureReader, setup: Setup, run: RunRequest) -> dict[str, Any]:
    recorded = reader.manifest
    dropped: tuple[str, ...] = ()
    if setup.profile_name != recorded["profile"]:
        dropped += (PROFILE_PREFIX,)
    if setup.board.name != recorded["board"]:
        dropped += (BOARD_PREFIX,)
    kept = [change for change in recorded["overrides"] if not (dropped and change.startswith(dropped))]
    manifest = build_manifest(
        setup.board.name,
        (board_folder(run.board) / "board.toml").read_text(encoding="utf-8"),
        setup.scenario.name,
        str(recorded["scenario_text"]),
        setup.profile_name,
        run.seed,
        [*kept, "fault=[]", "expect={}"],
    )
    return {**manifest, "replay_of": {"board": recorded["board"], "profile": recorded["profile"]}}
