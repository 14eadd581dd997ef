"""What calibration has found, at the FPGA: kept in flash, loaded at power-up, used in both modes.

Scales and offsets of the nine accelerometers go into `Corrections`, in whole numbers; all else is the DSP's
and goes there with the packets (`coefficients`): what the whole numbers leave of the offsets, misalignment,
matrix of the rates, deviation of the compass.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from struct import Struct
from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.apps.gfsins import coefficients
from firmware.apps.gfsins.accelerations import NOMINAL_SCALE
from firmware.apps.gfsins.calibration_store import CalibrationStore, Found, Sections
from firmware.apps.gfsins.corrections import AXES, LARGEST_OFFSET, WORD, Corrections, correction_of
from hal.flash import FlashMemory

CORRECTIONS, ACCELEROMETERS, RATES, DEVIATION, ELLIPSE, ALIGNMENT = range(1, 7)
"""Tags of the sections. Corrections are whole numbers, the others what the DSP gave."""
FORCE_PLACE: Final = 6 * AXES
SIZES: Final = {ACCELEROMETERS: FORCE_PLACE + 9, RATES: 24, DEVIATION: 10, ELLIPSE: 5, ALIGNMENT: 9}
"""Accelerometers: of each its response along its axis and along the other two, offset (m/s²), σ of the first
and of the offset; then the matrix of the three at the origin. Rates: matrix, bias, σ of the response (9) and
of the offset (3). Deviation: A … E and their σ (rad). Ellipse: soft iron xx, xy, yy, hard iron x, y (counts).
Alignment: yaw, pitch, roll (rad), six offsets (m/s²)."""
IDENTITY: Final = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
SIGNIFICANT: Final = 5.0
"""σ of a dozen turns: of nine elements, one that is off by three of them is no rarity."""
WHOLE: Final = Struct(f">{2 * AXES}i")


class Calibration:
    """Owns the store; `corrections` are those that the ticks use."""

    def __init__(self, flash: FlashMemory | None, corrections: Corrections) -> None:
        self.corrections = corrections
        self._store = None if flash is None else CalibrationStore(flash)
        self._sections: Sections = {}

    @property
    def found(self) -> Found:
        """What the store held."""
        return Found.NOTHING if self._store is None else self._store.found

    def load(self) -> None:
        """From flash, at power-up. What is not whole, or no number, leaves all at its nominal value."""
        self._nominal()
        if self._store is None:
            return
        self._sections = self._store.load()
        if not all(self._is_sound(tag) for tag in self._sections) or not self._apply_corrections():
            self._store.found = Found.SPOILT
            self._sections = {}
            self._nominal()

    def can_correct(self, found: Mapping[int, Sequence[float]]) -> bool:
        """Whether `corrections` have room for what a procedure has found."""
        return self._scales_and_offsets(found) is not None

    def keep(self, found: Mapping[int, Sequence[float]]) -> bool:
        """Take over what a procedure has found, and what `corrections` hold now. False: it is beyond what can
        be corrected, or not in flash, and all is as it was."""
        wanted = self._scales_and_offsets(found)
        if wanted is None:
            return False
        held = self.corrections
        before = held.scales.copy(), held.offsets.copy(), dict(self._sections)
        held.scales[:], held.offsets[:] = wanted
        if ACCELEROMETERS in found:
            for stale in (RATES, ALIGNMENT):
                self._sections.pop(stale, None)
        if DEVIATION in found:
            self._sections.pop(ELLIPSE, None)
        for tag, values in found.items():
            self._sections[tag] = Struct(f">{len(values)}f").pack(*values)
        if self.keep_corrections():
            return True
        held.scales[:], held.offsets[:], self._sections = before
        return False

    def keep_corrections(self) -> bool:
        """Into flash as they are."""
        held = self.corrections
        self._sections[CORRECTIONS] = WHOLE.pack(*held.scales.tolist(), *held.offsets.tolist())
        return self._store is not None and self._store.save(self._sections)

    def values(self, tag: int) -> tuple[float, ...]:
        """A section; empty when there is none."""
        data = self._sections.get(tag, b"")
        found: tuple[float, ...] = Struct(f">{len(data) // 4}f").unpack(data)
        return found

    @property
    def deviation(self) -> tuple[float, ...]:
        """A … E, rad."""
        return self.values(DEVIATION)[:5] or (0.0,) * 5

    @property
    def force_matrix(self) -> tuple[float, ...]:
        """Of the three accelerometers at the origin, row by row: their misalignment taken off."""
        return self.values(ACCELEROMETERS)[FORCE_PLACE:] or IDENTITY

    def packet_words(self) -> NDArray[np.int64] | None:
        """What the packets carry of it; None: there is nothing."""
        if self.found is Found.SPOILT:
            return np.array([(0, 0, 0, coefficients.SPOILT)], np.int64)
        if self._store is None or not self._sections:
            return None
        values = (*self.offset_remainders(), *self.force_matrix, *self.rate_matrix(), *self.deviation)
        return coefficients.packet_words(values, self._store.generation)

    def rate_matrix(self) -> list[float]:
        """Of the rates, row by row; elements that are not significantly off the nominal ones stay nominal."""
        found, matrix = self.values(RATES), list(IDENTITY)
        for k, sigma in enumerate(found[12:21]):
            if abs(found[k] - IDENTITY[k]) > SIGNIFICANT * sigma:
                matrix[k] = found[k]
        return matrix

    def offset_remainders(self) -> list[float]:
        """What the whole words leave of the offsets, m/s²; none where somebody has changed them by hand."""
        found = self.values(ACCELEROMETERS)
        left = [0.0] * AXES
        for k in range(AXES if found else 0):
            exact = found[6 * k + 3] / found[6 * k] / WORD
            rest = exact - int(self.corrections.offsets[k])
            left[k] = rest * WORD if abs(rest) <= 0.5 else 0.0
        return left

    def _scales_and_offsets(self, found: Mapping[int, Sequence[float]]) -> tuple[list[int], list[int]] | None:
        """Of `corrections`, with what was found; None: one of them is beyond the limits."""
        scales, offsets = self.corrections.scales.tolist(), self.corrections.offsets.tolist()
        if ACCELEROMETERS in found:
            axes = found[ACCELEROMETERS]
            made = [correction_of(axes[6 * k], axes[6 * k + 3]) for k in range(AXES)]
            if None in made:
                return None
            scales, offsets = map(list, zip(*filter(None, made), strict=True))
        if ALIGNMENT in found:
            for k, offset in enumerate(found[ALIGNMENT][3:]):
                offsets[k] += round(offset / WORD)
        return None if max(map(abs, offsets)) > LARGEST_OFFSET else (scales, offsets)

    def _nominal(self) -> None:
        for k in range(AXES):
            self.corrections.set_scale(k, NOMINAL_SCALE)
            self.corrections.set_offset(k, 0)

    def _apply_corrections(self) -> bool:
        numbers = WHOLE.unpack(self._sections[CORRECTIONS]) if CORRECTIONS in self._sections else ()
        taken = [self.corrections.set_scale(k, numbers[k]) for k in range(AXES if numbers else 0)]
        taken += [self.corrections.set_offset(k, numbers[AXES + k]) for k in range(AXES if numbers else 0)]
        return all(taken)

    def _is_sound(self, tag: int) -> bool:
        data = self._sections[tag]
        if tag == CORRECTIONS:
            return len(data) == WHOLE.size
        return len(data) == 4 * SIZES.get(tag, 0) and all(math.isfinite(x) for x in self.values(tag))
