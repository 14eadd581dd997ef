"""What `navtwin attach chip` does and prints."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from host.attach.chip_bench import ChipRequest, chip_session
from host.attach.chip_session import ChipSession
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import for_people, write_json
from host.record.errors import UserError

REFRESH_HZ = 4.0


def attach_chip(request: ChipRequest, seconds: float | None, json_to: str | None, quiet: bool) -> int:
    """Attach, print, write; the exit code. Raises UserError for what the user can mend."""
    console = for_people(json_to)
    with _asked_to_end() as stop, chip_session(request) as session:
        found = session.start()
        if found.ok:
            with _screen(console, request, session, quiet):
                session.run(seconds, stop)
    _write(request, session, json_to)
    if not quiet and session.statistics.count:
        console.print(_table(session))
        console.print(_closing_line(session), soft_wrap=True)
    if request.record is not None:
        console.print(f"record: {request.record}", soft_wrap=True, markup=False)
    if session.state.ok:
        return EXIT_MET
    wiring = "; is it wired, and has it power?" if session.state.absent else ""
    print(
        f"navtwin: {request.chip} on {request.port} ({request.bus_text}): {session.state.text}{wiring}",
        file=sys.stderr,
    )
    return EXIT_NOT_MET


def whole_address(text: str | None) -> int | None:
    """The value of --address. Raises UserError."""
    if text is None:
        return None
    try:
        return int(text, 16)
    except ValueError:
        raise UserError(f"--address {text}: not a hexadecimal number; for example 0x68") from None


@contextmanager
def _asked_to_end() -> Iterator[Callable[[], bool]]:
    """Ctrl-C and SIGTERM let the transaction under way finish, the second one does not."""
    asked = threading.Event()

    def ask(number: int, frame: FrameType | None) -> None:
        if asked.is_set():
            signal.default_int_handler(number, frame)
        asked.set()

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield asked.is_set
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _screen(console: Console, request: ChipRequest, session: ChipSession, quiet: bool) -> Iterator[None]:
    """A table that changes as samples come, in a terminal; otherwise nothing until the end.

    It is drawn by a thread of its own, since drawing takes longer than the time between two samples.
    """
    title = f"{request.chip} on {request.port} ({request.bus_text}), {session.state.text}"
    if not quiet:
        console.print(title, soft_wrap=True, markup=False, style="bold")
    if quiet or not console.is_terminal:
        yield
        return

    def picture() -> Group:
        return Group(_table(session), _closing_line(session), Text("Ctrl-C ends", style="dim"))

    with Live(console=console, get_renderable=picture, refresh_per_second=REFRESH_HZ, transient=True):
        yield


def _table(session: ChipSession) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    for name in ("now", "mean", "noise 1 σ", "lowest", "highest"):
        table.add_column(name, justify="right")
    table.add_column("")
    statistics = session.statistics
    for at, quantity in enumerate(session.chip.quantities):
        values = (
            statistics.last[at],
            statistics.mean[at],
            statistics.noise[at],
            statistics.lowest[at],
            statistics.highest[at],
        )
        table.add_row(quantity.name, *(f"{value * quantity.factor:.4f}" for value in values), quantity.unit)
    return table


def _closing_line(session: ChipSession) -> Text:
    parts = [f"{session.elapsed_s:,.1f} s: {session.statistics.count:,} samples, {session.missed:,} missed"]
    if session.rate_hz is not None:
        parts.append(f"{session.rate_hz:,.2f} Hz")
    if session.clock_error is not None:
        parts.append(f"chip's clock {100.0 * session.clock_error:+.2f} %")
    if session.temperature is not None:
        parts.append(f"{session.temperature:.1f} °C")
    if session.live:
        parts.append(f"{session.exchanges_per_s:,.0f} transactions/s")
    text = Text(", ".join(parts))
    if session.restarts:
        text.append(f", set up anew {session.restarts} ×", "yellow")
    if not session.state.ok:
        text.append(f"\n{session.state.text}", "bold red")
    return text


def _write(request: ChipRequest, session: ChipSession, json_to: str | None) -> None:
    if json_to is None:
        return
    document = {
        "format": "navtwin-attach-1",
        "kind": "chip",
        "chip": request.chip,
        "port": request.port,
        "bus": request.bus,
        **session.report(),
    }
    write_json(document, json_to)
