"""Text files of KF-GINS: NAME.imu.txt, NAME.gnss.txt and NAME.truth.txt, numbers between blanks.

| file | columns |
| --- | --- |
| imu | GPS second of week of the interval's end, angle increments x y z rad, velocity increments x y z m/s |
| gnss | second of week, latitude °, longitude °, height m, σ north, east, down m; epochs with a fix only |
| truth | GPS week, second of week, latitude °, longitude °, height m, v NED m/s, roll, pitch, yaw ° |

Axes are forward, right, down. Seconds of week run on beyond a week's end, so that they never go back.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.record.row_text import RowText
from host.simulate.formats.side_csv import SideCsv
from host.simulate.part_files import PartFiles
from host.simulate.rows import GNSS, truth_rows
from host.simulate.source import Source
from host.simulate.stream import NS, Block

WEEK_NS = 7 * 86400 * NS
IMU_DECIMALS = (9, *(15,) * 3, *(12,) * 3)
GNSS_DECIMALS = (9, 12, 12, 4, 3, 3, 3)
TRUTH_DECIMALS = (0, 9, 12, 12, 6, 9, 9, 9, 10, 10, 10)
_PLACE = [GNSS.columns.index(name) for name in ("latitude_deg", "longitude_deg", "height_m")]
_FIX, _H_ACC, _V_ACC = (GNSS.columns.index(name) for name in ("fix", "h_acc_m", "v_acc_m"))


class KfGinsWriter:
    """Writes the files. The drive's samples must be increments."""

    def __init__(self, source: Source, path: Path, files: PartFiles, about: Mapping[str, Any]) -> None:
        self._week, self._second_ns = divmod(source.start_gps_ns, WEEK_NS)
        self._imu, self._gnss, self._truth = (
            files.open(path.with_suffix(f".{kind}.txt")) for kind in ("imu", "gnss", "truth")
        )
        self._sides = SideCsv(source, path, files)
        self._imu_text = blanks(IMU_DECIMALS)
        self._gnss_text = blanks(GNSS_DECIMALS)
        self._truth_text = blanks(TRUTH_DECIMALS)

    def add_block(self, block: Block) -> None:
        """A line a sample in both files."""
        second = ((self._second_ns + block.times_ns) / NS)[:, None]
        self._imu.write(self._imu_text.text(np.hstack((second, block.felt[:, 3:6], block.felt[:, 0:3]))))
        truth = truth_rows(block)
        week = np.full_like(second, self._week)
        lines = np.hstack((week, second, truth[:, :6], truth[:, 8:9], truth[:, 7:8], truth[:, 6:7]))
        self._truth.write(self._truth_text.text(lines))

    def add_gnss(self, rows: NDArray[np.float64]) -> None:
        """A line an epoch with a fix; the claimed horizontal accuracy is that of both axes together."""
        fixed = rows[rows[:, _FIX] == 1.0]
        second = self._second_ns / NS + fixed[:, :1]
        axis = fixed[:, [_H_ACC]] / np.sqrt(2.0)
        self._gnss.write(
            self._gnss_text.text(np.hstack((second, fixed[:, _PLACE], axis, axis, fixed[:, [_V_ACC]])))
        )

    def add_side(self, name: str, rows: NDArray[np.float64]) -> None:
        """A line a sample, in a CSV of its own."""
        self._sides.add(name, rows)

    def finish(self) -> None:
        """Nothing is left to write."""


def blanks(decimals: tuple[int, ...]) -> RowText:
    """Lines of numbers between blanks."""
    return RowText([b"", *[b" "] * (len(decimals) - 1), b"\n"], decimals, b"nan")
