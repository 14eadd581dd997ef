"""What `navtwin simulate` does: understand, generate, write, tell."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from boards.hints import did_you_mean
from boards.places import board_folder, board_names
from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import check_files
from host.cli.terminal import progress_bar, standard_error, standard_output
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.report.numbers import number
from host.sim.gnss.faults import GNSS_FAULT_KINDS
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.load import load_scenario
from host.sim.scenario.schema import Scenario
from host.sim.seeding import LARGEST_SEED
from host.simulate.drives import DRIVES
from host.simulate.formats.known import Format, chosen
from host.simulate.job import Simulated, simulate
from host.simulate.stream import Convention, Drive, Request, warm_up

RESULT_FORMAT = "navtwin-simulation-1"
LARGEST_RATE_HZ = 100_000
SLOWEST_HZ = Fraction(1, 3600)
LONGEST_LEVER_M = 100.0
MOST_STEPS_TOLD = 1000


@dataclass(frozen=True, slots=True)
class Rates:
    """Those words that are rates in Hz."""

    imu: str
    gnss: str
    magnetometer: str
    barometer: str


@dataclass(frozen=True, slots=True)
class Places:
    """Where things sit in the body, as words."""

    antenna: str
    second_antenna: str | None
    sensor: str
    mounting: str


@dataclass(frozen=True, slots=True)
class Asked:
    """The words of the command line."""

    scenario: str
    output: Path | None
    form: str | None
    rates: Rates
    samples: str | None
    places: Places
    seed: int
    changes: tuple[str, ...]


def execute(asked: Asked, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError, ScenarioError."""
    if asked.output is None and asked.form is not None:
        raise UserError(f"--format {asked.form}: needs a file to write; for example -o drive.csv")
    form = None if asked.output is None else chosen(asked.form, asked.output)
    request = _request(asked, form)
    check_files(("-o", asked.output), ("--json", json_file), read=request.scenario.path)
    left_out = _faults_left_out(request.scenario)
    drive = Drive(request)
    about = _about(asked, request, drive)
    warm_up(request)
    with progress_bar(f"simulate {request.scenario.name}", quiet) as progress:
        done = simulate(drive, asked.output, form, about, progress)
    _tell(about, done, left_out, json_file)
    return EXIT_MET


def scenario_file(name: str) -> Path:
    """A file by its path, or a drive of the simulator or scenario of any board by its name. UserError."""
    path = Path(name)
    if path.suffix == ".toml" or path.parent != Path():
        if not path.is_file():
            raise UserError(f"{name}: no such scenario file; for example navtwin simulate ./drive.toml")
        return path
    known = {file.stem: file for file in sorted(DRIVES.glob("*.toml"))}
    for board in reversed(board_names()):
        known |= {file.stem: file for file in sorted((board_folder(board) / "scenarios").glob("*.toml"))}
    if name not in known:
        raise UserError(
            f"{name}: no board has such a scenario; {did_you_mean(name, known)} (a file of your own is given"
            " by its path, e.g. ./drive.toml)"
        )
    return known[name]


def _request(asked: Asked, form: Format | None) -> Request:
    scenario = load_scenario(scenario_file(asked.scenario), asked.changes)
    if scenario.kind != "simulated":
        raise UserError(
            f"{asked.scenario}: is a recording, whose sensors are measured, not simulated; name a scenario"
            " with motion, e.g. town-open"
        )
    if not 0 <= asked.seed <= LARGEST_SEED:
        raise UserError(f"--seed {asked.seed}: must lie in 0 … {LARGEST_SEED}; for example --seed 1")
    second = asked.places.second_antenna
    magnetometer_hz = rate_of("--mag-rate", asked.rates.magnetometer, least=Fraction(0))
    barometer_hz = rate_of("--baro-rate", asked.rates.barometer, least=Fraction(0))
    return Request(
        scenario=scenario,
        seed=asked.seed,
        rate_hz=rate_of("--rate", asked.rates.imu, least=SLOWEST_HZ),
        gnss_rate_hz=rate_of("--gnss-rate", asked.rates.gnss, least=Fraction(0)),
        convention=convention_of(asked.samples, form),
        antenna_m=lever_of("--antenna", asked.places.antenna),
        sensor_m=lever_of("--imu-at", asked.places.sensor),
        mounting_rad=mounting_of(asked.places.mounting),
        second_antenna_m=None if second is None else lever_of("--second-antenna", second),
        magnetometer_hz=magnetometer_hz,
        barometer_hz=barometer_hz,
    )


def _faults_left_out(scenario: Scenario) -> list[str]:
    """Names of those that strike buses and chips, which only a board has. ScenarioError for unknown kinds."""
    if not scenario.fault:
        return []
    from host.run.fault_kinds import KINDS

    for fault in scenario.fault:
        if fault.kind not in (*KINDS, *GNSS_FAULT_KINDS):
            raise ScenarioError(
                f"{scenario.path or scenario.name}: fault {fault.name!r}: no kind of fault {fault.kind!r};"
                f" {did_you_mean(fault.kind, [*KINDS, *GNSS_FAULT_KINDS])}"
            )
    return [str(fault.name) for fault in scenario.fault if fault.kind not in GNSS_FAULT_KINDS]


def rate_of(option: str, text: str, least: Fraction) -> Fraction:
    """A rate in Hz. Raises UserError."""
    try:
        rate = Fraction(text)
    except (ValueError, ZeroDivisionError):
        raise UserError(f"{option} {text}: is not a number of Hz; for example {option} 819.2") from None
    small = rate != 0 and rate < SLOWEST_HZ
    if rate < least or small or rate > LARGEST_RATE_HZ or rate.denominator > 10**6:
        raise UserError(
            f"{option} {text}: must lie in {float(least):g} … {LARGEST_RATE_HZ} Hz; for example {option} 100"
        )
    return rate


def convention_of(text: str | None, form: Format | None) -> Convention:
    """What samples stand for; left out, what is usual in the format. Raises UserError."""
    if text is None:
        return Convention.INSTANT if form is None else form.usual
    if text not in list(Convention):
        raise UserError(
            f"--samples {text}: no such kind; {did_you_mean(text, [kind.value for kind in Convention])}"
        )
    wanted = Convention(text)
    if form is not None and form.only not in (None, wanted):
        raise UserError(f"--samples {text}: this format holds {form.only}s only; leave --samples out")
    return wanted


def lever_of(option: str, text: str) -> tuple[float, float, float]:
    """Three lengths in m. Raises UserError."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise UserError(f"{option} {text}: must be three lengths in m; e.g. {option} 0.5,0,-1.2") from None
    if not all(math.isfinite(value) and abs(value) <= LONGEST_LEVER_M for value in (x, y, z)):
        raise UserError(f"{option} {text}: each must lie within ±{LONGEST_LEVER_M:g} m; e.g. 0.5,0,-1.2")
    return x, y, z


def mounting_of(text: str) -> tuple[float, float, float]:
    """Yaw, pitch, roll in rad. Raises UserError."""
    example = "must be yaw, pitch, roll in °, within ±360, 90, 180; e.g. --mounting 90,0,180"
    try:
        angles = [float(part) for part in text.split(",")]
    except ValueError:
        angles = []
    if len(angles) != 3 or not all(abs(x) <= most for x, most in zip(angles, (360, 90, 180), strict=True)):
        raise UserError(f"--mounting {text}: {example}")
    yaw, pitch, roll = (math.radians(angle) for angle in angles)
    return yaw, pitch, roll


def _about(asked: Asked, request: Request, drive: Drive) -> dict[str, Any]:
    """What made the files; it repeats with them."""
    return {
        "format": RESULT_FORMAT,
        "scenario": request.scenario.name,
        "seed": request.seed,
        "overrides": list(asked.changes),
        "samples_are": str(request.convention),
        "rate_hz": float(request.rate_hz),
        "gnss_rate_hz": float(request.gnss_rate_hz),
        "magnetometer_rate_hz": float(request.magnetometer_hz),
        "barometer_rate_hz": float(request.barometer_hz),
        "antenna_m": list(request.antenna_m),
        "second_antenna_m": request.second_antenna_m,
        "imu_at_m": list(request.sensor_m),
        "mounting_deg": [math.degrees(angle) for angle in request.mounting_rad],
        "start_utc": request.scenario.start.utc,
        "samples": drive.samples,
        "gnss_epochs": drive.epochs,
        "duration_s": drive.duration_ns / 1e9,
        "joints": _joints(drive),
    }


def _joints(drive: Drive) -> dict[str, Any]:
    """Where the path's acceleration and rates step, as the numeric form does by definition."""
    found = drive.joints()
    return {
        "steps": [asdict(step) for step in found.steps[:MOST_STEPS_TOLD]],
        "number_of_steps": len(found.steps),
        "largest_jerk_mps3": found.largest_jerk_mps3,
    }


def _tell(about: dict[str, Any], done: Simulated, left_out: list[str], json_file: str | None) -> None:
    files = [str(path) for path in done.files]
    console = standard_error() if json_file == "-" else standard_output()
    rate = number(done.samples_per_s)
    console.print(f"{done.samples:,} samples in {number(done.wall_s)} s: {rate} a second", soft_wrap=True)
    steps = about["joints"]["number_of_steps"]
    if steps:
        kinds = ", ".join(sorted({step["what"] for step in about["joints"]["steps"]}))
        console.print(
            f"the path steps at {steps} joints ({kinds}); blend_s makes them smooth", soft_wrap=True
        )
    if left_out:
        console.print(f"left out, as only boards have buses and chips: {', '.join(left_out)}", soft_wrap=True)
    if files:
        console.print(f"written: {'  '.join(files)}", soft_wrap=True)
    if json_file is None:
        return
    figures = {"wall_s": done.wall_s, "samples_per_s": done.samples_per_s, "files": files}
    text = json.dumps(about | figures, indent=1) + "\n"
    if json_file == "-":
        print(text, end="")
    else:
        write_whole(Path(json_file), text, "--json")
