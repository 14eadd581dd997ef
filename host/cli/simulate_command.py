"""`navtwin simulate`: what a vehicle's sensors feel, as files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded, whole_number

NOTHING_KEPT = "interrupted; nothing was kept"


def simulate_command(
    scenario: Annotated[
        str, typer.Argument(metavar="SCENARIO", help="A file, or the name of one that comes with a board.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="Left out: generate only, for its speed."),
    ] = None,
    form: Annotated[
        str | None,
        typer.Option(
            "--format", "-f", metavar="NAME", help="csv, npz, mcap, kf-gins, pyins. Default: by the ending."
        ),
    ] = None,
    rate: Annotated[
        str, typer.Option("--rate", metavar="HZ", help="Of the inertial sensor, e.g. 819.2.")
    ] = "200",
    gnss_rate: Annotated[str, typer.Option("--gnss-rate", metavar="HZ", help="0: no receiver.")] = "1",
    samples: Annotated[
        str | None,
        typer.Option(
            "--samples", metavar="KIND", help="instant, mean or increment (since the sample before)."
        ),
    ] = None,
    antenna: Annotated[
        str, typer.Option("--antenna", metavar="X,Y,Z", help="Lever arm forward, right, down, m.")
    ] = "0,0,0",
    second_antenna: Annotated[
        str | None,
        typer.Option("--second-antenna", metavar="X,Y,Z", help="Of a receiver that measures the baseline."),
    ] = None,
    imu_at: Annotated[
        str, typer.Option("--imu-at", metavar="X,Y,Z", help="Lever arm of the inertial sensor, m.")
    ] = "0,0,0",
    mounting: Annotated[
        str, typer.Option("--mounting", metavar="YAW,PITCH,ROLL", help="Of its axes in the body, °.")
    ] = "0,0,0",
    mag_rate: Annotated[str, typer.Option("--mag-rate", metavar="HZ", help="Magnetometer; 0: none.")] = "0",
    baro_rate: Annotated[str, typer.Option("--baro-rate", metavar="HZ", help="Barometer; 0: none.")] = "0",
    seed: Annotated[int, typer.Option("--seed", parser=whole_number, metavar="N")] = 1,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Changes the scenario, e.g. imu.preset=perfect."),
    ] = None,
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="Figures as JSON; - is standard output.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Simulate a scenario's sensors without a board: inertial samples, truth, receiver epochs.

    Streamed in blocks, so that a day takes no more memory than a minute. Files appear when they are whole.
    """

    def command() -> int:
        from host.cli.simulate_run import Asked, Places, Rates, execute

        rates = Rates(rate, gnss_rate, mag_rate, baro_rate)
        places = Places(antenna, second_antenna, imu_at, mounting)
        asked = Asked(scenario, output, form, rates, samples, places, seed, tuple(changes or ()))
        return execute(asked, json, quiet)

    guarded(command, NOTHING_KEPT)
