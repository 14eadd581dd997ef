"""What can be done to a served board from outside: one JSON object in, one out.

    {"command": "inject", "kind": "uart-cut", "target": "gnss", "duration_s": 5}
    {"ok": true, "command": "inject", "time_s": 12.34, "name": "uart-cut gnss"}

Every command that is understood goes into the capture's topic /control with its virtual time, so that a
replay does it again. An error is told with what is wrong and an example; nothing has happened then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import ValidationError

from boards.hints import did_you_mean
from hal.emulated.virtual_time import SECOND
from host.record.errors import UserError
from host.record.result import finite_or_none
from host.run.faults import Placed, name_of, place_now
from host.run.panel import Panel
from host.run.session import RunSession
from host.serve.pacing import FASTEST, SLOWEST, PacedRun
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.panel_schema import HELD_S, SHORTEST_S
from host.sim.scenario.schema import Fault

Reply = dict[str, Any]
LONGEST_HELD_S = 3600.0
DEEPEST = 8
"""Levels of lists and objects in a command."""
POSITION = {"latitude_deg": (-89.0, 89.0), "longitude_deg": (-180.0, 180.0), "height_m": (-1000.0, 1e5)}
FAULT_KEYS = ("kind", "target", "duration_s", "name", "parameters")

EXAMPLES: dict[str, dict[str, Any]] = {
    "pause": {},
    "resume": {},
    "pace": {"pace": 2.0},
    "position": {"latitude_deg": 48.137, "longitude_deg": 11.575, "height_m": 519.0},
    "inject": {"kind": "uart-cut", "target": "gnss", "duration_s": 5.0},
    "clear": {"name": "uart-cut gnss"},
    "press": {"key": "OK", "held_s": 0.15},
    "screen": {},
    "metrics": {},
    "status": {},
    "stop": {},
}
"""Every command with arguments that are valid."""
OPTIONAL = {"held_s": HELD_S}
"""Arguments that may be left out, and what they are then."""


class Commands:
    """Does what is asked of one served session. `status` tells how it goes."""

    def __init__(self, session: RunSession, paced: PacedRun, status: Callable[[], Reply]) -> None:
        self._session = session
        self._paced = paced
        self._status = status
        self._actions: dict[str, Callable[[Mapping[str, Any]], Reply]] = {
            "pause": lambda _asked: self._done(paced.pause),
            "resume": lambda _asked: self._done(paced.resume),
            "pace": self._pace,
            "position": self._position,
            "inject": self._inject,
            "clear": self._clear,
            "press": self._press,
            "screen": self._screen,
            "metrics": self._metrics,
            "status": lambda _asked: self._status(),
            "stop": lambda _asked: self._done(paced.stop),
        }

    def do(self, asked: Any) -> Reply:
        """Do it; the reply is made for JSON."""
        if _is_deeper(asked, DEEPEST):
            told = f"a command holds at most {DEEPEST} levels of lists and objects"
            return {"ok": False, "error": told, "example": example_of(None)}
        name = asked.get("command") if isinstance(asked, dict) else None
        tag = {"id": asked["id"]} if isinstance(asked, dict) and "id" in asked else {}
        try:
            if not isinstance(asked, dict):
                raise UserError(f"a command is an object, not {type(asked).__name__}")
            if not isinstance(name, str) or name not in self._actions:
                hint = did_you_mean(str(name), self._actions)
                raise UserError(f"there is no command {name!r}; {hint}")
            arguments = {key: value for key, value in asked.items() if key not in ("command", "id")}
            self._check_keys(name, arguments)
            now_ns = self._session.now_ns
            reply = self._actions[name](arguments)
            return finite_or_none({"ok": True, "command": name, "time_s": now_ns / SECOND, **reply, **tag})
        except UserError as error:
            return {"ok": False, "error": str(error), "example": example_of(name), **tag}

    def log(self, command: str, details: Mapping[str, Any]) -> None:
        """Into the capture, with the present instant."""
        if self._session.recorder.capture is not None:
            self._session.recorder.capture.control(self._session.now_ns, command, details)

    def _check_keys(self, name: str, arguments: Mapping[str, Any]) -> None:
        known = FAULT_KEYS if name == "inject" else tuple(EXAMPLES[name])
        for key in arguments:
            if key not in known:
                hint = did_you_mean(key, known) if known else "it takes none"
                raise UserError(f"{name}: there is no argument {key!r}; {hint}")
        if name != "inject":
            for key in known:
                if key not in arguments and key not in OPTIONAL:
                    raise UserError(f"{name}: the argument {key!r} is missing")
        if name in ("pause", "resume", "screen", "metrics", "status", "stop"):
            self.log(name, {})

    # -- pace --------------------------------------------------------------------------------------

    def _done(self, action: Callable[[], None]) -> Reply:
        action()
        return {}

    def _pace(self, asked: Mapping[str, Any]) -> Reply:
        pace = _number(asked, "pace", 0.0, FASTEST)
        check_pace(pace, "pace")
        self.log("pace", {"pace": pace})
        self._paced.set_pace(pace)
        return {"pace": pace}

    # -- the vehicle -------------------------------------------------------------------------------

    def _position(self, asked: Mapping[str, Any]) -> Reply:
        place = {key: _number(asked, key, *limits) for key, limits in POSITION.items()}
        radians = math.radians(place["latitude_deg"]), math.radians(place["longitude_deg"])
        try:
            self._session.world.put_down(self._session.now_ns, *radians, place["height_m"])
        except ScenarioError as error:
            raise UserError(str(error)) from None
        self.log("position", place)
        return place

    # -- faults ------------------------------------------------------------------------------------

    def _inject(self, asked: Mapping[str, Any]) -> Reply:
        session = self._session
        try:
            fault = Fault.model_validate({**asked, "at_s": session.now_ns / SECOND})
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise UserError(f"inject: {where}: {first['msg'][:1].lower()}{first['msg'][1:]}") from None
        fault = fault.model_copy(update={"name": self._free_name(fault)})
        sights = session.surroundings.sights
        placed = place_now(fault, session.board, sights, session.request.seed)
        session.faults.append(placed)
        described = {key: value for key, value in fault.model_dump().items() if value is not None}
        self.log("inject", {"fault": described})
        return {"name": fault.name}

    def _free_name(self, fault: Fault) -> str:
        taken = {name_of(placed.fault) for placed in self._session.faults}
        if fault.name is not None:
            if fault.name in taken:
                raise UserError(f"inject: a fault is called {fault.name!r} already; give it another name")
            return fault.name
        wanted, number = name_of(fault), 1
        while (name := wanted if number == 1 else f"{wanted} {number}") in taken:
            number += 1
        return name

    def _clear(self, asked: Mapping[str, Any]) -> Reply:
        placed = self._placed(asked["name"])
        if placed.lift is None:
            raise UserError(
                f"clear: {asked['name']!r} is a {placed.fault.kind}, which is over by itself;"
                " nothing is there to be cleared"
            )
        placed.lift()
        self.log("clear", {"name": asked["name"]})
        return {"name": asked["name"], "fired": placed.fired()}

    def _placed(self, name: Any) -> Placed:
        faults = {name_of(placed.fault): placed for placed in self._session.faults}
        if not isinstance(name, str) or name not in faults:
            hint = did_you_mean(str(name), faults) if faults else "none has been injected"
            raise UserError(f"clear: there is no fault {name!r}; {hint}")
        return faults[name]

    # -- the operator ------------------------------------------------------------------------------

    def _press(self, asked: Mapping[str, Any]) -> Reply:
        held_s = _number({**OPTIONAL, **asked}, "held_s", SHORTEST_S, LONGEST_HELD_S)
        key = asked["key"]
        if not isinstance(key, str):
            raise UserError(f'press: key = {key!r} is no text; for example "OK"')
        self._panel("keys").press(key, held_s)
        self.log("press", {"key": key, "held_s": held_s})
        return {"key": key, "held_s": held_s}

    def _screen(self, _asked: Mapping[str, Any]) -> Reply:
        """Its text, and each row of pixels as hexadecimal digits: their levels of grey."""
        panel = self._panel("display")
        rows = ["".join(f"{level:x}" for level in row) for row in panel.picture().tolist()]
        return {"lines": panel.lines(), "rows": rows}

    def _panel(self, part: str) -> Panel:
        if self._session.panel is None:
            raise UserError(f"board {self._session.setup.board.name} has no {part}")
        return self._session.panel

    # -- figures -----------------------------------------------------------------------------------

    def _metrics(self, _asked: Mapping[str, Any]) -> Reply:
        self._session.look()
        score = self._session.recorder.so_far(self._session.now_ns / SECOND)
        faults = [placed.use() for placed in self._session.faults]
        return {
            "metrics": dict(score.metrics),
            "gnss": dict(score.gnss),
            "faults": [{"name": use.name, "kind": use.kind, "fired": use.fired} for use in faults],
        }


def check_pace(pace: float, what: str) -> None:
    """Raises UserError for a pace that cannot be."""
    if pace and not SLOWEST <= pace <= FASTEST:
        raise UserError(
            f"{what}: {pace:g} lies outside {SLOWEST:g} … {FASTEST:g}; 1 is real time, 0 as fast as it goes"
        )


def example_of(name: Any) -> dict[str, Any]:
    """A valid command, of that name if there is one."""
    known = name if isinstance(name, str) and name in EXAMPLES else "pause"
    return {"command": known, **EXAMPLES[known]}


def _is_deeper(value: Any, levels: int) -> bool:
    """Whether there are more levels of lists and objects."""
    if not isinstance(value, dict | list):
        return False
    inner = value.values() if isinstance(value, dict) else value
    return not levels or any(_is_deeper(one, levels - 1) for one in inner)


def _number(asked: Mapping[str, Any], key: str, low: float, high: float) -> float:
    value = asked[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise UserError(f"{key} = {value!r} is no number in {low:g} … {high:g}")
    return float(value)
