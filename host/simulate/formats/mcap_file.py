"""MCAP with JSON messages, for Foxglove and PlotJuggler: /imu, /truth, /gnss, /mag, /baro, /baseline.

Times of messages are ns since the start of the drive. What was asked for stands in the metadata `simulation`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

from host.capture.topics import table_schema
from host.record.row_text import RowText
from host.record.tables import Table
from host.simulate.part_files import PartFiles
from host.simulate.rows import GNSS, TRUTH, imu_rows, imu_table, truth_rows
from host.simulate.source import Source
from host.simulate.stream import NS, Block

TRUTH_AT = Table(("t_s", *TRUTH.columns), (9, *TRUTH.decimals))


class McapWriter:
    """Writes the file."""

    def __init__(self, source: Source, path: Path, files: PartFiles, about: Mapping[str, Any]) -> None:
        self._writer = Writer(files.open(path), compression=CompressionType.LZ4)
        self._writer.start(profile="", library="navtwin")
        self._writer.add_metadata("simulation", {key: str(value) for key, value in about.items()})
        self._imu = self._channel("/imu", "navtwin.SimulatedImu", imu_table(source.convention))
        self._truth = self._channel("/truth", "navtwin.Truth", TRUTH_AT)
        self._gnss = self._channel("/gnss", "navtwin.SimulatedGnss", GNSS)

        self._sides = {
            one.name: self._channel(f"/{one.name}", f"navtwin.Simulated{one.name.capitalize()}", one.table)
            for one in source.side_tables
        }

    def add_block(self, block: Block) -> None:
        """Two messages a sample."""
        times_ns = block.times_ns.tolist()
        t_s = (block.times_ns / NS)[:, None]
        self._add(self._imu, times_ns, imu_rows(block))
        self._add(self._truth, times_ns, np.hstack((t_s, truth_rows(block))))

    def add_gnss(self, rows: NDArray[np.float64]) -> None:
        """A message an epoch."""
        self._add(self._gnss, np.round(rows[:, 0] * NS).astype(np.int64).tolist(), rows)

    def add_side(self, name: str, rows: NDArray[np.float64]) -> None:
        """A message a sample."""
        self._add(self._sides[name], np.round(rows[:, 0] * NS).astype(np.int64).tolist(), rows)

    def finish(self) -> None:
        """Write the index."""
        self._writer.finish()

    def _channel(self, topic: str, schema: str, table: Table) -> tuple[int, RowText]:
        known = self._writer.register_schema(schema, "jsonschema", table_schema(schema, table))
        return self._writer.register_channel(topic, "json", known), RowText.json(
            table.columns, table.decimals
        )

    def _add(self, channel: tuple[int, RowText], times_ns: list[int], rows: NDArray[np.float64]) -> None:
        number, text = channel
        for time_ns, message in zip(times_ns, text.texts(rows), strict=True):
            self._writer.add_message(number, time_ns, message, time_ns)
