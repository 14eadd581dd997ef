"""What `navtwin monitor` does: finds the source, and shows it as the output allows."""

from __future__ import annotations

import dataclasses
import re
import stat
import sys
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from boards.hints import did_you_mean
from boards.places import board_folder, board_names
from boards.validation import DescriptionError
from host.cli.exit_codes import EXIT_MET
from host.cli.terminal import standard_error
from host.monitor.screen import show
from host.monitor.source import Source
from host.monitor.streaming import listen, stream
from host.monitor.view import MonitorView
from host.record.errors import UserError
from host.record.result import RunRequest

DEVICE = re.compile(r"/dev/|COM\d+$|\\\\\.\\")
SIZE = re.compile(r"(\d{1,4})x(\d{1,4})")
DEFAULT_SIZE = (120, 40)
SMALLEST, LARGEST = 20, 1000
LISTEN_TO_PORT_S = 6.0
"""Long enough for what comes every fifth second."""
RUN_BOARD_S = 60.0
TASKS_KEY = "task_frames"


@dataclass(frozen=True)
class MonitorRequest:
    """What to look at."""

    what: str
    baud: int | None = None
    speed: float | None = None
    scenario: str | None = None
    profile: str | None = None
    seed: int | None = None
    overrides: tuple[str, ...] = ()
    data_dir: Path | None = None


def monitor(
    request: MonitorRequest, *, once: bool, as_json: bool, seconds: float | None, size: str | None
) -> int:
    """Show the source until it is left or ends. Ctrl-C is an end like any other. Raises UserError."""
    console = Console(highlight=False, emoji=False)
    picture = _size(size, console)
    once = once or not (as_json or (console.is_terminal and not console.is_dumb_terminal))
    try:
        source = _source(request, once)
    except KeyboardInterrupt:
        return EXIT_MET
    view = MonitorView(source.title)
    try:
        if not once and not as_json:
            show(console, source, view, seconds)
        elif not once:
            stream(source, view, seconds, _print_line)
        else:
            _listen(source, view, seconds)
    except KeyboardInterrupt:
        pass
    finally:
        source.close()
    if once:
        _print_once(view, as_json, picture)
    return EXIT_MET


def _listen(source: Source, view: MonitorView, seconds: float | None) -> None:
    from host.monitor.board_source import BoardSource
    from host.monitor.port_source import PortSource

    if seconds is None:
        seconds = float("inf")
        seconds = LISTEN_TO_PORT_S if isinstance(source, PortSource) else seconds
        seconds = RUN_BOARD_S if isinstance(source, BoardSource) else seconds
    listen(source, view, seconds)


def _print_once(view: MonitorView, as_json: bool, size: tuple[int, int]) -> None:
    from host.monitor.figures import figures_line

    if as_json:
        _print_line(figures_line(view))
        return
    console = Console(width=size[0], height=size[1], highlight=False, emoji=False)
    console.print(view.render(*size), end="")


def _print_line(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _size(size: str | None, console: Console) -> tuple[int, int]:
    if size is None:
        return (console.size.width, console.size.height) if console.is_terminal else DEFAULT_SIZE
    match = SIZE.fullmatch(size)
    if match is None or not all(SMALLEST <= int(part) <= LARGEST for part in match.groups()):
        raise UserError(f"--size {size}: columns x rows, each {SMALLEST} … {LARGEST}; for example 120x40")
    return int(match[1]), int(match[2])


# -- which source is meant -----------------------------------------------------------------------------


def _source(request: MonitorRequest, once: bool) -> Source:
    """Files are captures, known names and folders with a board.toml are boards, all else is a port."""
    path = Path(request.what)
    speed = request.speed if request.speed is not None else (0.0 if once else 1.0)
    if _is_capture(path):
        from host.monitor.capture_source import CaptureSource

        _refuse(request, "a capture", board=True, port=True)
        return CaptureSource(path, speed)
    if _is_board(request.what):
        _refuse(request, "a board", port=True)
        return _board(request, speed)
    if "://" not in request.what and not DEVICE.match(request.what) and not _is_device(path):
        raise UserError(
            f"{request.what!r} is no port, capture or board"
            f" ({did_you_mean(request.what, board_names(), 'boards by name')}); a port is e.g. /dev/ttyUSB0"
            " or socket://127.0.0.1:5760, a capture e.g. runs/first/run.mcap"
        )
    from host.monitor.port_source import PortSource

    _refuse(request, "a port", board=True, played=True)
    return PortSource(request.what, request.baud)


def _is_capture(path: Path) -> bool:
    if path.is_dir():
        return not (path / "board.toml").is_file() and not (path / "pyproject.toml").is_file()
    if path.name == "board.toml":
        return False
    return path.is_file() or path.suffix in (".mcap", ".part")


def _is_device(path: Path) -> bool:
    try:
        return stat.S_ISCHR(path.stat().st_mode)
    except (OSError, ValueError):
        return False


def _is_board(what: str) -> bool:
    path = Path(what)
    if path.exists() and not _is_device(path):
        return True
    try:
        board_folder(what)
    except DescriptionError:
        return False
    return True


def _refuse(
    request: MonitorRequest, kind: str, *, board: bool = False, port: bool = False, played: bool = False
) -> None:
    """Options that mean nothing for this kind of source are told, not ignored."""
    given = {
        "--scenario": board and request.scenario,
        "--profile": board and request.profile,
        "--seed": board and request.seed is not None,
        "--set": board and request.overrides,
        "--baud": port and request.baud,
        "--speed": played and request.speed is not None,
    }
    for option, wrong in given.items():
        if wrong:
            raise UserError(f"{option} means nothing here: {request.what} is {kind}; leave it away")


def _board(request: MonitorRequest, speed: float) -> Source:
    from host.monitor.board_source import BoardSource
    from host.run.readiness import user_errors
    from host.run.setup import resolve

    run = RunRequest(
        board=request.what,
        scenario=request.scenario,
        profile=request.profile,
        seed=1 if request.seed is None else request.seed,
        overrides=request.overrides,
        data_dir=request.data_dir,
        out_dir=None,
        capture=False,
        notice=lambda text: standard_error().print(text, style="dim"),
    )
    with user_errors():
        setup = resolve(run)
    asked = any(change.startswith(f"profile.{TASKS_KEY}") for change in run.overrides)
    if TASKS_KEY in setup.profile and not asked:
        run = dataclasses.replace(run, overrides=(*run.overrides, f"profile.{TASKS_KEY}=true"))
    return BoardSource(run, speed)
