"""What `navtwin pil` does."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.run_command import check_data
from host.cli.terminal import standard_error
from host.pil.planted import PLANTS
from host.pil.session import PilRequest, PilResult, compare
from host.pil.stand_alone_run import run_stand_alone
from host.record.errors import UserError
from host.record.result import RunRequest


@dataclass(frozen=True, slots=True)
class Asked:
    """The options."""

    run: RunRequest
    steps: int
    port: str | None
    costs: bool
    unit: bool
    planted: str | None
    stand_alone: bool = False


def execute(asked: Asked, json: str | None, quiet: bool) -> int:
    """Compare and print; returns the exit code. Raises UserError."""
    if asked.steps < 1:
        raise UserError(f"--steps {asked.steps}: at least one; for example --steps 10000")
    if asked.planted is not None and asked.planted not in PLANTS:
        raise UserError(f"--plant {asked.planted}: not known; one of {', '.join(PLANTS)}")
    if asked.port is not None and asked.planted is not None:
        raise UserError("--plant: only an emulated board gets another image; leave out --port")
    check_data(asked.run.data_dir)
    check_files(("--json", json))
    if asked.stand_alone:
        return _execute_stand_alone(asked, json, quiet)
    request = PilRequest(asked.run, asked.steps, asked.port, asked.costs, asked.planted, asked.unit)
    result = compare(request, (lambda _: None) if quiet else standard_error().print)
    write_json(result.to_dict(), json)
    console = for_people(json)
    if not quiet:
        _print_kernels(console, result)
    _print_verdict(console, result)
    return EXIT_NOT_MET if result.differences or not result.steps else EXIT_MET


def _execute_stand_alone(asked: Asked, json: str | None, quiet: bool) -> int:
    if asked.unit or asked.costs or asked.planted is not None:
        raise UserError("--stand-alone goes with --port, --scenario, --profile, --seed and --set alone")
    notice = (lambda _: None) if quiet else standard_error().print
    result = run_stand_alone(asked.run, asked.port, notice)
    write_json(result.to_dict(), json)
    say = for_people(json).print
    for found in result.differences[:1]:
        say(f"first difference in {found}", soft_wrap=True, markup=False, highlight=False)
    verdict = "equal" if result.is_equal else "DIFFERENT"
    say(
        f"{verdict}: {result.solutions_equal} solutions and {result.copies_equal} copies of the memory equal,"
        f" {result.solutions_different} and {result.copies_different} different, on {result.target} by itself"
        f" ({result.board} {result.profile}, {result.scenario}, {result.inputs_taken} of {result.inputs}"
        f" inputs, {result.inputs_repeated} of them sent again; {result.wall_s:.1f} s)",
        soft_wrap=True,
        markup=False,
        highlight=False,
    )
    return EXIT_MET if result.is_equal else EXIT_NOT_MET


def _print_kernels(console: Console, result: PilResult) -> None:
    table = Table("steps", "kernel", *([f"{result.cycles_are} (mean)", "most"] if result.cycles else []))
    for name, calls in sorted(result.kernels.items(), key=lambda item: -item[1]):
        figures = result.cycles.get(name, {})
        table.add_row(str(calls), name, *(f"{figures[key]:.0f}" for key in ("mean", "most") if figures))
    console.print(table)
    for name, number in result.parts.items():
        console.print(f"{number:8} {result.cycles_are}: {name}", highlight=False)


def _print_verdict(console: Console, result: PilResult) -> None:
    where = f"{result.board} {result.profile}, {result.scenario}, {result.virtual_s:.1f} s of virtual time"
    if not result.virtual_s:
        where = f"{result.board} {result.profile}, {len(result.kernels)} kernels on their own"
    for name, reason in result.left_out.items():
        console.print(f"left out: {name}: {reason}", soft_wrap=True, highlight=False)
    if result.differences:
        found = result.first_difference
        assert found is not None
        console.print(
            f"DIFFERENT: {result.differences} of {result.steps} steps on {result.target} ({where});"
            f" the first, step {found['step']}: {found['kernel']}: {found['state']}:"
            f" twin {found['twin']!r}, target {found['target']!r}, {found['ulp']} ULP apart",
            soft_wrap=True,
            highlight=False,
        )
    else:
        console.print(
            f"equal: {result.steps} steps on {result.target}, every bit ({where}; {result.wall_s:.1f} s)",
            soft_wrap=True,
            highlight=False,
        )
    mended = {name: number for name, number in result.line.items() if number}
    if mended.pop("silent", 0) > 1 or mended:
        console.print(f"line: {result.line}, all resumed", highlight=False)
