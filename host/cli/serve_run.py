"""What `navtwin serve` does and prints."""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import FrameType

from rich.live import Live
from rich.text import Text

from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.run_command import check_data, with_folder
from host.cli.terminal import print_result, print_verdict, standard_error
from host.record.errors import UserError
from host.record.result import RunRequest, RunResult
from host.serve.endpoint import Tell
from host.serve.service import Service, Wanted, figures_of, opened
from host.serve.status import line_of

LONGEST_S = 1e7
"""Of a scenario: 116 days, which is endless enough."""
PRIORITY = 10


@dataclass(frozen=True, slots=True)
class ServeOutputs:
    """Where figures go, and how."""

    json: str | None
    quiet: bool
    realtime: bool


def duration_changes(asked: str | None) -> tuple[str, ...]:
    """`--duration` as a change of the scenario. Raises UserError."""
    if asked is None:
        return ()
    try:
        seconds = LONGEST_S if asked == "endless" else float(asked)
    except ValueError:
        seconds = math.nan
    if not 0.0 < seconds <= LONGEST_S:
        raise UserError(
            f"--duration {asked}: is neither a number of seconds in 0 … {LONGEST_S:g} nor endless;"
            " for example --duration 3600"
        )
    return (f"duration_s={seconds!r}",)


def serve(request: RunRequest, wanted: Wanted, outputs: ServeOutputs) -> int:
    """Serve until the end, or until it is stopped. Returns the exit code. Raises UserError."""
    if not 0.0 < wanted.stall_s < math.inf:
        raise UserError(f"--stall {wanted.stall_s:g}: is no positive number of seconds; e.g. --stall 10")
    check_data(request.data_dir)
    check_files(("--json", outputs.json))
    request = _in_own_folder(request)
    error = standard_error()
    with _shown(outputs.quiet) as live:
        console = error if live is None else live.console

        def tell(line: str) -> None:
            console.print(Text(line), soft_wrap=True)

        def look_around(service: Service) -> None:
            if live is not None:
                live.update(Text(line_of(service), no_wrap=True, overflow="ellipsis"), refresh=True)

        wanted = replace(wanted, tell=tell, look_around=look_around)
        with opened(replace(request, notice=error.print), wanted) as service:
            if outputs.realtime:
                _ask_for_priority(tell)
            with _ended_by_signals(service):
                result = service.serve()
            stopped = service.paced.stopped
            figures = figures_of(service)
            if not outputs.quiet:
                tell(line_of(service))
    _write({**result.to_dict(), "serve": figures}, outputs)
    return _told(result, outputs, stopped)


def _told(result: RunResult, outputs: ServeOutputs, stopped: bool) -> int:
    """Print the result; a run that was stopped is not judged."""
    console = for_people(outputs.json)
    if not outputs.quiet:
        print_result(console, result)
    if not stopped:
        print_verdict(console, result)
        return EXIT_MET if result.ok else EXIT_NOT_MET
    place = "" if result.out_dir is None else f"; report: {result.out_dir / 'report.html'}"
    console.print(Text(f"stopped after {result.duration_s:,.1f} s of board time{place}"), soft_wrap=True)
    return EXIT_MET


def _write(document: dict[str, object], outputs: ServeOutputs) -> None:
    write_json(document, outputs.json)


def _in_own_folder(request: RunRequest) -> RunRequest:
    """A run of the same name keeps its folder."""
    if request.out_dir is not None:
        return request
    folder = with_folder(request).out_dir
    assert folder is not None
    return replace(request, out_dir=folder.with_name(folder.name + "-served"))


@contextmanager
def _shown(quiet: bool) -> Iterator[Live | None]:
    """A line in the terminal that tells how it goes; nothing when quiet or not in a terminal."""
    console = standard_error()
    if quiet or not console.is_terminal:
        yield None
        return
    with Live(console=console, auto_refresh=False, transient=True) as live:
        yield live


@contextmanager
def _ended_by_signals(service: Service) -> Iterator[None]:
    """Ctrl-C and SIGTERM end the run as its own end does."""

    def stop(_signal: int, _frame: FrameType | None) -> None:
        service.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _ask_for_priority(tell: Tell) -> None:
    try:
        policy = os.SCHED_RR | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(0, policy, os.sched_param(PRIORITY))
    except (AttributeError, OSError) as error:
        tell(f"--realtime: the system does not give real-time priority ({error}); it goes on without")
