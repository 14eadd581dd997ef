"""When attitude has gone for good, as it does once the rate was wrong for a while: only aligning helps then.

Asked at each reading of the compass. Lost is what

    compass and GPS both contradict for CONTRADICTIONS readings in a row
    a compass that works contradicts in MANY of WINDOW readings, BAD_WINDOWS times in a row
    no sample fits for LOST_NS: rates that no vehicle has
"""

from __future__ import annotations

from firmware.nav import layout
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.filters import Federation

CONTRADICTIONS = 30
WINDOW, MANY, BAD_WINDOWS = 50, 8, 4
"""The gate refuses one of a thousand by chance."""
LOST_NS = 2_000_000_000


class LostAttitude:
    """Watches one federation."""

    def __init__(self, federation: Federation) -> None:
        self._n = federation.n
        self._i = federation.master[1]
        self._contradictions = 0
        self._readings = self._refused = self._bad_windows = 0

    def look(self) -> bool:
        """Whether it has gone; called once for each reading."""
        unused_ns = int(self._i[layout.TIME] - self._i[layout.GOOD_SAMPLE_TIME])
        is_lost = self._both_contradict() or self._compass_contradicts() or unused_ns > LOST_NS
        if is_lost:
            self._contradictions = self._readings = self._refused = self._bad_windows = 0
        return is_lost

    def _both_contradict(self) -> bool:
        n = self._n
        isolated = n[gl.STATUS : gl.STATUS + 2].tolist() == [gl.ISOLATED, gl.ISOLATED]
        silent = gl.SILENT in n[gl.ISOLATED_BY : gl.ISOLATED_BY + 2].tolist()
        self._contradictions = self._contradictions + 1 if isolated and not silent else 0
        return self._contradictions >= CONTRADICTIONS

    def _compass_contradicts(self) -> bool:
        n = self._n
        self._readings += 1
        if self._readings >= WINDOW:
            refused, repeats = int(n[gl.REFUSED_MEASUREMENTS]), n[gl.REPEATS] >= n[gl.LIMIT_REPEATS]
            bad = refused - self._refused >= MANY and not repeats
            self._bad_windows = self._bad_windows + 1 if bad else 0
            self._refused, self._readings = refused, 0
        return self._bad_windows >= BAD_WINDOWS
