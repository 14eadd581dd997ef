"""What `navtwin attach gnss` does and prints."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from boards.validation import DescriptionError
from host.attach.first_fix import Fix, wait_for_fix
from host.attach.gnss_session import (
    LONGEST_S,
    GnssAttachment,
    opened,
    pulse_changes,
    receiver_of,
    standing_request,
)
from host.attach.receiver_port import ReceiverPort
from host.cli.attach_screen import Screen, ended_by_signals, screen
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.terminal import standard_error
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.runner import check
from host.run.setup import Setup, resolve
from host.sim.scenario.errors import ScenarioError


@dataclass(frozen=True, slots=True)
class GnssRequest:
    """What was asked for."""

    port: str
    baud: int | None
    wait_s: float
    seconds: float | None
    record_only: bool
    run: RunRequest


def attach_gnss(request: GnssRequest, json_to: str | None, quiet: bool) -> int:
    """Attach, print, write; the exit code. Raises UserError for what the user can mend."""
    check_files(("--json", json_to))
    run, setup = _checked(request)
    console = for_people(json_to)
    error = standard_error()

    def tell(text: str) -> None:
        if not quiet:
            error.print(text, soft_wrap=True, markup=False)

    port = ReceiverPort(request.port, request.baud)
    try:
        fix = (
            None if request.record_only and request.run.scenario else wait_for_fix(port, request.wait_s, tell)
        )
        if fix is not None:
            tell(fix.text())
        run, setup = _placed(run, fix, request)
        title = f"{setup.board.name}, receiver on {request.port}"
        with screen(title, quiet) as shown:
            attachment = _run(run, setup, port, request, shown)
    finally:
        port.close()
    _write(attachment, fix, json_to)
    _tell(console, request, attachment, quiet)
    return EXIT_MET if attachment.epochs_used else EXIT_NOT_MET


def _run(
    run: RunRequest, setup: Setup, port: ReceiverPort, request: GnssRequest, shown: Screen
) -> GnssAttachment:
    with opened(run, setup, port, request.record_only, shown.show, shown.notice) as session:
        shown.begin(session.decoder)
        with ended_by_signals(session):
            return session.run()


def _checked(request: GnssRequest) -> tuple[RunRequest, Setup]:
    """All that can be told before the port is opened."""
    if request.seconds is not None and not 1.0 <= request.seconds <= LONGEST_S:
        raise UserError(f"--seconds {request.seconds:g}: 1 … {LONGEST_S:g} is possible; e.g. --seconds 60")
    try:
        run = standing_request(request.run, request.record_only)
        setup = resolve(run)
    except (DescriptionError, ScenarioError) as error:
        raise UserError(str(error)) from None
    receiver_of(setup.board)
    check(replace(run, notice=standard_error().print))
    return run, setup


def _placed(run: RunRequest, fix: Fix | None, request: GnssRequest) -> tuple[RunRequest, Setup]:
    """The scenario at the place and time of the fix, for as long as was asked, judged by nobody."""
    where = () if fix is None else fix.overrides()
    seconds = LONGEST_S if request.seconds is None else request.seconds
    if request.seconds is None and request.record_only and request.run.scenario:
        length: tuple[str, ...] = ()
    else:
        length = (f"duration_s={seconds!r}",)
    own = (*where, *length, "expect={}", *pulse_changes(resolve(run).board))
    out = run.out_dir or Path("runs") / f"{Path(run.board).name}-gnss-{time.strftime('%Y%m%d-%H%M%S')}"
    changed = replace(run, overrides=(*own, *run.overrides), out_dir=out)
    return changed, resolve(changed)


def _write(attachment: GnssAttachment, fix: Fix | None, json_to: str | None) -> None:
    if json_to is None:
        return
    result = attachment.result
    document: dict[str, Any] = {
        "format": "navtwin-attach-1",
        "kind": "gnss",
        "board": result.board,
        "scenario": result.scenario,
        "profile": result.profile,
        "duration_s": result.duration_s,
        "wall_s": result.wall_s,
        "state_hash": result.state_hash,
        "out_dir": None if result.out_dir is None else str(result.out_dir),
        "first_fix": None
        if fix is None
        else {
            "latitude_deg": fix.latitude_deg,
            "longitude_deg": fix.longitude_deg,
            "height_m": fix.height_m,
            "utc": fix.utc.isoformat(),
        },
        **attachment.figures,
    }
    write_json(document, json_to)


def _tell(console: Console, request: GnssRequest, attachment: GnssAttachment, quiet: bool) -> None:
    figures, result = attachment.figures, attachment.result

    def say(text: str, style: str = "") -> None:
        console.print(text, soft_wrap=True, markup=False, style=style)

    if not quiet:
        rate = "" if figures["baud"] is None else f" at {figures['baud']} baud"
        say(
            f"{result.duration_s:,.1f} s: {figures['bytes_from_receiver']:,} bytes from the receiver{rate},"
            f" {figures['bytes_to_receiver']:,} to it; {attachment.epochs_used:,} epochs with a position used"
        )
        if figures["bytes_dropped"]:
            say(f"{figures['bytes_dropped']:,} bytes came faster than the board's line is, and were dropped")
        if figures["port_losses"]:
            losses, back = figures["port_losses"], figures["port_reopenings"]
            say(f"the port vanished {losses} times, came back {back} times")
        _tell_latency(say, figures)
        if attachment.scored:
            _tell_scatter(say, figures["scatter"])
        else:
            say("recorded only: nothing is judged")
        say(f"report: {result.out_dir / 'report.html'}" if result.out_dir else "")
    if attachment.epochs_used:
        say(f"{result.board} {result.profile}: ran on the receiver at {request.port}", "bold green")
    else:
        say(f"{result.board} {result.profile}: no epoch with a position came in", "bold red")


def _tell_latency(say: Any, figures: dict[str, Any]) -> None:
    latency, forwarding = figures["latency"], figures["forwarding"]
    if "latency_median_ms" in latency:
        say(
            f"latency: median {latency['latency_median_ms']:.1f} ms ({latency['latency_min_ms']:.1f} …"
            f" {latency['latency_max_ms']:.1f}), jitter {latency['jitter_rms_ms']:.1f} ms RMS over"
            f" {latency['epochs']} epochs ({latency['method']})"
        )
    elif "jitter_rms_ms" in latency:
        say(
            f"latency: not known, receiver and host do not have the same time; jitter"
            f" {latency['jitter_rms_ms']:.1f} ms RMS over {latency['epochs']} epochs"
        )
    if forwarding["mean_ms"] is not None:
        say(
            f"from the port to the board's line: mean {forwarding['mean_ms']:.1f} ms,"
            f" at most {forwarding['max_ms']:.1f} ms"
        )


def _tell_scatter(say: Any, scatter: dict[str, Any]) -> None:
    for name in ("receiver", "solution"):
        one = scatter[name]
        if one["positions"]:
            north, east, down = (one[f"sigma_{axis}_m"] for axis in ("north", "east", "down"))
            say(
                f"scatter of the {name}: {north:.2f} m north, {east:.2f} m east, {down:.2f} m down"
                f" (1 sigma of {one['positions']:,}); farthest from the first"
                f" {one['farthest_from_first_m']:.2f} m"
            )
    say(f"  {scatter['meaning']}")
