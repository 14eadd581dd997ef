"""What was done to a served board from outside, done again in a strict replay at the same instants.

Most of it shows in the traffic: bytes written to a UART, what a chip then said, faults of chips and wires,
another place of the vehicle. Left are faults that strike neither a chip nor a wire to one, and frames that
somebody outside put on a CAN bus: they compete with the board's own, so the bus must have them again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from boards.assembly import AssembledBoard
from boards.description import Board
from hal.can import CanFrame
from hal.emulated.can import CanNode
from host.record.errors import UserError
from host.run.faults import Placed, name_of, place_on_board
from host.sim.scenario.schema import Fault

OWN_FAULTS = ("can-disturbance", "log-removed", "nav-nan", "cpu-reset")
"""Kinds of faults that strike neither a chip nor a wire into the board …"""


def is_own(fault: Fault, board: Board) -> bool:
    """… and all faults of what joins its processors, which no recorded traffic shows."""
    driven = {pin.net for pin in board.pins.values() if pin.use == "output"}
    between = fault.target in board.interconnects or (fault.kind == "pin-stuck" and fault.target in driven)
    return fault.kind in OWN_FAULTS or between


OUTSIDE_NODE = "outside"
"""Name of the node through which frames from outside come."""
BETWEEN_SLICES = 1 << 30
"""Commands come when everything of their instant has happened."""


class ControlTape:
    """Re-applies messages of /control to a board."""

    def __init__(self, board: AssembledBoard, seed: int, placed: Iterable[Placed]) -> None:
        """`placed`: the scenario's own faults, which a command may clear."""
        self._board = board
        self._seed = seed
        self._placed = {name_of(one.fault): one for one in placed}
        self._nodes: dict[str, CanNode] = {}
        self._actions: dict[str, Callable[[Mapping[str, Any]], None]] = {
            "serve-can": self._attach,
            "can-frames": self._send,
            "inject": self._inject,
            "clear": self._clear,
        }

    def load(self, messages: Iterable[Mapping[str, Any]]) -> None:
        """Have these done when their time comes. Raises UserError for one that makes no sense."""
        time = self._board.time
        for message in messages:
            action = self._actions.get(str(message.get("command")))
            if action is None:
                continue
            act = _acting(action, message)
            at_ns = message.get("time_ns")
            if isinstance(at_ns, int) and at_ns > 0:
                time.at(max(at_ns, time.now), act, priority=BETWEEN_SLICES)
            else:
                act()

    def _attach(self, message: Mapping[str, Any]) -> None:
        self._nodes[message["bus"]] = CanNode(self._board.can_buses[message["bus"]], OUTSIDE_NODE)

    def _send(self, message: Mapping[str, Any]) -> None:
        self._nodes[message["bus"]].send(tuple(map(frame_of_text, message["frames"])))

    def _inject(self, message: Mapping[str, Any]) -> None:
        fault = Fault.model_validate(message["fault"])
        if is_own(fault, self._board.description) and fault.name is not None:
            placed = place_on_board(fault, self._board, self._seed, self._board.time.now)
            self._placed[fault.name] = placed

    def _clear(self, message: Mapping[str, Any]) -> None:
        placed = self._placed.get(message["name"])
        if placed is not None and placed.lift is not None:
            placed.lift()


def _acting(action: Callable[[Mapping[str, Any]], None], message: Mapping[str, Any]) -> Callable[[], None]:
    def act() -> None:
        try:
            action(message)
        except (KeyError, TypeError, ValueError) as error:
            raise UserError(f"the capture holds a command that makes no sense: {message}: {error}") from None

    return act


def text_of_frame(frame: CanFrame) -> str:
    """As candump writes it: identifier in hex (eight digits: 29 bits), #, data in hex."""
    identifier = f"{frame.identifier:08X}" if frame.extended else f"{frame.identifier:03X}"
    return f"{identifier}#{frame.data.hex().upper()}"


def frame_of_text(text: str) -> CanFrame:
    """The frame that `text_of_frame` wrote. Raises ValueError."""
    identifier, _separator, data = text.partition("#")
    return CanFrame(int(identifier, 16), bytes.fromhex(data), len(identifier) == 8)
