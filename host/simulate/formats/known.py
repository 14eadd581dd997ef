"""The formats by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from boards.hints import did_you_mean
from host.record.errors import UserError
from host.simulate.formats.csv_files import CsvWriter
from host.simulate.formats.kf_gins_files import KfGinsWriter
from host.simulate.formats.mcap_file import McapWriter
from host.simulate.formats.npz_file import NpzWriter
from host.simulate.formats.pyins_files import PyinsWriter
from host.simulate.formats.writer import Writer
from host.simulate.stream import Convention


@dataclass(frozen=True, slots=True)
class Format:
    """A way to write a drive."""

    writer: type[Writer]
    suffix: str
    usual: Convention = Convention.INSTANT
    only: Convention | None = None
    """The one convention that it can tell."""


FORMATS = {
    "csv": Format(CsvWriter, ".csv"),
    "npz": Format(NpzWriter, ".npz"),
    "mcap": Format(McapWriter, ".mcap"),
    "kf-gins": Format(KfGinsWriter, ".txt", Convention.INCREMENT, Convention.INCREMENT),
    "pyins": Format(PyinsWriter, ".csv"),
}


def chosen(name: str | None, path: Path) -> Format:
    """The format asked for, else that of the file's ending. Raises UserError."""
    if name is not None:
        if name not in FORMATS:
            raise UserError(f"--format {name}: no such format; {did_you_mean(name, FORMATS)}")
        return FORMATS[name]
    for known in FORMATS.values():
        if path.suffix == known.suffix and known.only is None:
            return known
    raise UserError(
        f"-o {path}: its ending tells no format; .csv, .npz and .mcap do, or name one with --format:"
        f" {', '.join(FORMATS)}"
    )
