"""The result file: Parquet, one row a run, in the order of the plan, with the manifest in its metadata.

The same rows give the same bytes. Every column stands in every file of one campaign, so that DuckDB, pandas
and Polars read it as it is: `SELECT seed, position_horizontal_rms_m FROM 'runs.parquet'`.
"""

from __future__ import annotations

import importlib.util
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from host.campaign.row import Value
from host.record.atomic import write_whole
from host.record.errors import UserError

METADATA = b"navtwin"
PLANNED = "planned_runs"
"""In the metadata besides the manifest: how many rows the file has when the campaign is done."""

CONSTANT = ("board", "scenario", "sources", "machine")
"""Columns that are the same in all rows, from the manifest; besides them the versions and the overrides."""

TEXTS = ("error", "state_hash", "overrides")
"""Columns of text, also where no run has any."""


def must_have_parquet() -> None:
    """Tell before a long campaign that its result could not be written. Raises UserError."""
    for package in ("pyarrow", "scipy"):
        if importlib.util.find_spec(package) is None:
            raise UserError(
                f"campaigns need {package}, which is not installed: pip install 'navtwin[campaign]'"
            )


def write_table(
    path: Path, rows: Sequence[Mapping[str, Value]], manifest: Mapping[str, Any], planned: int
) -> None:
    """Write all rows that there are. Raises UserError when the file cannot be written."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = _columns(rows, manifest)
    arrays = {name: _array(pa, name, values) for name, values in columns.items()}
    metadata = json.dumps({**manifest, PLANNED: planned}, sort_keys=True)
    table = pa.table(arrays).replace_schema_metadata({METADATA: metadata})
    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd")
    write_whole(path, buffer.getvalue(), "--out")


def read_rows(path: Path) -> tuple[list[dict[str, Value]], dict[str, Any]]:
    """All rows of a result file, and its manifest with PLANNED. Raises UserError."""
    must_have_parquet()
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
        manifest = json.loads((table.schema.metadata or {})[METADATA])
    except FileNotFoundError:
        raise UserError(f"{path}: no such file") from None
    except (pa.ArrowInvalid, KeyError, ValueError, OSError) as error:
        raise UserError(f"{path}: is not the result of a campaign ({error})") from None
    return table.to_pylist(), manifest


def _columns(rows: Sequence[Mapping[str, Value]], manifest: Mapping[str, Any]) -> dict[str, list[Value]]:
    constant: dict[str, Value] = {name: manifest[name] for name in CONSTANT}
    constant |= {f"version.{name}": text for name, text in manifest["versions"].items()}
    constant["overrides"] = "\n".join(manifest["overrides"])
    columns: dict[str, list[Value]] = {"run": [row["run"] for row in rows]}
    columns |= {name: [value] * len(rows) for name, value in constant.items()}
    for row in rows:
        columns |= {name: [other.get(name) for other in rows] for name in row if name not in columns}
    return columns


def _array(pa: Any, name: str, values: Sequence[Value]) -> Any:
    """One type for a column; numbers are float64 unless all are whole, as run and seed are."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {bool}:
        return pa.array(values, type=pa.bool_())
    if kinds == {int}:
        return pa.array(values, type=pa.int64())
    if kinds <= {int, float} and name not in TEXTS:
        return pa.array(values, type=pa.float64())
    return pa.array([None if value is None else str(value) for value in values], type=pa.string())
