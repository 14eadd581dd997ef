"""A whole calibration: settings mode on the table, the store, power-ups without and with what it holds."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from boards.description import load_board
from boards.hints import did_you_mean
from firmware.apps.gfsins import calibration as store
from firmware.apps.gfsins.positions import NAMES
from hal.emulated.virtual_time import SECOND
from host.calibrate.judging import (
    Judged,
    judge_accelerometers,
    judge_alignment,
    judge_compass,
    judge_earth_rate,
    judge_rates,
)
from host.calibrate.operator import Account, Operator
from host.calibrate.store_image import FLASH, calibration_in
from host.calibrate.table_world import TableWorld, level
from host.calibrate.true_errors import nine_axes
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.readiness import prepared
from host.run.session import RunSession, manifest_of, session_in_world
from host.run.setup import Setup
from host.sim.earth import gravity
from host.sim.trajectory.kinematics import HEIGHT, LATITUDE

USUAL = ("accelerometers", "rates", "compass", "alignment")
POWER_UP_HEADINGS = (100, 280)
POWER_UP_S = 16.0
ALIGNED = re.compile(r"aligned: heading, pitch, roll ([-\d.]+), ([-\d.]+), ([-\d.]+) deg")
LOADED = "calibration loaded"
BETTER = 0.5
"""Of the heading's error at power-up, where the compass has a deviation at all."""
SMALL_DEG = 1.0
EXPECTED_S = {
    "accelerometers": 48.0,
    "rates": 138.0,
    "earth-rate": 121.0,
    "compass": 61.0,
    "ellipse": 62.0,
    "alignment": 6.0,
}
Progress = Callable[[float, float], None]


@dataclass(frozen=True, slots=True)
class PowerUp:
    """Acquisition begun at a heading, without and with the store."""

    heading_deg: float
    nominal_error_deg: float
    calibrated_error_deg: float
    loaded: bool
    """The firmware said so."""

    @property
    def ok(self) -> bool:
        """The store was taken, and the heading is no worse for it."""
        limit = max(SMALL_DEG, BETTER * abs(self.nominal_error_deg))
        return self.loaded and abs(self.calibrated_error_deg) <= limit


@dataclass
class Outcome:
    """What there is to tell."""

    request: RunRequest
    scenario: str = ""
    profile: str = ""
    duration_s: float = 0.0
    procedures: list[Judged] = field(default_factory=list)
    power_ups: list[PowerUp] = field(default_factory=list)
    content: bytes = b""
    """Of the flash."""

    @property
    def met(self) -> bool:
        """All of it."""
        return all(one.met for one in self.procedures) and all(one.ok for one in self.power_ups)


def procedures_of(asked: Sequence[str]) -> tuple[str, ...]:
    """In the order in which they make sense. Raises UserError."""
    if not asked:
        return USUAL
    for name in asked:
        if name not in (*NAMES, "all"):
            raise UserError(f"procedure {name!r}: there is none; {did_you_mean(name, (*NAMES, 'all'))}")
    return NAMES if "all" in asked else tuple(name for name in NAMES if name in asked)


def calibrate(request: RunRequest, names: Sequence[str], progress: Progress | None = None) -> Outcome:
    """All of it. Raises UserError."""
    _check_board(request)
    request = replace(request, scenario=request.scenario or "turntable", capture=False, out_dir=None)
    setup, world = _prepared(request, "settings")
    outcome = Outcome(request, setup.scenario.name, setup.profile_name)
    whole_s = 3.0 + sum(EXPECTED_S[name] for name in names) + 2 * len(POWER_UP_HEADINGS) * POWER_UP_S
    with session_in_world(request, setup, world, manifest_of(request, setup)) as session:
        operator = Operator(session, world, None if progress is None else lambda s: progress(s, whole_s))
        operator.wait_for_menu()
        for name in names:
            account = operator.calibrate(name)
            outcome.procedures.append(_judged(account, session, world, setup))
        outcome.content = session.board.flash[FLASH].content
        outcome.duration_s = session.now_ns / SECOND
    if {"compass", "ellipse"} & set(names):
        for heading in POWER_UP_HEADINGS:
            outcome.power_ups.append(_power_up(request, heading, outcome.content))
            if progress is not None:
                progress(outcome.duration_s + 2.0 * len(outcome.power_ups) * POWER_UP_S, whole_s)
    return outcome


def _check_board(request: RunRequest) -> None:
    board = load_board(request.board)
    if FLASH not in board.flash:
        raise UserError(
            f"board {board.name} keeps no calibration (it has no flash called {FLASH!r}); gfsins does"
        )


def _prepared(request: RunRequest, mode: str) -> tuple[Setup, TableWorld]:
    setup, world = prepared(replace(request, overrides=(*request.overrides, f"panel.mode={mode}")))
    if setup.scenario.panel.keys:
        raise UserError(
            f"scenario {setup.scenario.name}: panel.keys are pressed while a board is calibrated by its keys;"
            " leave them out, as in the scenario turntable"
        )
    scenario = world.scenario if mode == "settings" else world.scenario.model_copy(update={"fault": []})
    return setup, TableWorld(scenario, request.seed)


def _judged(account: Account, session: RunSession, world: TableWorld, setup: Setup) -> Judged:
    if not account.done:
        return Judged(account)
    if account.name == "earth-rate":
        return judge_earth_rate(account)
    found = calibration_in(session.board.flash[FLASH].content, setup.board)
    middle_ns = session.now_ns - round(account.took_s * SECOND / 2.0)
    true = nine_axes(world, setup.board, middle_ns)
    if account.name == "accelerometers":
        return judge_accelerometers(account, found, true, _gravity(world))
    if account.name == "rates":
        return judge_rates(account, found, true)
    if account.name == "alignment":
        both = bool(found.values(store.ACCELEROMETERS) and found.values(store.DEVIATION))
        return judge_alignment(account, found, both)
    return judge_compass(account, found, world)


def _gravity(world: TableWorld) -> float:
    here = world.table.looked_at(np.zeros(1, np.int64))[0]
    return float(gravity(math.sin(here[LATITUDE]), here[HEIGHT]))


def _power_up(request: RunRequest, heading_deg: int, content: bytes) -> PowerUp:
    errors: list[float] = []
    loaded = False
    blank = b"\xff" * len(content)
    for held in (blank, content):
        setup, world = _prepared(request, "acquisition")
        world.table.turn_to(level(math.radians(heading_deg) + world.declination), 0)
        with session_in_world(request, setup, world, manifest_of(request, setup)) as session:
            session.board.flash[FLASH].load(held)
            session.run_until(round(POWER_UP_S * SECOND))
            texts = _texts(session)
        told = next((match for match in map(ALIGNED.search, texts) if match), None)
        true = heading_deg + math.degrees(world.declination)
        errors.append(math.remainder(float(told.group(1)) - true, 360.0) if told else math.nan)
        loaded = any(LOADED in text for text in texts)
    return PowerUp(heading_deg, errors[0], errors[1], loaded)


def _texts(session: RunSession) -> list[str]:
    result: Any = session.finish(1.0, judged=False)
    return [event.text for event in result.events]
