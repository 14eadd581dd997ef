"""What `navtwin inverse` does: read, smooth, invert, write, tell how well it closes."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from boards.hints import did_you_mean
from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import check_files
from host.cli.simulate_run import SLOWEST_HZ, convention_of, lever_of, mounting_of, rate_of
from host.cli.terminal import progress_bar, standard_error, standard_output
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.report.numbers import number
from host.sim.errors.presets import preset_names
from host.sim.scenario.load import scenario_from
from host.sim.scenario.overrides import apply_overrides
from host.sim.scenario.schema import Scenario, Start
from host.sim.seeding import LARGEST_SEED
from host.simulate.extras import must_have
from host.simulate.formats.known import chosen
from host.simulate.places import Places
from host.simulate.stream import Convention
from host.simulate.tracks.known import read_track
from host.simulate.tracks.track import Track

if TYPE_CHECKING:
    from host.simulate.inverse import Inverse, Inverted

RESULT_FORMAT = "navtwin-inverse-1"
RECEIVER_SIGMA_M = 1.0
LARGEST_SIGMA_M = 1000.0
LONGEST_GAP_S = 1e6
FASTEST_MPS = 3000.0
STRONGEST_MPS2 = 1000.0
ERROR_TABLES = ("imu", "gnss", "outage")


@dataclass(frozen=True, slots=True)
class Errors:
    """Those words that are about errors of sensors."""

    preset: str
    changes: tuple[str, ...]
    seed: int

    def scenario(self) -> Scenario:
        """What they say, as a scenario says it. Raises UserError, ScenarioError."""
        if self.preset not in preset_names():
            raise UserError(
                f"--preset {self.preset}: no such preset; {did_you_mean(self.preset, preset_names())}"
            )
        for change in self.changes:
            if change.partition("=")[0].strip().partition(".")[0] not in ERROR_TABLES:
                raise UserError(
                    f"--set {change}: not about a sensor's errors; here {', '.join(ERROR_TABLES)} can be set,"
                    " for example --set gnss.position_white_m=0.02"
                )
        if not 0 <= self.seed <= LARGEST_SEED:
            raise UserError(f"--seed {self.seed}: must lie in 0 … {LARGEST_SEED}; for example --seed 1")
        data = {"place": {"latitude_deg": 0.0, "longitude_deg": 0.0}, "duration_s": 1.0}
        whole = apply_overrides({**data, "imu": {"preset": self.preset}}, self.changes)
        return scenario_from(whole, "errors", "--set")


@dataclass(frozen=True, slots=True)
class Sensors:
    """Those words that are about sensors."""

    gnss_rate: str
    antenna: str
    imu_at: str
    mounting: str
    errors: Errors

    def places(self) -> Places:
        """Where they sit. Raises UserError."""
        return Places(
            lever_of("--antenna", self.antenna), lever_of("--imu-at", self.imu_at), mounting_of(self.mounting)
        )


@dataclass(frozen=True, slots=True)
class Asked:
    """The words of the command line."""

    trajectory: Path
    output: Path | None
    form: str | None
    rate: str
    samples: str
    smooth: str | None
    bank: bool
    speed: str | None
    max_gap: str
    sensors: Sensors


def execute(asked: Asked, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    if asked.output is None and asked.form is not None:
        raise UserError(f"--format {asked.form}: needs a file to write; for example -o drive.csv")
    form = None if asked.output is None else chosen(asked.form, asked.output)
    convention = convention_of(asked.samples, form)
    if convention is Convention.INSTANT:
        raise UserError(
            "--samples instant: the inverse finds what lies between two instants; increment or mean"
        )
    rate = rate_of("--rate", asked.rate, SLOWEST_HZ)
    gap = _number("--max-gap", asked.max_gap, LONGEST_GAP_S, "30")
    speed = None if asked.speed is None else _number("--speed", asked.speed, FASTEST_MPS, "10")
    scenario = asked.sensors.errors.scenario()
    gnss_rate = rate_of("--gnss-rate", asked.sensors.gnss_rate, least=Fraction(0))
    places = asked.sensors.places()
    check_files(("-o", asked.output), ("--json", json_file), read=asked.trajectory)
    must_have("scipy", "navtwin inverse")
    from host.simulate.flyable import Flyable
    from host.simulate.inverse import Inverse, invert_track
    from host.simulate.sensors import TrackSensors

    track = read_track(asked.trajectory, gap, speed)
    sigma = _sigma(asked, track)
    motion = Flyable(track, sigma, asked.bank)
    start_ns = track.start_gps_ns if track.start_gps_ns is not None else Start().gps_time_ns
    sensors = TrackSensors(scenario, asked.sensors.errors.seed, motion, start_ns, places)
    inverse = Inverse(motion, rate, convention, start_ns, sensors, gnss_rate)
    if inverse.samples < 2:
        raise UserError(
            f"{asked.trajectory}: lasts {motion.end_s:g} s, less than two intervals at --rate {asked.rate}"
        )
    about = _about(asked, track, sigma, inverse)
    with progress_bar(f"inverse {asked.trajectory.name}", quiet) as progress:
        done = invert_track(inverse, asked.output, form, about, progress, asked.trajectory)
    _tell(about, done, json_file)
    return EXIT_MET


def _sigma(asked: Asked, track: Track) -> float:
    if asked.smooth is None:
        return RECEIVER_SIGMA_M if track.noisy else 0.0
    return _number("--smooth", asked.smooth, LARGEST_SIGMA_M, "1.5", zero=True)


def _number(option: str, text: str, largest: float, example: str, zero: bool = False) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0.0 or (zero and value == 0.0)) or value > largest:
        least = "0" if zero else "above 0"
        raise UserError(f"{option} {text}: must lie in {least} … {largest:g}; for example {option} {example}")
    return value


def _about(asked: Asked, track: Track, sigma: float, inverse: Inverse) -> dict[str, Any]:
    """What made the files; it repeats with them."""
    offsets = inverse.motion.offsets()
    errors, places = asked.sensors.errors, inverse.sensors.places
    return {
        "format": RESULT_FORMAT,
        "trajectory": asked.trajectory.name,
        "points": len(track),
        "smooth_m": sigma,
        "smoothed_unasked": asked.smooth is None and sigma > 0.0,
        "attitude_from": "motion" if track.attitude is None else "file",
        "columns_unused": list(track.unused),
        "samples_are": str(inverse.convention),
        "rate_hz": float(inverse.rate_hz),
        "preset": errors.preset,
        "overrides": list(errors.changes),
        "seed": errors.seed,
        "gnss_rate_hz": float(inverse.gnss_rate_hz),
        "gnss_epochs": inverse.epochs,
        "antenna_m": list(places.antenna_m),
        "imu_at_m": list(places.sensor_m),
        "mounting_deg": [math.degrees(angle) for angle in places.mounting_rad],
        "samples": inverse.samples,
        "duration_s": inverse.duration_ns / 1e9,
        "points_rms_m": float(math.sqrt((offsets**2).mean())),
        "points_max_m": float(offsets.max()),
    }


def _smoothed(about: dict[str, Any]) -> list[str]:
    """That nobody asked for smoothing, and how to do without."""
    if not about["smoothed_unasked"]:
        return []
    return [
        f"smoothed by {about['smooth_m']:g} m, as such files come from receivers; --smooth 0 meets them,"
        " --smooth M takes the receiver's 1 σ in m"
    ]


def _tell(about: dict[str, Any], done: Inverted, json_file: str | None) -> None:
    closure = done.closure.figures()
    console = standard_error() if json_file == "-" else standard_output()
    attitude = "attitude from the motion" if about["attitude_from"] == "motion" else "attitude from the file"
    lines = [
        f"{about['points']:,} points over {number(about['duration_s'])} s, passed within"
        f" {number(about['points_rms_m'])} m RMS, {number(about['points_max_m'])} m at most; {attitude}",
        *_smoothed(about),
        f"at most {number(done.fastest_mps)} m/s and {number(done.strongest_mps2)} m/s² of specific force",
        "a forward mechanization of the increments closes to"
        f" {closure['position_rms_m']:.2g} m, {closure['velocity_rms_mps']:.2g} m/s,"
        f" {closure['attitude_rms_deg']:.2g}° RMS ({closure['position_max_m']:.2g} m,"
        f" {closure['velocity_max_mps']:.2g} m/s, {closure['attitude_max_deg']:.2g}° at most)",
    ]
    if about["columns_unused"]:
        lines.append(
            f"not used: {', '.join(about['columns_unused'])}; a velocity needs north, east, down,"
            " an attitude yaw, pitch, roll"
        )
    files = [str(path) for path in done.files]
    if files:
        lines.append(f"written: {'  '.join(files)}")
    if done.strongest_mps2 > STRONGEST_MPS2:
        lines.append("that is no vehicle's motion: are the points a receiver's? then --smooth 2")
    for line in lines:
        console.print(line, soft_wrap=True)
    if json_file is None:
        return
    figures = {"closure": closure, "fastest_mps": done.fastest_mps, "strongest_mps2": done.strongest_mps2}
    text = json.dumps(about | figures | {"wall_s": done.wall_s, "files": files}, indent=1) + "\n"
    if json_file == "-":
        print(text, end="")
    else:
        write_whole(Path(json_file), text, "--json")
