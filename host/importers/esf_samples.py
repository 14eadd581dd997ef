"""Inertial samples in UBX-ESF-MEAS and UBX-ESF-RAW (u-blox receivers with sensors of their own).

    measurement u32: bits 0–23 value, signed; bits 24–29 type: 14 13 5 gyro x y z, 2⁻¹² °/s; 16 17 18
    accelerometer x y z, 2⁻¹⁰ m/s²; 12 gyro temperature, 0.01 °C

Their time tags count on the sensor's own clock. It is laid on GPS time by the order of messages in the log:
before the solution of an epoch T come samples up to the moment at which it was sent, so T − tag is the
clocks' difference less the solution's latency; the largest of the first epochs is taken. ESF-RAW does not
document the unit of its tags: 1 ms or 39.0625 µs, whichever the epochs agree with.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from host.importers import topics
from host.importers.findings import Findings, Kind
from host.importers.log_rows import LogRows
from host.importers.series import at_byte
from host.importers.time_base import NS

MEAS, RAW = (0x10, 0x02), (0x10, 0x03)
GYROS, ACCELS, WARMTH = (14, 13, 5), (16, 17, 18), 12
EPOCHS_FOR_CLOCK = 20
LEAST_EPOCHS = 3
TAG_UNITS_NS = {MEAS: (1_000_000.0,), RAW: (1_000_000.0, 39_062.5)}
AGREE = 0.02


@dataclass(slots=True)
class _Sample:
    tag: int
    values: dict[int, int]
    place: int


class EsfSamples:
    """Samples of one kind of message in one log."""

    def __init__(
        self, kind: tuple[int, int], name: str, file: str, rows: LogRows, findings: Findings
    ) -> None:
        self._kind = kind
        self._name = name
        self._file = file
        self._rows = rows
        self._findings = findings
        self._series = topics.samples(name, file, at_byte)
        self._open: _Sample | None = None
        self._waiting: list[_Sample] = []
        self._pairs: list[tuple[int, int]] = []
        self._clock: tuple[float, float] | None = None
        self._turns = 0
        self._last_tag = -1
        self._is_lost = False

    def take(self, payload: bytes, place: int) -> None:
        """The payload of a message."""
        for tag, data in _measurements(self._kind, payload):
            kind, value = (data >> 24) & 0x3F, data & 0xFFFFFF
            value -= (value & 0x800000) << 1
            whole = self._unrolled(tag)
            if self._open is not None and self._open.tag != whole:
                self._hand_on(self._open)
                self._open = None
            if self._open is None:
                self._open = _Sample(whole, {}, place)
            self._open.values[kind] = value

    def epoch(self, gps_ns: int) -> None:
        """A solution of this time has come."""
        if self._clock is None and self._open is not None and not self._is_lost:
            self._pairs.append((self._open.tag, gps_ns))
            if len(self._pairs) >= EPOCHS_FOR_CLOCK:
                self._set_clock()

    def finish(self) -> None:
        """The log has ended."""
        if self._open is not None:
            self._hand_on(self._open)
            self._open = None
        if self._clock is None and self._waiting:
            self._set_clock()

    def _unrolled(self, tag: int) -> int:
        modulus = 1 << 24 if self._kind == RAW and self._last_tag < 1 << 24 else 1 << 32
        if tag < self._last_tag - modulus // 2:
            self._turns += modulus
        self._last_tag = tag
        return self._turns + tag

    def _hand_on(self, sample: _Sample) -> None:
        if not all(kind in sample.values for kind in (*GYROS, *ACCELS)):
            return
        if self._clock is None:
            if not self._is_lost:
                self._waiting.append(sample)
            return
        unit_ns, zero_ns = self._clock
        warmth = sample.values.get(WARMTH)
        row = (
            *(sample.values[kind] / 4096.0 for kind in GYROS),
            *(sample.values[kind] / 1024.0 for kind in ACCELS),
            math.nan if warmth is None else warmth * 0.01,
        )
        self._rows.add(self._series, round(zero_ns + sample.tag * unit_ns), row, sample.place)

    def _set_clock(self) -> None:
        waiting, self._waiting = self._waiting, []
        unit_ns = self._unit()
        if unit_ns is None:
            self._is_lost = True
            text = f"its time tags do not go with the epochs ({len(self._pairs)} of them); left out"
            self._findings.note(Kind.NO_TIME, self._file, f"/imu/{self._name}", count=len(waiting), text=text)
            return
        differences = [gps_ns - tag * unit_ns for tag, gps_ns in self._pairs]
        self._clock = unit_ns, max(differences)
        spread = (max(differences) - min(differences)) / NS
        unit = f"{unit_ns / 1e6:g} ms"
        text = f"time tags of {unit} laid on GPS time by the order of messages, spread {spread:.3g} s"
        self._findings.note(Kind.NOTE, self._file, f"/imu/{self._name}", text=text)
        for sample in waiting:
            self._hand_on(sample)

    def _unit(self) -> float | None:
        if len(self._pairs) < LEAST_EPOCHS:
            return None
        (tag0, t0), (tag1, t1) = self._pairs[0], self._pairs[-1]
        if tag1 <= tag0:
            return None
        found = (t1 - t0) / (tag1 - tag0)
        return next((unit for unit in TAG_UNITS_NS[self._kind] if abs(found / unit - 1.0) < AGREE), None)


def _measurements(kind: tuple[int, int], payload: bytes) -> list[tuple[int, int]]:
    """(time tag, measurement) of a message."""
    if kind == RAW:
        count = max(len(payload) - 4, 0) // 8
        numbers = struct.unpack_from(f"<{2 * count}I", payload, 4) if count else ()
        return list(zip(numbers[1::2], numbers[0::2], strict=True))
    if len(payload) < 8:
        return []
    tag, flags = struct.unpack_from("<IH", payload)
    count = min(flags >> 11 & 0x1F, (len(payload) - 8) // 4)
    return [(tag, data) for data in struct.unpack_from(f"<{count}I", payload, 8)]
