"""Make a baseline of what a run or a campaign left in its folder."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from host.baseline.file import BaselineRun, campaign_runs, run_of_document, write_baseline
from host.campaign.folder import MANIFEST, RESULT
from host.campaign.row import FINISHED, Value
from host.campaign.table import PLANNED, read_rows
from host.record.errors import UserError

KINDS = {"sweep": "a sweep", "faults": "a fault sheet"}


def update(path: Path, folder: Path) -> str:
    """Write the baseline `path`; returns a line that tells what it holds. Raises UserError."""
    campaign = (folder / MANIFEST).is_file()
    manifest, runs = _of_campaign(folder) if campaign else _of_run(folder)
    write_baseline(path, manifest, runs)
    count = f"{len(runs)} runs" if len(runs) != 1 else "one run"
    return f"{path}: {count} of {manifest['board']} {manifest['scenario']}"


def _of_campaign(folder: Path) -> tuple[dict[str, Any], list[BaselineRun]]:
    rows, manifest = read_rows(folder / RESULT)
    _must_be_whole(folder, rows, manifest)
    return manifest, campaign_runs(rows, manifest)


def _must_be_whole(folder: Path, rows: Sequence[Mapping[str, Value]], manifest: Mapping[str, Any]) -> None:
    """A baseline is made of what all runs of a campaign say."""
    kind, planned = manifest.get("kind"), manifest.get(PLANNED)
    if kind != "campaign":
        raise UserError(
            f"{folder}: holds {KINDS.get(str(kind), kind)}; a baseline is made of a campaign or a run"
        )
    if planned != len(rows):
        raise UserError(
            f"{folder}: {len(rows)} of {planned} runs are done; the same navtwin campaign goes on to its end"
        )
    failed = [row for row in rows if row["status"] != FINISHED]
    if failed:
        raise UserError(
            f"{folder}: {len(failed)} of {planned} runs did not reach their end, the first of them with seed"
            f" {failed[0]['seed']}: {failed[0]['error']}; a baseline needs runs that do"
        )


def _of_run(folder: Path) -> tuple[dict[str, Any], list[BaselineRun]]:
    try:
        manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
        document = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        return manifest, [run_of_document(document)]
    except OSError:
        raise UserError(
            f"{folder}: neither a campaign nor a finished run; for example runs/car_mems-town-full-rate-1"
        ) from None
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{folder}: its result cannot be read ({error})") from None
