"""One figure of ours beside the document's."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Figure:
    """What was measured, and what it must be: `least` to `most`."""

    part: str
    what: str
    unit: str
    ours: float
    document: str = ""
    least: float | None = None
    most: float | None = None

    @property
    def met(self) -> bool | None:
        """Whether it is what it must be; None: it is only told."""
        if self.least is None and self.most is None:
            return None
        above = self.least is None or self.ours >= self.least
        return bool(above and (self.most is None or self.ours <= self.most))
