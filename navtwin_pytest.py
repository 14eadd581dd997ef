"""The pytest plugin: fixture `navtwin_run` and marker `navtwin`, told in docs/ci.md.

pytest loads this module wherever navtwin is installed. So it stands by itself, under a name that no project
has, and imports nothing but pytest: a project that does not use it, or has folders called `host` or `boards`
of its own, notices nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from host.pytest_plugin.asking import Asking

MARKER = (
    "navtwin(board, scenario, profile, seed, overrides, faults, data): what navtwin_run() runs;"
    " the mark nearest to the test goes first"
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--navtwin-out DIR`."""
    parser.getgroup("navtwin").addoption(
        "--navtwin-out",
        metavar="DIR",
        help="keep report.html and the figures of each run of navtwin_run below DIR",
    )


def pytest_configure(config: pytest.Config) -> None:
    """The marker, for --strict-markers and --markers."""
    config.addinivalue_line("markers", MARKER)


@pytest.fixture
def navtwin_run(request: pytest.FixtureRequest) -> Asking:
    """Call it to run a board: `navtwin_run(seed=3).expect(yaw_rms_deg=1.5)`. Equal runs are made once."""
    from host.pytest_plugin.asking import Asking

    return Asking(request)
