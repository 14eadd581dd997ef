"""`navtwin inverse`: the inertial measurements that belong to a trajectory."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from host.cli.exit_codes import guarded, whole_number
from host.cli.simulate_command import NOTHING_KEPT


def inverse_command(
    trajectory: Annotated[
        Path, typer.Argument(metavar="TRAJECTORY", help=".csv, .gpx, .kml, .nmea, .npz or .mcap.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Left out: figures only.")
    ] = None,
    form: Annotated[
        str | None,
        typer.Option("--format", "-f", metavar="NAME", help="csv, npz, mcap, kf-gins, pyins; by the ending."),
    ] = None,
    rate: Annotated[str, typer.Option("--rate", metavar="HZ", help="Of the increments.")] = "200",
    samples: Annotated[
        str, typer.Option("--samples", metavar="KIND", help="increment, or mean (increment over time).")
    ] = "increment",
    smooth: Annotated[
        str | None,
        typer.Option(
            "--smooth",
            metavar="M",
            help="1 σ of the points, m. Default: 1 for GPX, KML, NMEA and solutions of a board, else 0.",
        ),
    ] = None,
    bank: Annotated[bool, typer.Option("--bank", help="Lean into turns, as aircraft do.")] = False,
    speed: Annotated[
        str | None, typer.Option("--speed", metavar="M/S", help="For a KML LineString, which has no times.")
    ] = None,
    max_gap: Annotated[
        str, typer.Option("--max-gap", metavar="S", help="Points further apart are an error.")
    ] = "30",
    gnss_rate: Annotated[
        str, typer.Option("--gnss-rate", metavar="HZ", help="Of a receiver along the way; 0: none.")
    ] = "0",
    antenna: Annotated[
        str, typer.Option("--antenna", metavar="X,Y,Z", help="Of the receiver: forward, right, down, m.")
    ] = "0,0,0",
    imu_at: Annotated[
        str, typer.Option("--imu-at", metavar="X,Y,Z", help="Of the inertial sensor, from the points on, m.")
    ] = "0,0,0",
    mounting: Annotated[
        str, typer.Option("--mounting", metavar="YAW,PITCH,ROLL", help="Of its axes in the body, °.")
    ] = "0,0,0",
    preset: Annotated[
        str, typer.Option("--preset", "-p", metavar="NAME", help="Errors of the inertial sensor.")
    ] = "perfect",
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Errors: imu.…, gnss.…, outage=[…], as in scenarios."
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", parser=whole_number, metavar="N")] = 1,
    json: Annotated[
        str | None, typer.Option("--json", metavar="FILE|-", help="Figures as JSON; - is standard output.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Find what inertial sensors measure along a trajectory, with the matching reference.

    Without errors, or with those of a --preset and of --set; with --gnss-rate a receiver too.
    Points of a receiver are smoothed into motion that a vehicle can make; attitude comes from the motion
    where the file has none. Tells how well a forward mechanization of the result closes.
    """

    def command() -> int:
        from host.cli.inverse_run import Asked, Errors, Sensors, execute

        errors = Errors(preset, tuple(changes or ()), seed)
        sensors = Sensors(gnss_rate, antenna, imu_at, mounting, errors)
        asked = Asked(trajectory, output, form, rate, samples, smooth, bank, speed, max_gap, sensors)
        return execute(asked, json, quiet)

    guarded(command, NOTHING_KEPT)
