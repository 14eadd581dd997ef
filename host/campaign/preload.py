"""Imported once by the process that worker processes are forked from: all that a run needs is loaded there.

With a request in the environment, what comes before its virtual time is done too, so that compiled kernels
are loaded once for all workers.
"""

from __future__ import annotations

import base64
import contextlib
import os
import pickle

from host.campaign.work import settle_once
from host.run.runner import check

WARM_WITH = "NAVTWIN_WARM_WITH"


def _warm_up(text: str) -> None:
    """What is wrong with the request is told by whoever runs it."""
    with contextlib.suppress(Exception):
        check(pickle.loads(base64.b64decode(text)))
        settle_once()


if WARM_WITH in os.environ:
    _warm_up(os.environ.pop(WARM_WITH))
