"""The DSP in settings mode: takes the FPGA's requests, solves, answers. It does nothing by itself.

`on_packet` stands in the interrupt of the packets, `look` in the background, which alone uses the bus.
"""

from __future__ import annotations

from collections.abc import Callable

from firmware.apps.gfsins import commands, positions
from firmware.apps.gfsins.settings_packet import (
    MOST_ANSWERED,
    POSITION_VALUES,
    Answer,
    Request,
    Result,
    What,
    open_request,
    pack_answer,
)
from firmware.apps.gfsins.solutions import Outcome, Place, Solution, solution_of
from firmware.nav.gyro_free.config import GyroFreeConfig
from hal.board_io import BoardIo
from hal.errors import BusError

NONE_YET: Outcome = (Result.UNKNOWN, ())


class Solver:
    """One procedure at a time."""

    def __init__(self, io: BoardIo, config: GyroFreeConfig, say: Callable[[str], object]) -> None:
        self._bus = io.command_buses["commands"]
        self._spend = io.cpu.spend
        self._step_cost = io.cpu.cost("calibration_step")
        self._solve_cost = io.cpu.cost("calibration_solve")
        self._config = config
        self._say = say
        self._waiting: Request | None = None
        self._answered: Answer | None = None
        self._solution: Solution | None = None
        self._name = ""
        self._taken = 0
        self._outcome = NONE_YET

    def on_packet(self, data: bytes) -> bool:
        """A packet that is none of the acquisition's; whether it was a request."""
        request = open_request(data)
        if request is not None:
            self._waiting = request
        return request is not None

    def look(self) -> None:
        """Work on what waits, and answer it."""
        request, self._waiting = self._waiting, None
        if request is None:
            return
        known = self._answered
        if known is None or known.number != request.number or request.what is What.BEGIN:
            self._spend(self._step_cost)
            self._answered = known = Answer(request.number, *self._done(request))
        try:
            self._bus.transaction(commands.ADDRESS, pack_answer(known))
        except BusError:
            return  # the FPGA asks again

    def _done(self, request: Request) -> Outcome:
        if request.what is What.BEGIN:
            return self._begin(request)
        if self._solution is None or positions.NAMES[request.procedure % len(positions.NAMES)] != self._name:
            return NONE_YET
        if request.what is What.POSITION:
            return self._take(request)
        if request.what is What.SOLVE:
            return self._solve()
        result, values = self._outcome
        first = request.index * MOST_ANSWERED
        return result, values[first : first + MOST_ANSWERED]

    def _begin(self, request: Request) -> Outcome:
        if request.procedure >= len(positions.NAMES):
            return NONE_YET
        self._name = positions.NAMES[request.procedure]
        self._solution = solution_of(self._name, Place(request.values), self._config)
        self._taken = 0
        self._outcome = NONE_YET
        return Result.DONE, ()

    def _take(self, request: Request) -> Outcome:
        assert self._solution is not None
        is_known = request.index < positions.COUNTS[self._name] and len(request.values) == POSITION_VALUES
        if request.index > self._taken or not is_known:
            return NONE_YET
        if request.index == self._taken:
            self._solution.take(request.index, request.values)
            self._taken += 1
        return Result.DONE, ()

    def _solve(self) -> Outcome:
        assert self._solution is not None
        if self._taken != positions.COUNTS[self._name]:
            return NONE_YET
        self._spend(self._solve_cost)
        self._outcome = self._solution.solve()
        result = self._outcome[0]
        told = "solved" if result is Result.DONE else f"not solved, {result.name.lower().replace('_', ' ')}"
        self._say(f"calibration, {self._name}: {told} from {self._taken} positions")
        return result, ()
