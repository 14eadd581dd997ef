"""What `navtwin evaluate` does: drive with each sensor, compare, tell."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from boards.hints import did_you_mean
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files
from host.cli.simulate_run import scenario_file
from host.cli.terminal import print_section, progress_bar, standard_error, standard_output
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.sim.errors.presets import preset_names
from host.sim.scenario.load import load_scenario
from host.sim.scenario.schema import Scenario
from host.sim.seeding import LARGEST_SEED
from host.simulate.drift import Drift, Plan
from host.simulate.extras import must_have
from host.simulate.outage_page import PUBLISHED, agrees, page, section, to_dict
from host.simulate.outage_test import drift_of

RESULT_FORMAT = "navtwin-evaluation-1"
LIMITS = {
    "drives": (1, 1000),
    "outages": (1, 1000),
    "length": (1, 3600),
    "gap": (1, 3600),
    "seed": (0, LARGEST_SEED - 1000),
}
LONGEST_S = 200_000


@dataclass(frozen=True, slots=True)
class Asked:
    """The words of the command line."""

    scenario: str
    presets: tuple[str, ...]
    drives: int
    outages: int
    length: int
    gap: int
    seed: int

    @property
    def seeds(self) -> range:
        """Of the drives."""
        return range(self.seed, self.seed + self.drives)


def execute(asked: Asked, output: Path | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError, ScenarioError."""
    plan = _plan(asked)
    presets = _presets(asked)
    scenario = _scenario(asked.scenario)
    check_files(("-o", output), ("--json", json_file), read=scenario.path)
    if asked.drives > 1:
        must_have("scipy", "navtwin evaluate")
    drifts: list[Drift] = []
    for preset in presets:
        with progress_bar(f"evaluate {preset}", quiet) as progress:
            drifts.append(drift_of(scenario, plan, preset, asked.seeds, progress))
    summary = section(drifts, scenario.name)
    console = standard_error() if json_file == "-" else standard_output()
    if not quiet:
        print_section(console, summary)
    if output is not None:
        write_whole(output, page(f"Drift on {scenario.name}", drifts, summary), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    if json_file is not None:
        about = {
            "format": RESULT_FORMAT,
            "scenario": scenario.name,
            "seed": asked.seed,
            "drives": asked.drives,
            "plan": asdict(plan),
        }
        text = json.dumps(about | {"sensors": [to_dict(one) for one in drifts]}, indent=1) + "\n"
        if json_file == "-":
            print(text, end="")
        else:
            write_whole(Path(json_file), text, "--json")
    missed = any(agrees(one) is False for one in drifts)
    return EXIT_NOT_MET if missed else EXIT_MET


def _plan(asked: Asked) -> Plan:
    for option, (least, largest) in LIMITS.items():
        value = getattr(asked, option)
        if not least <= value <= largest:
            raise UserError(
                f"--{option} {value}: must lie in {least} … {largest}; for example --{option} {max(1, least)}"
            )
    plan = Plan(asked.outages, asked.length, asked.gap)
    if plan.duration_s > LONGEST_S:
        raise UserError(
            f"--outages {asked.outages}: make a drive of {plan.duration_s} s with --length {asked.length} and"
            f" --gap {asked.gap}; at most {LONGEST_S} s, for example --outages 20"
        )
    return plan


def _presets(asked: Asked) -> tuple[str, ...]:
    for name in asked.presets:
        if name not in preset_names():
            raise UserError(f"--preset {name}: no such preset; {did_you_mean(name, preset_names())}")
    return tuple(dict.fromkeys(asked.presets)) or tuple(PUBLISHED)


def _scenario(name: str) -> Scenario:
    scenario = load_scenario(scenario_file(name))
    if scenario.kind != "simulated":
        raise UserError(
            f"{name}: is a recording, whose sensors are measured; name a scenario with motion, e.g. town-open"
        )
    return scenario
