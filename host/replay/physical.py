"""Physical replay: the present board, with any profile, on the road and the measurements of a capture.

The chips are whole again and feel what the recorded ones measured, linear between the recorded samples; their
own ranges, rates, quantisation, texts and wires apply on top. Noise is that of the recorded sensor: none is
added. The result is scored against the recorded truth, or else against the recorded solution.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from boards.places import board_folder
from host.capture.topics import IMPORT_FORMAT
from host.record.errors import UserError
from host.record.manifest import build_manifest
from host.record.result import RunRequest, RunResult
from host.recovery.whole_reader import WholeReader
from host.replay.imported import ImportedContent, imported_manifest
from host.replay.recorded_world import CaptureContent, RecordedContent, RecordedVehicle, RecordedWorld
from host.replay.request import REPLAY_FORMAT, ReplayRequest
from host.replay.setting import check_manifest, recorded_board, recorded_setup
from host.run.runner import run_in_world
from host.run.setup import BOARD_PREFIX, PROFILE_PREFIX, Setup


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
    reader = WholeReader(request.capture)
    next(iter(reader.windows()), None)
    content: RecordedContent
    if reader.manifest.get("format") == IMPORT_FORMAT:
        imported = ImportedContent(reader)
        manifest = imported_manifest(imported, reader, request)
        content, rules = imported, "recording"
    else:
        check_manifest(reader.manifest)
        manifest = {**reader.manifest, "overrides": [*reader.manifest["overrides"], *request.overrides]}
        content, rules = CaptureContent(reader, recorded_board(reader.manifest)), "simulated"
    setup = recorded_setup(manifest, request.board, request.profile)
    duration_ns = reader.end_ns if reader.end_ns is not None and rules == "simulated" else content.end_ns
    changes = {"expect": {}, "duration_s": duration_ns / 1e9, "kind": rules}
    scenario = setup.scenario.model_copy(update=changes)
    vehicle = RecordedVehicle(scenario, content, duration_ns)
    if len(vehicle.road) < 2:
        raise UserError(
            f"capture {request.capture}: it holds no navigation solution, so nothing could be scored"
        )
    run = RunRequest(
        board=request.board or str(manifest["board"]),
        profile=setup.profile_name,
        seed=int(manifest["seed"]),
        out_dir=request.out_dir,
        progress=request.progress,
        notice=request.notice,
    )
    world = RecordedWorld(scenario, vehicle)
    result = run_in_world(run, setup, world, _manifest(manifest, setup, run))
    return PhysicalResult(str(request.capture), vehicle.road.known_from, result)


def _manifest(recorded: Mapping[str, Any], setup: Setup, run: RunRequest) -> dict[str, Any]:
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
