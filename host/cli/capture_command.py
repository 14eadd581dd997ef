"""`navtwin capture`: look at captures, check, cut, export and repair them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import NOTHING_WRITTEN, guarded

app = typer.Typer(
    help="Look at captures, check, cut, export and repair them.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Capture = Annotated[
    Path, typer.Argument(metavar="CAPTURE", help="run.mcap, run.mcap.part, or the folder of a run.")
]
Json = Annotated[
    str | None, typer.Option("--json", metavar="FILE|-", help="The same as JSON; - is standard output.")
]


@app.callback()
def _group() -> None:
    """Look at captures, check, cut, export and repair them."""


@app.command("info")
def info_command(capture: Capture, json: Json = None) -> None:
    """What was captured: board, scenario, topics, times."""

    def command() -> int:
        from host.cli.capture_run import show_info

        return show_info(capture, json)

    guarded(command, NOTHING_WRITTEN)


@app.command("check")
def check_command(capture: Capture, json: Json = None) -> None:
    """What is missing or wrong. Ends with 0: nothing, 1: something, 2: not a capture."""

    def command() -> int:
        from host.cli.capture_run import show_check

        return show_check(capture, json)

    guarded(command, NOTHING_WRITTEN)


@app.command("cut")
def cut_command(
    capture: Capture,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="The new capture.")],
    begin: Annotated[float, typer.Option("--from", metavar="S", help="Virtual time, s.")] = 0.0,
    end: Annotated[float, typer.Option("--to", metavar="S", help="Virtual time, s; not included.")] = 1e9,
) -> None:
    """A stretch of a capture as a capture of its own."""

    def command() -> int:
        from host.cli.capture_run import make_cut

        return make_cut(capture, output, begin, end)

    guarded(command, NOTHING_WRITTEN)


@app.command("export")
def export_command(
    capture: Capture,
    kind: Annotated[
        str, typer.Option("--format", "-f", metavar="KIND", help="csv, parquet, nmea, candump or vcd.")
    ],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="PLACE", help="csv, parquet: a folder; otherwise a file."),
    ],
    topic: Annotated[
        str | None, typer.Option("--topic", metavar="TOPIC", help="Only this one, e.g. /uart/gnss/rx.")
    ] = None,
) -> None:
    """A capture in the formats of other tools."""

    def command() -> int:
        from host.cli.capture_run import make_export

        return make_export(capture, kind, output, topic)

    guarded(command, NOTHING_WRITTEN)


@app.command("repair")
def repair_command(
    capture: Capture,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="The new capture.")],
) -> None:
    """A capture that was cut off, with the decoded rows that it lacks and an index for other tools."""

    def command() -> int:
        from host.cli.capture_run import make_repair

        return make_repair(capture, output)

    guarded(command, NOTHING_WRITTEN)
