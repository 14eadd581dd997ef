"""Looks through the rows of one series: what is not sound is left out and told, nothing is put in its place.

Left out are rows with a needed value that is no finite number, with a value that cannot be, with the time of
the row before (duplicates) or an earlier one, and single rows whose time leaps ahead of its neighbours. Kept
and told are gaps, leaps of the time that the rows after them share, and channels that stand still.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.importers.findings import Findings, Kind
from host.importers.series import Floats, Integers, Rows, Series
from host.importers.standstill import Standstill
from host.importers.time_base import DAY_NS, NS
from host.record.errors import UserError

Mask = NDArray[np.bool_]

STEADY, UNSTEADY = 1.75, 5.0
"""A step this many times the usual one is a gap: of a sensor with steady steps, and of one without."""
MOST_LEFT_OUT = 0.5
LEAST_ROWS_FOR_STEP = 8
LEADING_ROWS = 100
"""A leap of more than a day among so many first rows: the clock had not been set before it."""


class Inspection:
    """One series. `take` gives the sound rows of a portion, one of which it may hold back."""

    def __init__(self, series: Series, findings: Findings) -> None:
        self.series = series
        self.taken = 0
        self.kept = 0
        self._findings = findings
        self._needed = series.columns(*series.needed)
        self._limits = [(name, series.columns(name)[0], *limit) for name, limit in series.limits.items()]
        self._standstill = Standstill(series, findings)
        self._held: Rows | None = None
        self._last_ns: int | None = None
        self._step_ns = 0.0
        self._gap_factor = STEADY
        self._impossible = 0
        self._lost = 0
        """Rows left out for their time."""

    def take(self, rows: Rows) -> Rows:
        """The sound ones of these rows."""
        self.taken += len(rows)
        sound = self._of_sound_values(rows)
        if not self.series.is_paced:
            self.kept += len(sound)
            return sound
        if self._held is not None:
            sound = _joined(self._held, sound)
        return self._hand_on(sound, hold_last=True)

    def finish(self) -> Rows | None:
        """What was held back. Raises UserError when most rows had to be left out for their times."""
        rest = None
        if self._held is not None:
            rest = self._hand_on(self._held, hold_last=False)
        self._standstill.finish()
        if self._impossible > MOST_LEFT_OUT * self.taken:
            told = next(f.line() for f in self._findings.all if f.kind is Kind.IMPLAUSIBLE)
            raise UserError(
                f"{self.series.file}: {self.series.topic}: what {self._impossible:,} of {self.taken:,} rows"
                f" tell cannot be ({told}): another column, unit or scale than named"
            )
        if self._lost > MOST_LEFT_OUT * self.taken:
            first = next((f for f in self._findings.all if f.kind in (Kind.BACK, Kind.JUMP)), None)
            told = f" ({first.line()})" if first is not None else ""
            raise UserError(
                f"{self.series.file}: {self.series.topic}: the time of {self._lost:,} of {self.taken:,} rows"
                f" does not go on{told}: these are several recordings, or the time column is another one;"
                " import each part by itself"
            )
        return rest

    def _hand_on(self, rows: Rows, hold_last: bool) -> Rows:
        self._held = None
        if hold_last and len(rows) > 1:
            self._held = rows.only(np.arange(len(rows)) == len(rows) - 1)
        elif hold_last:
            self._held = rows if len(rows) else None
            return rows.only(np.zeros(len(rows), dtype=bool))
        keep = self._of_rising_time(rows, len(rows) - (self._held is not None))
        kept = rows.only(keep)
        if len(kept):
            kept = self._without_unset_clock(kept)
            self._look_for_gaps(kept)
            self._standstill.take(kept)
            self._last_ns = int(kept.times_ns[-1])
        self.kept += len(kept)
        return kept

    # -- values ------------------------------------------------------------------------------------

    def _of_sound_values(self, rows: Rows) -> Rows:
        values = rows.values
        missing = np.asarray(np.isinf(values).any(axis=1))
        if self._needed:
            missing = missing | ~np.isfinite(values[:, self._needed]).all(axis=1)
        if missing.any():
            self._tell_missing(rows, missing)
        keep: Mask = np.logical_not(missing)
        for name, column, low, high in self._limits:
            found = keep & ((values[:, column] < low) | (values[:, column] > high))
            if found.any():
                self._tell(Kind.IMPLAUSIBLE, name, rows, found, values[:, column], "left out")
                keep &= ~found
                self._impossible += int(np.count_nonzero(found))
        return rows if keep.all() else rows.only(keep)

    def _tell_missing(self, rows: Rows, missing: Mask) -> None:
        names = self.series.table.columns[1:]
        for column in range(rows.values.shape[1]):
            bad = (
                ~np.isfinite(rows.values[:, column])
                if column in self._needed
                else np.isinf(rows.values[:, column])
            )
            if (found := missing & bad).any():
                self._tell(Kind.NOT_FINITE, names[column], rows, found, rows.values[:, column], "left out")

    def _tell(
        self, kind: Kind, channel: str, rows: Rows, found: Mask, values: Floats | None, text: str
    ) -> None:
        which = np.flatnonzero(found)
        cases = [
            (self.series.place(int(rows.places[i])), "" if values is None else float(values[i]))
            for i in which[:5]
        ]
        self._findings.note(kind, self.series.file, _named(self.series, channel), cases, len(which), text)

    # -- times -------------------------------------------------------------------------------------

    def _of_rising_time(self, rows: Rows, count: int) -> Mask:
        """Which of the first `count` rows go on in time; the one behind them is only looked at."""
        t = rows.times_ns
        before = self._last_ns if self._last_ns is not None else int(t[0]) - 1
        keep = np.arange(len(t)) < count
        if (np.diff(t, prepend=before) > 0).all():
            return keep
        times = t.tolist()
        for i, now in enumerate(times[:count]):
            if now <= before:
                keep[i] = False
                self._tell_back(rows, i, now, before)
                continue
            ahead = now - before > max(UNSTEADY * self._step_ns, NS)
            if ahead and i + 1 < len(times) and before < times[i + 1] < now:
                keep[i] = False
                self._lost += 1
                case = (self.series.place(int(rows.places[i])), f"{(now - before) / NS:+.6g} s for one row")
                self._findings.note(Kind.JUMP, self.series.file, self.series.topic, [case], text="left out")
                continue
            before = now
        return keep

    def _tell_back(self, rows: Rows, i: int, now: int, before: int) -> None:
        self._lost += 1
        place = self.series.place(int(rows.places[i]))
        if now == before:
            text = "left out"
            self._findings.note(
                Kind.DUPLICATE, self.series.file, self.series.topic, [(place, "the same time")], text=text
            )
            self._lost -= 1
            return
        case = (place, f"{(now - before) / NS:.6g} s")
        self._findings.note(Kind.BACK, self.series.file, self.series.topic, [case], text="left out")

    def _without_unset_clock(self, rows: Rows) -> Rows:
        """Drop the first rows when the time leaps by more than a day behind them."""
        if self.kept or len(rows) < 2:
            return rows
        steps = np.diff(rows.times_ns[:LEADING_ROWS])
        leaps = np.flatnonzero(steps > DAY_NS)
        if not len(leaps):
            return rows
        begin = int(leaps[-1]) + 1
        self._lost += begin
        case = (self.series.place(int(rows.places[begin])), f"{steps[begin - 1] / NS:+.6g} s")
        text = f"{begin} rows before it left out: the clock had not been set"
        self._findings.note(Kind.JUMP, self.series.file, self.series.topic, [case], text=text)
        return rows.only(np.arange(len(rows)) >= begin)

    def _look_for_gaps(self, rows: Rows) -> None:
        before = self._last_ns
        t = rows.times_ns if before is None else np.concatenate(([before], rows.times_ns))
        steps = np.diff(t).astype(np.float64)
        if not len(steps):
            return
        if len(steps) >= LEAST_ROWS_FOR_STEP:
            self._step_ns = float(np.median(steps))
            scatter = float(np.quantile(np.abs(steps / self._step_ns - 1.0), 0.75))
            self._gap_factor = STEADY if scatter < 0.2 else UNSTEADY
        if not self._step_ns:
            return
        found = np.flatnonzero(steps > self._gap_factor * self._step_ns)
        offset = 0 if before is not None else 1
        for kind, which in (
            (Kind.JUMP, found[steps[found] > DAY_NS]),
            (Kind.GAP, found[steps[found] <= DAY_NS]),
        ):
            if len(which):
                self._tell_gaps(kind, rows, which + offset, steps[which])

    def _tell_gaps(self, kind: Kind, rows: Rows, which: Integers, steps: Floats) -> None:
        cases = [
            (self.series.place(int(rows.places[i])), f"{step / NS:.6g} s after the row before")
            for i, step in zip(which[:5].tolist(), steps[:5].tolist(), strict=True)
        ]
        text = f"usual step {self._step_ns / NS:.6g} s; nothing was put there"
        self._findings.note(kind, self.series.file, self.series.topic, cases, len(which), text)


def _named(series: Series, channel: str) -> str:
    return f"{series.topic} {channel}"


def _joined(one: Rows, other: Rows) -> Rows:
    return Rows(
        one.series,
        np.concatenate((one.times_ns, other.times_ns)),
        np.vstack((one.values, other.values)),
        np.concatenate((one.places, other.places)),
    )
