"""`navtwin table`: boards beside the tables and figures of their documents."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded, whole_number
from host.cli.simulate_command import NOTHING_KEPT

app = typer.Typer(
    help="Boards beside the tables and figures of their documents.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Arithmetic = Annotated[
    str, typer.Option("--arithmetic", "-a", metavar="NAMES", help="float32, fixed, float64; with commas.")
]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="FILE", help="A page with tables and curves (HTML).")
]
Json = Annotated[
    str | None, typer.Option("--json", metavar="FILE|-", help="Figures as JSON; - is standard output.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No table.")]
Compensation = Annotated[
    str, typer.Option("--compensation", metavar="on|off", help="The board's drift compensation.")
]
Seed = Annotated[int, typer.Option("--seed", parser=whole_number, metavar="N", help="Of all noise.")]


@app.callback()
def _group() -> None:
    """Boards beside the tables and figures of their documents."""


@app.command("angles")
def angles_command(
    axes: Annotated[
        str, typer.Option("--axis", metavar="NAMES", help="Any of pitch, roll, yaw; with commas.")
    ] = "pitch,roll,yaw",
    angles: Annotated[
        str | None, typer.Option("--angle", metavar="DEG", help="These rows only; with commas. Default: all.")
    ] = None,
    feed: Annotated[
        str,
        typer.Option(
            "--feed", metavar="NAMES", help="chip: the whole board; ideal: exact rates; with commas."
        ),
    ] = "chip,ideal",
    arithmetic: Arithmetic = "float32,fixed",
    compensation: Compensation = "on",
    seed: Seed = 1,
    output: Output = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Turn a rotary table to each angle of the document's tables, and measure as it did.

    Ends with 1 when a row misses its goal: 0.5° by the chip, 0.05° with exact rates.
    """

    def command() -> int:
        from host.cli.table_run import AskedAngles, show_angles

        return show_angles(
            AskedAngles(axes, angles, feed, arithmetic, compensation, seed), output, json, quiet
        )

    guarded(command, NOTHING_KEPT)


@app.command("drift")
def drift_command(
    arithmetic: Arithmetic = "float32,fixed",
    compensation: Compensation = "off,on",
    seeds: Annotated[str, typer.Option("--seeds", metavar="A-B", help="Specimens of the sensor.")] = "1-5",
    output: Output = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Turn fast, stop at yaw +25.8° and rest for 30 s, as the document did to show its drift.

    Ends with 1 when an angle drifts further with the compensation than the document's without any.
    """

    def command() -> int:
        from host.cli.table_run import AskedDrift, show_drift

        return show_drift(AskedDrift(arithmetic, compensation, seeds), output, json, quiet)

    guarded(command, NOTHING_KEPT)


@app.command("cycles")
def cycles_command(
    arithmetic: Annotated[
        str, typer.Option("--arithmetic", "-a", metavar="NAMES", help="float32, fixed; with commas.")
    ] = "float32,fixed",
    updates: Annotated[
        bool, typer.Option("--updates", help="Also what an iteration costs with each update of the attitude.")
    ] = False,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Estimate the cycles of each kernel on the modelled processor, beside the document's 0.35 ms."""

    def command() -> int:
        from host.cli.table_cycles_run import show_cycles

        return show_cycles(arithmetic, updates, json, quiet)

    guarded(command, NOTHING_KEPT)


@app.command("coning")
def coning_command(
    half_angle: Annotated[float, typer.Option("--half-angle", metavar="DEG")] = 1.0,
    frequency: Annotated[float, typer.Option("--frequency", metavar="HZ")] = 10.0,
    duration: Annotated[float, typer.Option("--duration", metavar="S")] = 60.0,
    arithmetic: Arithmetic = "float32,fixed,float64",
    output: Output = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Let every update of the attitude go round a cone, and see how far it drifts."""

    def command() -> int:
        from host.cli.table_run import show_coning

        return show_coning((half_angle, frequency, duration), arithmetic, output, json, quiet)

    guarded(command, NOTHING_KEPT)


@app.command("rates")
def rates_command(
    arm: Annotated[float, typer.Option("--arm", metavar="M", help="Length of the arms.")] = 0.25,
    duration: Annotated[float, typer.Option("--duration", metavar="S")] = 60.0,
    seeds: Annotated[str, typer.Option("--seeds", metavar="A-B", help="Of noise and clocks.")] = "1-20",
    output: Output = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Angular rate from nine accelerometers by the document's three methods and by ours.

    Ends with 1 when the fused rate is not as good as the best of the three.
    """

    def command() -> int:
        from host.cli.table_gyro_free_run import show_rates

        return show_rates(arm, duration, seeds, output, json, quiet)

    guarded(command, NOTHING_KEPT)


@app.command("federated")
def federated_command(
    duration: Annotated[int, typer.Option("--duration", metavar="S", help="Of each drive.")] = 300,
    seeds: Annotated[str, typer.Option("--seeds", metavar="A-B", help="One drive each.")] = "1-3",
    failures: Annotated[
        bool, typer.Option("--failures/--no-failures", help="Also drives on which a sensor fails.")
    ] = True,
    board: Annotated[
        bool, typer.Option("--board", help="Also the board itself, on drives on which a sensor fails.")
    ] = False,
    output: Output = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Compass filter, GPS filter and their federation in four modes, on the document's chapter 5.

    Ends with 1 when a goal is missed.
    """

    def command() -> int:
        from host.cli.table_gyro_free_run import show_federated

        return show_federated(duration, seeds, failures, board, output, json, quiet)

    guarded(command, NOTHING_KEPT)


@app.command("arms")
def arms_command(
    arms: Annotated[str, typer.Option("--arms", metavar="M,M,…", help="Lengths.")] = "0.1,0.25,0.5,1,2",
    seed: Seed = 1,
    output: Output = None,
    json: Json = None,
    quiet: Quiet = False,
) -> None:
    """Arm lengths of gfsins with real accelerometers: rate, attitude, and drives without compass or GPS."""

    def command() -> int:
        from host.cli.table_arms_run import show_arms

        return show_arms(arms, seed, output, json, quiet)

    guarded(command, NOTHING_KEPT)


@app.command("antennas")
def antennas_command(seed: Seed = 1, output: Output = None, json: Json = None, quiet: Quiet = False) -> None:
    """Heading of dual_antenna with and without its second antenna, at rest and on the road; its gyro-compass.

    Ends with 1 when the heading with it is worse than 0.08° or than the receiver's own.
    """

    def command() -> int:
        from host.cli.table_antennas_run import show_antennas

        return show_antennas(seed, output, json, quiet)

    guarded(command, NOTHING_KEPT)
