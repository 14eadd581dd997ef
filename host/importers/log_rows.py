"""Gathers what a receiver's log tells, epoch by epoch, into portions: rows of tables and the log's own bytes.

A log has no times of arrival. Its bytes are placed at the epoch that they belong to, so that they can be
exported again, in order and whole.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from host.capture.blocks import UART_HEAD
from host.importers.series import EPOCHS_AT_ONCE, Portion, RawRecords, Rows, Series

RAW_TOPIC, RAW_SCHEMA = "/uart/gnss/rx", "navtwin.UartBlock"
MOST_BYTES = 1 << 16
"""Bytes without an epoch that are kept together."""


class LogRows:
    """Rows by their series. Times in ns of GPS time."""

    def __init__(self) -> None:
        self._rows: dict[Series, list[tuple[int, Sequence[float], int]]] = {}
        self._bytes = bytearray()
        self._records: list[tuple[int, Callable[[int], bytes]]] = []
        self._last_ns: int | None = None

    def add(self, series: Series, time_ns: int, row: Sequence[float], place: int) -> None:
        """A row."""
        self._rows.setdefault(series, []).append((time_ns, row, place))

    def read(self, data: bytes) -> None:
        """Further bytes of the log."""
        self._bytes += data
        if len(self._bytes) > MOST_BYTES and self._last_ns is not None:
            self.stamp(self._last_ns)

    def stamp(self, time_ns: int) -> None:
        """All bytes so far belong to this epoch. Records rise; one that leapt ahead comes down."""
        if self._leapt_ahead(time_ns):
            self._records[-1] = time_ns, self._records[-1][1]
        elif self._last_ns is not None:
            time_ns = max(time_ns, self._last_ns)
        self._last_ns = time_ns
        if self._bytes:
            self._records.append((time_ns, _uart_record(bytes(self._bytes))))
            self._bytes.clear()

    def _leapt_ahead(self, time_ns: int) -> bool:
        """Whether the last record alone lies behind this time."""
        times = [t_ns for t_ns, _ in self._records[-2:]]
        return bool(times) and times[-1] > time_ns and (len(times) == 1 or times[0] <= time_ns)

    def drain(self, is_last: bool = False) -> Iterator[Portion]:
        """What has come together; all of it at the end."""
        if is_last and self._last_ns is not None:
            self.stamp(self._last_ns)
        if self._records and (is_last or len(self._records) >= EPOCHS_AT_ONCE):
            yield RawRecords(RAW_TOPIC, RAW_SCHEMA, self._records)
            self._records = []
        for series, rows in self._rows.items():
            if rows and (is_last or len(rows) >= EPOCHS_AT_ONCE):
                times, values, places = zip(*rows, strict=True)
                yield Rows(
                    series,
                    np.array(times, dtype=np.int64),
                    np.array(values, dtype=np.float64),
                    np.array(places, dtype=np.int64),
                )
                rows.clear()


def _uart_record(data: bytes) -> Callable[[int], bytes]:
    return lambda t_ns: UART_HEAD.pack(t_ns, len(data)) + data
