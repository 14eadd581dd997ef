"""Which epochs count: one rule for the fused solution and for the receiver alone.

A board without a receiver is scored on all its navigation solutions from the end of the alignment on.

An epoch of the receiver counts when its fix is valid, at least `after_reacquisition_s` after the first fix
that followed a gap, and at least `after_alignment_s` after the board first reported navigation. Alignment is
taken once: a board that falls back to alignment later gains no new grace (see `availability`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

FIX_GAP_S = 2.5
"""Longer without a valid fix, and the next one is a re-acquisition."""

ROUNDING_S = 1e-6


@dataclass(frozen=True, slots=True)
class ScoringRules:
    """Grace periods in s, and whether the board has a receiver at whose epochs it is scored."""

    after_reacquisition_s: float = 10.0
    after_alignment_s: float = 60.0
    at_receiver_epochs: bool = True


class FixHistory:
    """Follows the receiver's epochs in the order of time and tells which of them count."""

    def __init__(self, rules: ScoringRules) -> None:
        self._rules = rules
        self._first_fix_s = math.inf
        self._last_fix_s = -math.inf

    def take(self, t: float, fix: bool, aligned_at_s: float) -> bool:
        """Note the epoch valid at `t` and tell whether it counts."""
        if not fix:
            self._last_fix_s = -math.inf
            return False
        if t - self._last_fix_s > FIX_GAP_S:
            self._first_fix_s = t
        self._last_fix_s = t
        settled = t - self._first_fix_s >= self._rules.after_reacquisition_s - ROUNDING_S
        return settled and t - aligned_at_s >= self._rules.after_alignment_s - ROUNDING_S
