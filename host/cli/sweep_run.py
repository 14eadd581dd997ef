"""What `navtwin sweep` does: a campaign over one key, and its error curves as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from host.campaign.folder import CURVES
from host.campaign.plan import parse_values
from host.campaign.quantities import quantity
from host.campaign.summary import Summary, summarised
from host.cli.campaign_run import Outputs, ask, default_folder, run_and_tell
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.record.atomic import write_whole
from host.record.errors import UserError

Asked = tuple[str, str | None, str, str | None, Sequence[str] | None, Path | None]


def execute_sweep(
    asked: Asked, name: str, values: str | None, outputs: Outputs, workers: int | None, scheduler: str | None
) -> int:
    """Run the sweep. Returns the exit code. Raises UserError."""
    board, scenario, seeds, profiles, changes, data = asked
    known = quantity(board, name)
    key = name if known is None else known.key
    if values is not None:
        texts = parse_values(values, f"--values {values}")
    elif known is not None:
        texts = known.values
    else:
        raise UserError(f"--key {name}: needs --values, for example --values 0.05,0.1,0.2")
    if len(texts) < 2:
        raise UserError(f"--values {values}: a sweep needs two values at least, for example 0.05,0.1,0.2")
    plan = ask(board, scenario, seeds, profiles, changes, data)
    if plan.swept:
        raise UserError(f"--set {plan.swept[0][0]}: a sweep has one key; for several: navtwin campaign")
    plan = replace(plan, swept=((key, texts),))
    folder = outputs.out or Path(f"{default_folder(plan, 'sweep')}-{name.replace(':', '-')}")
    finished, _ = run_and_tell(plan, replace(outputs, out=folder), workers, scheduler, "sweep")
    summary = summarised(finished)
    write_whole(folder / CURVES, curves(key, summary), "--out")
    return EXIT_NOT_MET if summary.failures else EXIT_MET


def curves(key: str, summary: Summary) -> str:
    """A line for each value and figure."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["profile", key, "figure", "runs", "mean", "low95", "high95", "median", "p95"])
    for one in summary.setups:
        for name, found in one.figures.items():
            row = [found.count, found.mean, found.low, found.high, found.median, found.p95]
            writer.writerow([one.setup.profile, one.setup.swept[0][1], name, *row])
    return text.getvalue()
