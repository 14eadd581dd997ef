"""What `navtwin attach board` does and prints."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from hal.live.port import PortError
from host.attach.board_recording import BoardRecording
from host.attach.board_session import Attachment, BoardSession
from host.attach.board_setup import BoardSetup, board_setup, setup_of_capture
from host.attach.board_source import BoardSource, CapturedBoard, capture_at, open_serial
from host.attach.fed_board import FedBoard, inputs_of
from host.attach.shadow import Shadow
from host.cli.attach_screen import ended_by_signals, screen
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.pil.image import BAUD as IMAGE_BAUD
from host.record.errors import UserError
from host.run.intake import HOST_PORT

DEFAULT_BOARD = "car_mems"


@dataclass(frozen=True, slots=True)
class BoardRequest:
    """What was asked for."""

    port: str
    board: str | None
    profile: str | None
    overrides: tuple[str, ...]
    baud: int | None
    out_dir: Path | None
    seconds: float | None
    shadow: bool
    feed: str | None = None
    """A run with raw frames, for a board without sensors of its own."""


def attach_board(request: BoardRequest, json_to: str | None, quiet: bool) -> int:
    """Attach, print, write; the exit code. Raises UserError for what the user can mend."""
    check_files(("--json", json_to))
    capture = capture_at(request.port)
    fed = None if request.feed is None else capture_at(request.feed)
    if request.feed is not None and (fed is None or capture is not None):
        raise UserError(
            f"--feed {request.feed}: a run's folder or capture is fed to a board on a port; for example"
            " --port /dev/ttyUSB0 --feed runs/fed"
        )
    if fed is not None:
        captured = CapturedBoard(fed, HOST_PORT)
        setup = setup_of_capture(captured.manifest, request.board, request.profile, request.overrides)
    elif capture is None:
        setup = board_setup(request.board or DEFAULT_BOARD, request.profile, request.overrides)
    else:
        captured = CapturedBoard(capture, HOST_PORT)
        setup = setup_of_capture(captured.manifest, request.board, request.profile, request.overrides)
    shadow = Shadow(setup.loop()) if request.shadow else None
    source = _source(request, setup, fed) if capture is None else captured
    console = for_people(json_to)
    try:
        attachment, out_dir = _attached(request, setup, source, shadow, quiet)
    finally:
        source.close()
    _write(attachment, setup, json_to)
    _tell(console, setup, attachment, out_dir, quiet)
    return _verdict(attachment, request)


def _source(request: BoardRequest, setup: BoardSetup, fed: Path | None) -> BoardSource:
    if fed is None:
        return open_serial(request.port, request.baud, setup.port_baud)
    inputs = inputs_of(fed, str(request.feed))
    try:
        return FedBoard(request.port, request.baud or IMAGE_BAUD, inputs)
    except PortError as error:
        raise UserError(f"--port {error}") from None


def _attached(
    request: BoardRequest, setup: BoardSetup, source: BoardSource, shadow: Shadow | None, quiet: bool
) -> tuple[Attachment, Path | None]:
    out_dir = request.out_dir
    if out_dir is None and source.live:
        out_dir = Path("runs") / f"{setup.board.name}-attached-{time.strftime('%Y%m%d-%H%M%S')}"
    recording = None if out_dir is None else BoardRecording(out_dir, setup.manifest(source.name), HOST_PORT)
    try:
        with screen(f"{setup.board.name} on {source.name}", quiet or not source.live) as shown:
            session = BoardSession(source, shadow, recording, shown.show, shown.notice)
            shown.begin(session.decoder)
            with ended_by_signals(session):
                session.run(request.seconds)
            attachment = session.result()
        if recording is not None:
            recording.finish(session.now_ns)
    except BaseException:
        if recording is not None:
            recording.abandon()
        raise
    return attachment, out_dir


def _write(attachment: Attachment, setup: BoardSetup, json_to: str | None) -> None:
    if json_to is None:
        return
    document: dict[str, Any] = {
        "format": "navtwin-attach-1",
        "kind": "board",
        "board": setup.board.name,
        "profile": setup.profile_name,
        **attachment.to_dict(),
    }
    write_json(document, json_to)


def _tell(
    console: Console, setup: BoardSetup, attachment: Attachment, out_dir: Path | None, quiet: bool
) -> None:
    line, link = attachment.line, attachment

    def say(text: str, style: str = "") -> None:
        console.print(text, soft_wrap=True, markup=False, style=style)

    if not quiet:
        say(
            f"{attachment.seconds:,.1f} s, {line['bytes_received']:,} bytes: {link.frames:,} frames,"
            f" {link.solutions:,} solutions, {link.raw_frames:,} raw; {link.frames_lost:,} lost,"
            f" {link.bad_crc:,} with a wrong CRC, {link.garbage_bytes:,} bytes of garbage"
        )
        if line.get("port_losses"):
            say(
                f"the port vanished {line['port_losses']} times and came back {line['port_reopenings']} times"
            )
    if attachment.shadow is not None:
        _tell_shadow(say, attachment.shadow, quiet)
    if out_dir is not None:
        say(f"recording: {out_dir / 'run.mcap'}")
    name = f"{setup.board.name} {setup.profile_name}"
    if attachment.shadow is None:
        say(f"{name}: recorded, not shadowed")
    elif attachment.compared:
        ok = attachment.ok
        counts = attachment.shadow.counts
        compared = counts.solutions_equal + counts.solutions_different
        word = "every bit equal" if ok else "board and twin differ"
        say(f"{name}: {compared:,} solutions compared, {word}", "bold green" if ok else "bold red")


def _tell_shadow(say: Any, shadow: Shadow, quiet: bool) -> None:
    counts = shadow.counts
    told: set[str] = set()
    for one in shadow.differences:
        if one.what not in told:
            told.add(one.what)
            say(f"first difference in {one.text()}", "red")
    if quiet:
        return
    say(
        f"shadow: {counts.solutions_equal:,} solutions equal, {counts.solutions_different:,} different,"
        f" {counts.solutions_unchecked:,} not compared; {counts.copies_equal:,} copies of the memory equal,"
        f" {counts.copies_different:,} different; {counts.inputs:,} inputs taken"
    )
    if counts.losses:
        say(
            f"lost track {counts.losses} times ({counts.inputs_missing:,} inputs missing), in step again by"
            f" {counts.joined} copies and {counts.starts} starts; now {shadow.phase.value}"
        )
    elif not shadow.in_step:
        say(f"shadow: {shadow.phase.value}")


def _verdict(attachment: Attachment, request: BoardRequest) -> int:
    if not attachment.frames:
        received = attachment.line["bytes_received"]
        what = f"{received:,} bytes came and not one frame of our link" if received else "nothing came"
        raise UserError(f"--port {request.port}: {what}")
    if attachment.shadow is not None and not attachment.compared:
        why = (
            f"{attachment.shadow.phase.value} when it ended"
            if attachment.raw_frames
            else "the board sends no raw frames (profile key raw_output)"
        )
        raise UserError(f"--port {request.port}: nothing could be compared: {why}; see --no-shadow")
    return EXIT_MET if attachment.ok else EXIT_NOT_MET
