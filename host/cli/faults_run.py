"""What `navtwin faults` does: one run without a fault, one with each, and the sheet of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from boards.description import load_board
from host.campaign.campaign import run_campaign
from host.campaign.fault_effect import fault_course
from host.campaign.fault_plan import NO_FAULT, possible, strikes
from host.campaign.fault_sheet import effects, left_out, section, sheet_csv, sheet_page, verdict
from host.campaign.folder import SHEET, SHEET_PAGE
from host.campaign.plan import Plan, parse_values
from host.cli.campaign_run import ask, default_folder, make_executor, progress_bar
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.terminal import print_section, standard_error, standard_output
from host.record.atomic import write_whole
from host.record.errors import UserError


@dataclass(frozen=True, slots=True)
class FaultRequest:
    """What was asked for."""

    board: str
    scenario: str | None
    seed: int
    profile: str | None
    at_s: float | None
    duration_s: float
    only: str | None
    changes: tuple[str, ...]
    data: Path | None


def execute_faults(
    asked: FaultRequest,
    out: Path | None,
    workers: int | None,
    scheduler: str | None,
    fresh: bool,
    quiet: bool,
) -> int:
    """Run all faults. Returns the exit code. Raises UserError."""
    if asked.duration_s <= 0:
        raise UserError(f"--for {asked.duration_s:g}: must be above 0 s; for example --for 10")
    plan = ask(asked.board, asked.scenario, str(asked.seed), asked.profile, asked.changes, asked.data)
    if plan.swept or len(plan.profiles) > 1:
        raise UserError("faults take one profile and one value of each --set; for several: navtwin campaign")
    plan = replace(plan, fixed=tuple(change for change in plan.fixed if not change.startswith("fault=")))
    at_s = _strike_time(plan) if asked.at_s is None else asked.at_s
    only = parse_values(asked.only, f"--only {asked.only}") if asked.only else ()
    wanted = list(strikes(load_board(plan.board), at_s, asked.duration_s, only))
    can, cannot = possible(plan, wanted)
    if not can:
        raise UserError(
            f"no fault can strike: {cannot[0][1]}" if cannot else "the board has nothing to break"
        )
    plan = replace(plan, swept=(("fault", (NO_FAULT, *(strike.as_value() for strike in can))),))
    executor = make_executor(plan, workers, scheduler, fault_course)
    folder = out or default_folder(plan, "faults")
    with progress_bar(f"{Path(plan.board).name} faults", quiet) as progress:
        finished = run_campaign(
            plan,
            folder,
            executor,
            kind="faults",
            fresh=fresh,
            notice=standard_error().print,
            progress=progress,
        )
    found = effects(finished, can)
    write_whole(folder / SHEET, sheet_csv(found), "--out")
    write_whole(folder / SHEET_PAGE, sheet_page(finished.manifest, found, cannot), "--out")
    console = standard_output()
    if not quiet:
        for table in (section(found), left_out(cannot)):
            if table.rows:
                print_section(console, table)
    console.print(verdict(found), soft_wrap=True)
    console.print(f"sheet: {folder / SHEET}  report: {folder / SHEET_PAGE}", soft_wrap=True)
    return EXIT_MET if all(one.ok for one in found) else EXIT_NOT_MET


def _strike_time(plan: Plan) -> float:
    """A third of the run, in whole seconds."""
    from host.run.runner import check

    return float(round(check(plan.request(next(plan.setups()), plan.seeds[0])) / 3))
