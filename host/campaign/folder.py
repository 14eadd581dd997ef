"""The folder of a campaign: campaign.json, the journal, runs.parquet, summary.json, report.html."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from host.campaign.folder_lock import LOCK, FolderLock
from host.campaign.identity import CAMPAIGN_FORMAT, differences, fingerprint
from host.campaign.journal import JOURNAL, TIMES, Journal
from host.campaign.plan import parse_seeds
from host.record.atomic import write_whole
from host.record.errors import UserError

MANIFEST = "campaign.json"
RESULT = "runs.parquet"
SUMMARY = "summary.json"
REPORT = "report.html"
CURVES = "curves.csv"
SHEET, SHEET_PAGE = "faults.csv", "faults.html"
OWN_FILES = (MANIFEST, JOURNAL, TIMES, RESULT, SUMMARY, REPORT, CURVES, SHEET, SHEET_PAGE)


def open_folder(folder: Path, manifest: dict[str, Any], fresh: bool = False) -> Journal:
    """Begin a campaign in a new folder, or go on with the same one; `fresh`: forget an earlier one there.

    A campaign that has no run yet gives its folder up to any other. Raises UserError for a folder that holds
    anything else, and for one that is being written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(path.name != LOCK for path in folder.iterdir()):
            read_manifest(folder)
        lock = FolderLock(folder)
    except FileExistsError:
        raise UserError(f"--out {folder}: is a file; name a folder, e.g. --out runs/nightly") from None
    except OSError as error:
        raise UserError(f"--out {folder}: cannot be written: {error.strerror}") from None
    try:
        _claim(folder, manifest, fresh)
        return Journal(folder, fingerprint(manifest), lock)
    except BaseException:
        lock.release()
        raise


def _claim(folder: Path, manifest: dict[str, Any], fresh: bool) -> None:
    """Make a locked folder one of this campaign."""
    path = folder / MANIFEST
    if path.is_file():
        there = read_manifest(folder)
        if not fresh and not (differences(there, manifest) and _has_no_run(folder)):
            _must_be_the_same(folder, there, manifest)
            if there != manifest:
                _write_manifest(path, manifest)
            return
        for name in reversed(OWN_FILES):  # the manifest last: until then the folder is known as ours
            (folder / name).unlink(missing_ok=True)
    _write_manifest(path, manifest)


def _write_manifest(path: Path, manifest: dict[str, Any]) -> None:
    write_whole(path, json.dumps(manifest, indent=1) + "\n", "--out")


def _has_no_run(folder: Path) -> bool:
    """Whether the journal has no whole line after its first one."""
    try:
        return (folder / JOURNAL).read_bytes().count(b"\n") <= 1
    except FileNotFoundError:
        return True


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a campaign's folder. Raises UserError when it is none, or of another version."""
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        raise UserError(
            f"{folder}: not the folder of a campaign (no {MANIFEST}); name another, e.g. --out runs/nightly"
        ) from None
    except OSError as error:
        raise UserError(f"{folder / MANIFEST}: cannot be read: {error.strerror}") from None
    except ValueError:
        raise UserError(f"{folder / MANIFEST}: is not valid JSON") from None
    found = manifest.get("format") if isinstance(manifest, dict) else None
    if found != CAMPAIGN_FORMAT:
        raise UserError(
            f"{folder / MANIFEST}: is of format {found!r}, this navtwin writes {CAMPAIGN_FORMAT!r};"
            " name a new folder, e.g. --out runs/second"
        )
    return dict(manifest)


def _next_seed(seeds: str) -> int:
    return parse_seeds(seeds)[-1] + 1


def _must_be_the_same(folder: Path, there: dict[str, Any], asked: dict[str, Any]) -> None:
    changed = differences(there, asked)
    if changed == ["seeds"]:
        if {*parse_seeds(there["seeds"])} < {*parse_seeds(asked["seeds"])}:
            return
        raise UserError(
            f"--out {folder}: holds the seeds {there['seeds']}, and --seeds {asked['seeds']} would leave some"
            f" out; seeds can be added, e.g. --seeds {there['seeds']},{_next_seed(there['seeds'])}; or"
            " name a new folder, or begin anew with --fresh"
        )
    if changed:
        raise UserError(
            f"--out {folder}: holds a campaign that differs in {', '.join(changed)}, so its runs cannot be"
            " mixed with these; name a new folder, or begin anew with --fresh"
        )
