"""The command line as tests call it, and readers of what it leaves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from typer.testing import CliRunner, Result

from host.cli.main import app

REST = Path(__file__).with_name("rest.toml")


def navtwin(*arguments: object) -> Result:
    """`navtwin` with these arguments, in this process."""
    return CliRunner().invoke(app, [str(one) for one in arguments])


def campaign(out: Path, *more: object, seeds: str = "1-3") -> Result:
    """A campaign at rest, quietly."""
    return navtwin("campaign", "car_mems", "-s", REST, "--seeds", seeds, "--out", out, "-q", *more)


def rows(out: Path) -> list[dict[str, Any]]:
    """The result file, by DuckDB: whoever wrote it, another library reads it."""
    import duckdb

    table = duckdb.sql(f"SELECT * FROM '{out / 'runs.parquet'}' ORDER BY run")
    return [dict(zip(table.columns, row, strict=True)) for row in table.fetchall()]


def summary(out: Path) -> dict[str, Any]:
    """summary.json."""
    found: dict[str, Any] = json.loads((out / "summary.json").read_text())
    return found
