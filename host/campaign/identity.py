"""What a campaign is, so that its results are never mixed with those of another one or of other sources."""

from __future__ import annotations

import functools
import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from boards.description import load_board
from boards.places import board_folder
from host.campaign.plan import Plan, seeds_text
from host.record.manifest import build_manifest
from host.run.setup import scenario_path
from host.sim.scenario.load import source_text

CAMPAIGN_FORMAT = "navtwin-campaign-1"
PACKAGES = ("hal", "firmware", "boards", "host")
SOURCES = (".py", ".toml", ".dbc")


def campaign_manifest(plan: Plan, kind: str) -> dict[str, Any]:
    """All that decides the figures of a campaign; two campaigns are the same when these are equal."""
    folder = board_folder(plan.board)
    path = scenario_path(plan.board, plan.scenario)
    manifest = build_manifest(
        load_board(plan.board).name,
        (folder / "board.toml").read_text(encoding="utf-8"),
        path.stem,
        source_text(path),
        ", ".join(plan.profiles),
        0,
        plan.fixed,
    )
    del manifest["seed"], manifest["profile"]
    return manifest | {
        "format": CAMPAIGN_FORMAT,
        "kind": kind,
        "profiles": list(plan.profiles),
        "seeds": seeds_text(plan.seeds),
        "swept": {key: list(values) for key, values in plan.swept},
        "sources": sources_digest(folder),
    }


def fingerprint(manifest: dict[str, Any]) -> str:
    """A short name of all that decides the figures of a run besides its seed."""
    text = json.dumps({**manifest, "seeds": ""}, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def differences(one: dict[str, Any], other: dict[str, Any]) -> list[str]:
    """The keys in which two manifests differ."""
    return [key for key in sorted({*one, *other}) if one.get(key) != other.get(key)]


@functools.cache
def sources_digest(board: Path) -> str:
    """Digest of navtwin's own sources, and of those of a board of one's own, as this process found them."""
    root = Path(__file__).parents[2]
    folders = [root / name for name in PACKAGES]
    if not board.resolve().is_relative_to(root / "boards"):
        folders.append(board)
    digest = hashlib.sha256()
    for folder in folders:
        for path in _sources(folder):
            digest.update(path.relative_to(folder.parent).as_posix().encode() + b"\0")
            digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


def _sources(folder: Path) -> Iterator[Path]:
    """Source files in a fixed order; hidden folders (environments, caches) are not looked into."""
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith((".", "__")))
        yield from (Path(place, name) for name in sorted(names) if name.endswith(SOURCES))
