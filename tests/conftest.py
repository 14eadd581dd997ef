"""How the tests are shared out among worker processes (`pytest -n 2`).

A folder goes to one worker as a whole: its tests share runs, compiled kernels and imports, which two workers
would make twice. What takes long begins first, so that both workers end together.
"""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import settings

settings.register_profile("suite", max_examples=60)
settings.load_profile("suite")

LONGEST_FIRST = (
    "dialect", "sim", "run", "serve", "nav", "live", "replay", "campaign", "compare", "docs", "attach",
    "importers", "dual_antenna", "gfsins", "gyro_free", "drift", "pil", "uav_ahrs",
    "plugin", "numerics", "chips", "host", "monitor", "waves",
)  # fmt: skip
"""Folders by their time, waiting for clocks included; those that only compute before those that keep pace
with a clock, while mypy runs beside them; all others come after them by name."""

SAME_WORKER = {"live": "serve"}
"""Both speak CAN over multicast, where whoever listens on a port hears every group: never at once."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    if config.getoption("dist") != "load":
        return None
    from xdist.scheduler import LoadScopeScheduling

    class ByFolder(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            folder = folder_of(nodeid)
            return SAME_WORKER.get(folder, folder)

    config.option.loadscopereorder = False
    return ByFolder(config, log)


def pytest_collection_finish() -> None:
    """What was imported and collected stays: without this each run of a board would look through it first."""
    from host.run.garbage import settle

    settle()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: place_of(folder_of(item.nodeid)))


def folder_of(nodeid: str) -> str:
    return nodeid.partition("::")[0].rpartition("/")[0].removeprefix("tests/").partition("/")[0]


def place_of(folder: str) -> int:
    return LONGEST_FIRST.index(folder) if folder in LONGEST_FIRST else len(LONGEST_FIRST)
