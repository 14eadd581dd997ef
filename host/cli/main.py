"""Entry point of the command `navtwin`. Heavy libraries are imported inside the commands only."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from host.cli.allan_command import allan_command
from host.cli.attach_command import app as attach_app
from host.cli.attitude_command import attitude_command
from host.cli.baseline_command import app as baseline_app
from host.cli.build_command import build_command
from host.cli.calibrate_command import calibrate_command
from host.cli.campaign_command import Baseline, Tolerance, campaign_command
from host.cli.capture_command import app as capture_app
from host.cli.compare_command import compare_command
from host.cli.diff_command import diff_command
from host.cli.evaluate_command import evaluate_command
from host.cli.exit_codes import EXIT_INTERRUPTED, UsageError, guarded, told_usage
from host.cli.faults_command import faults_command
from host.cli.import_command import import_command
from host.cli.inverse_command import inverse_command
from host.cli.monitor_command import monitor_command
from host.cli.new_command import app as new_app
from host.cli.pil_command import pil_command
from host.cli.plain_text import PLAINLY
from host.cli.proof_command import proof_command
from host.cli.replay_command import replay_command
from host.cli.run_options import BoardName, Data, Figures, NoCapture, ProfileName, ScenarioName, Seed
from host.cli.serve_command import EPILOG as SERVE_EPILOG
from host.cli.serve_command import serve_command
from host.cli.simulate_command import simulate_command
from host.cli.sweep_command import sweep_command
from host.cli.table_command import app as table_app
from host.cli.waves_command import waves_command

EXAMPLES = (
    ("navtwin boards", "what there is to run"),
    ("navtwin run car_mems", "the board's own scenario"),
    ("navtwin run car_mems --scenario outages --seed 7", "another one, other noise"),
    ("navtwin run car_mems --set gnss.latency_s=0.1", "with one value changed"),
    ("navtwin run car_mems -s ./drive.toml --json - -q", "your own, for a program"),
    ("navtwin campaign car_mems --seeds 1-200", "many runs, and their spread"),
)
EPILOG = "\n".join(
    ["\b", "Examples:"]
    + [f"  {command:<50}{purpose}" for command, purpose in EXAMPLES]
    + ["", "\b", "Ends with 0: expectations met, 1: not met, 2: bad input,"]
    + ["          3: the run failed, 130: interrupted."]
)

app = typer.Typer(
    name="navtwin",
    help="Runs the firmware of GNSS/INS navigation boards on emulated chips in virtual time.",
    epilog=EPILOG,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(new_app, name="new")


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"navtwin {version('navtwin')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


@app.command("boards")
def boards_command(
    json: Annotated[bool, typer.Option("--json", help="As JSON, for programs.")] = False,
) -> None:
    """List boards, chips, profiles and scenarios."""

    def command() -> int:
        from host.cli.boards_command import list_boards

        return list_boards(as_json=json)

    guarded(command)


@app.command("run", epilog=EPILOG)
def run_command(
    board: BoardName,
    scenario: ScenarioName = None,
    profile: ProfileName = None,
    seed: Seed = 1,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change one value: of the scenario (gnss.latency_s=0.1), the board "
            "(board.pins.timepulse.wired=false) or the profile (profile.aiding=false). May be repeated.",
        ),
    ] = None,
    data: Data = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            help="Report, solution, capture. Default: runs/BOARD-SCENARIO-PROFILE-SEED.",
        ),
    ] = None,
    json: Figures = None,
    junit: Annotated[
        Path | None, typer.Option("--junit", metavar="FILE", help="Expectations as JUnit XML, for CI.")
    ] = None,
    markdown: Annotated[
        Path | None, typer.Option("--markdown", metavar="FILE", help="A summary for the page of a merge.")
    ] = None,
    baseline: Baseline = None,
    tolerance: Tolerance = "5%",
    no_capture: NoCapture = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no tables.")] = False,
) -> None:
    """Run a board through a scenario and judge it.

    Writes report.html, solution.csv, run.mcap and the figures into the folder --out.
    """

    def command() -> int:
        from host.cli.run_command import Outputs, execute
        from host.record.result import RunRequest

        request = RunRequest(
            board=board,
            scenario=scenario,
            profile=profile,
            seed=seed,
            overrides=tuple(changes or ()),
            data_dir=data,
            out_dir=out,
            capture=not no_capture,
        )
        return execute(request, Outputs(json, junit, markdown, quiet, baseline, tolerance))

    guarded(command)


app.command("campaign")(campaign_command)
app.command("sweep")(sweep_command)
app.command("faults")(faults_command)
app.add_typer(baseline_app, name="baseline")
app.add_typer(capture_app, name="capture")
app.add_typer(attach_app, name="attach")
app.command("import")(import_command)
app.command("replay")(replay_command)
app.command("diff")(diff_command)
app.command("waves")(waves_command)
app.command("compare")(compare_command)
app.add_typer(table_app, name="table")
app.command("calibrate")(calibrate_command)
app.command("serve", epilog=SERVE_EPILOG)(serve_command)
app.command("monitor")(monitor_command)
app.command("simulate")(simulate_command)
app.command("inverse")(inverse_command)
app.command("allan")(allan_command)
app.command("evaluate")(evaluate_command)
app.command("proof")(proof_command)
app.command("attitude")(attitude_command)
app.command("build")(build_command)
app.command("pil")(pil_command)


def main() -> None:
    """Run the command line; ends the process with its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=PLAINLY)
    # What ends a job on a CI server is told and kept as an interruption by hand.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        code = app(standalone_mode=False)
    except UsageError as error:
        code = told_usage(error)
    except (KeyboardInterrupt, typer.Abort):
        code = EXIT_INTERRUPTED
    sys.exit(code)


if __name__ == "__main__":
    main()
