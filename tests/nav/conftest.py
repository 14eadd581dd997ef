"""Drives that several tests share; each makes its own copy of the part it spoils."""

import pytest
from nav_drive import Drive, make_drive


@pytest.fixture(scope="session")
def town() -> Drive:
    """The first 200 s of town-open: a rest of 75 s, straight starts, turns, a stop at 160 s."""
    return make_drive("town-open", 1, duration_s=200.0)
