"""What `navtwin replay` does and prints."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rich.console import Console

from host.capture.places import capture_path
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.terminal import (
    print_result,
    print_verdict,
    progress_bar,
    standard_error,
)
from host.record.errors import UserError
from host.replay.request import ReplayRequest
from host.replay.strict import StrictResult, replay_strict


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where the outcome goes."""

    json: str | None
    quiet: bool


def replay_strictly(request: ReplayRequest, outputs: Outputs) -> int:
    """Replay, write, print; the exit code."""
    if request.overrides:
        raise UserError(
            f"--set {request.overrides[0]}: a strict replay repeats what was; use --mode physical"
        )
    request = replace(request, capture=capture_path(request.capture), notice=standard_error().print)
    check_files(("--json", outputs.json), read=request.capture)
    with progress_bar(f"replay {request.capture.name}", outputs.quiet) as progress:
        result = replay_strict(replace(request, progress=progress))
    write_json(result.to_dict(), outputs.json)
    _tell(for_people(outputs.json), result)
    return EXIT_MET if result.ok else EXIT_NOT_MET


def replay_physically(request: ReplayRequest, outputs: Outputs) -> int:
    """Replay, write, print; the exit code."""
    from host.replay.physical import replay_physical

    request = replace(request, capture=capture_path(request.capture), notice=standard_error().print)
    check_files(("--json", outputs.json), read=request.capture)
    with progress_bar(f"replay {request.capture.name}", outputs.quiet) as progress:
        replayed = replay_physical(replace(request, progress=progress))
    write_json(replayed.to_dict(), outputs.json)
    console = for_people(outputs.json)
    if not outputs.quiet:
        print_result(console, replayed.result)
    console.print(
        f"on the road of {replayed.capture}, scored against the {replayed.scored_against}", soft_wrap=True
    )
    print_verdict(console, replayed.result)
    return EXIT_MET


def _tell(console: Console, result: StrictResult) -> None:
    name = f"{result.board} {result.scenario} {result.profile} seed {result.seed}"
    speed = f"{result.duration_s:,.1f} s in {result.wall_s:,.1f} s"
    if result.difference is not None:
        console.print(result.difference.text(), soft_wrap=True, markup=False)
        console.print(f"{name}: does not repeat ({speed})", style="bold red", soft_wrap=True)
        return
    if not result.capture_complete:
        console.print("the capture ends before its run did: what there is has been replayed", soft_wrap=True)
    if not result.ok:
        console.print(
            f"{name}: all traffic repeats, but the final state does not\n"
            f"  recorded: {result.recorded_state_hash}\n  replayed: {result.state_hash}",
            style="bold red",
            soft_wrap=True,
        )
        return
    console.print(f"state hash {result.state_hash}", soft_wrap=True)
    counted = f"{result.transactions:,} bus transactions, {result.bytes_compared:,} bytes of output records"
    console.print(f"{name}: repeats exactly, {counted} ({speed})", style="bold green", soft_wrap=True)
