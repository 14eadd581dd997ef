"""Imported once by the process that worker processes are made from: all that a run needs."""

from __future__ import annotations

from host.campaign import work
from host.run import runner

__all__ = ["runner", "work"]
