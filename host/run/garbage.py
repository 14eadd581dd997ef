"""The collector of cycles stays out of a run's way.

What exists when virtual time begins stays to its end, and the loop makes next to no cycles: the collector
would look at the waiting frames again and again, for a tenth of the time. A single run freezes what there
is. A process that runs many boards one after another calls `settle` once it is warm: what lives by then
(libraries, compiled kernels: hundreds of thousands of objects, which take 0.2 s to look through) is frozen
for good, and between two runs only what the last one left is looked at.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

YOUNG = 1
"""Generations that are looked through between two chunks of a run."""

_settled = False
_ran = False
"""Whether an earlier run of this process may have left something; libraries leave next to nothing."""


def settle() -> None:
    """Everything that lives now stays to the end of this process."""
    global _settled
    gc.collect()
    gc.freeze()
    _settled = True


def collect_young() -> None:
    """Take away what cycles the last chunk of a run has left."""
    gc.collect(YOUNG)


@contextmanager
def undisturbed() -> Iterator[None]:
    """The collector works inside when `collect_young` is called, and then on what is new only."""
    global _ran
    if _ran:
        gc.collect()
    _ran = True
    if not _settled:
        gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        if not _settled:
            gc.unfreeze()
