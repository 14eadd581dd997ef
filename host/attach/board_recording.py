"""What is kept of an attached board: run.mcap with every byte and when it came, solution.csv.

Both are handed to the system twice a second, so that a kill loses less than a second. Times are those of the
recording, from its beginning on; `board_s` is the board's own clock.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from host.capture.writer import CaptureWriter
from host.link.attitude import SOLUTIONS, solution_rows
from host.record.row_text import RowText
from host.record.run_folder import RunFolder
from host.record.tables import DEGREES, SOLUTION

FLUSH_EVERY_NS = 500_000_000
WITHOUT_TRUTH = SOLUTION.columns.index("error_north_m")
COLUMNS = (*SOLUTION.columns[:WITHOUT_TRUTH], "board_s")
DECIMALS = (*SOLUTION.decimals[:WITHOUT_TRUTH], 6)
NANODEG = 1e-9


class BoardRecording:
    """A folder like a run's. Raises UserError when it cannot be had."""

    def __init__(self, folder: Path, manifest: Mapping[str, Any], port: str) -> None:
        self._folder = RunFolder(folder, manifest)
        self._csv = self._folder.file("solution.csv.part").open("wb")
        self._csv.write(",".join(COLUMNS).encode() + b"\n")
        self._text = RowText.csv(DECIMALS)
        self._capture = CaptureWriter(self._folder.file("run.mcap"), manifest)
        self._record = self._capture.uart_recorder(port, "tx")
        self._solutions: dict[int, list[tuple[int, bytes]]] = {kind: [] for kind in SOLUTIONS}
        self._flushed_ns = 0
        self._last_ns = 0

    def bytes_came(self, time_ns: int, data: bytes) -> None:
        """Every byte."""
        self._record(time_ns, data)

    def solution(self, time_ns: int, kind: int, payload: bytes) -> None:
        """A frame of SOLUTIONS that came."""
        self._solutions[kind].append((time_ns, payload))

    def event(self, time_ns: int, source: str, text: str) -> None:
        """What people should know."""
        self._capture.event(time_ns, source, text)

    def look(self, now_ns: int) -> None:
        """Hand what has come to the system when it is time."""
        if now_ns - self._flushed_ns >= FLUSH_EVERY_NS:
            self._flush(now_ns)

    def finish(self, now_ns: int) -> None:
        """The attachment has ended as it should."""
        self._flush(now_ns)
        self._csv.close()
        self._capture.close({"duration_s": f"{now_ns / 1e9:.9f}"})
        csv = self._folder.file("solution.csv")
        csv.with_name(csv.name + ".part").replace(csv)
        self._folder.set_status("complete")
        self._folder.release()

    def abandon(self) -> None:
        """Leave what there is, marked as not finished."""
        self._csv.close()
        self._capture.abandon()
        self._folder.set_status("interrupted")
        self._folder.release()

    def _flush(self, now_ns: int) -> None:
        self._flushed_ns = now_ns
        for kind, came in self._solutions.items():
            if not came:
                continue
            rows = _rows(kind, came)
            self._csv.write(self._text.text(rows))
            shown = np.full((len(rows), len(SOLUTION.columns)), np.nan)
            shown[:, :WITHOUT_TRUTH] = rows[:, :-1]
            self._capture.rows("/solution", shown)
            came.clear()
        self._csv.flush()
        self._capture.flush(now_ns)


def _rows(kind: int, solutions: list[tuple[int, bytes]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    told = solution_rows(kind, [payload for _, payload in solutions])
    return np.column_stack(
        (
            np.array([time_ns for time_ns, _ in solutions]) / 1e9,
            told["lat_nanodeg"] * NANODEG,
            told["lon_nanodeg"] * NANODEG,
            told["height"],
            told["velocity_ned"],
            np.column_stack((told["yaw"], told["pitch"], told["roll"])) * DEGREES,
            told["sigma_position"],
            told["sigma_velocity"],
            told["sigma_attitude"] * DEGREES,
            told["mode"],
            told["flags"],
            told["time_us"] / 1e6,
        )
    )
