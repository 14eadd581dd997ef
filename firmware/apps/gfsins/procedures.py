"""Calibration in settings mode, one procedure at a time: the FPGA collects, the DSP solves.

    start(name)   WAITING: the table is to be brought into the position that `prompt` tells
    take()        it stands there: COLLECTING, then WAITING for the next, after the last SOLVING
    abandon()     IDLE again, nothing is stored
    DONE          result_lines; the coefficients are stored
    FAILED        result_lines tell why; take() solves again what was collected

A position in which something moves, or a sensor is missing, is refused: WAITING for the same one again, and
result_lines tell why. `service` belongs into the background, ten times a second or more.
"""

from __future__ import annotations

from enum import Enum
from typing import Final

import numpy as np

from firmware.apps.gfsins import positions
from firmware.apps.gfsins.accelerations import NOMINAL_SCALE
from firmware.apps.gfsins.calibration import (
    ACCELEROMETERS,
    ALIGNMENT,
    DEVIATION,
    ELLIPSE,
    RATES,
    Calibration,
)
from firmware.apps.gfsins.collecting import AXES, AtRest, Readings, Turn, counts
from firmware.apps.gfsins.corrections import WORD
from firmware.apps.gfsins.result_words import result_lines
from firmware.apps.gfsins.sampling import Sampling
from firmware.apps.gfsins.settings_packet import POSITION_VALUES
from firmware.apps.gfsins.solutions import COUNT, SIZES
from firmware.apps.gfsins.solver_dialogue import SolverDialogue
from firmware.drivers import gnss_epoch as gnss
from hal.board_io import BoardIo

LINE: Final = 21
"""Characters of a line of the screen."""
REST_TICKS: Final = 400
REST_BEFORE_TURN_TICKS: Final = 1000
RUN_UP_TICKS: Final = 400
"""Two seconds after the prompt the table turns steadily."""
HOLD_TICKS: Final = 200
READINGS: Final = 12
LARGEST_SPREAD: Final = 25
"""Tenths of a degree among the headings of one position."""
STORED: Final = "stored"


class State(Enum):
    """Where a procedure is."""

    IDLE = "idle"
    WAITING = "waiting"
    COLLECTING = "collecting"
    SOLVING = "solving"
    DONE = "done"
    FAILED = "failed"


class Procedures:
    """What the menu sees."""

    NAMES = positions.NAMES

    def __init__(self, io: BoardIo, sampling: Sampling, calibration: Calibration) -> None:
        self.state = State.IDLE
        self.name = ""
        self.position = 0
        """The one that is waited for or collected, from 0."""
        self.positions = 0
        self.result_lines: list[str] = []
        """Each at most LINE characters."""
        self.refused = 0
        """Positions refused so far."""
        self._calibration = calibration
        self._sampling = sampling
        self._corrections = calibration.corrections
        self._clock = io.clock
        self._dialogue = SolverDialogue(io.packet_senders["packets"])
        self._raw = np.frombuffer(sampling.chips.raw, np.uint8)
        self._spend = io.cpu.spend
        self._cost = io.cpu.cost("collect")
        self._rows: list[list[int]] = []
        self._rest: AtRest | None = None
        self._turn: Turn | None = None
        self._clear()

    # -- the menu's side ---------------------------------------------------------------------------

    @property
    def prompt(self) -> str:
        """What the operator is to do; at most LINE characters."""
        if self.state is State.WAITING:
            return positions.prompt(self.name, self.position)
        if self.state is State.COLLECTING:
            turning = self._turn is not None
            return positions.turn_prompt(self.name, self.position) if turning else "hold still"
        return {State.SOLVING: "DSP solves", State.DONE: "done", State.FAILED: "failed"}.get(self.state, "")

    @property
    def progress(self) -> float:
        """Of what is under way: all positions, or solving; 0 to 1."""
        if self.state is State.SOLVING:
            return self._dialogue.progress
        if self.state in (State.WAITING, State.COLLECTING):
            return (self.position + self._collected) / self.positions
        return 1.0 if self.state is State.DONE else 0.0

    @property
    def _collected(self) -> float:
        parts = [part for part in (self._rest, self._turn) if part is not None]
        done = [part.taken / part.ticks for part in parts] + [self._readings.taken / READINGS]
        return min(1.0, max(done))

    def start(self, name: str) -> bool:
        """Begin a procedure; False: there is none of that name, or one is running."""
        if name not in positions.NAMES or self.state in (State.WAITING, State.COLLECTING, State.SOLVING):
            return False
        self.name, self.position, self.positions = name, 0, positions.COUNTS[name]
        self.result_lines = []
        self._rows = []
        self._clear()
        self.state = State.WAITING
        return True

    def take(self) -> bool:
        """The operator says that the table stands as it should; False: nobody waits for it."""
        if self.state is State.FAILED and len(self._rows) == self.positions:
            self._solve()
            return True
        if self.state is not State.WAITING:
            return False
        self._clear()
        self.result_lines = []
        missing = self._missing()
        if missing:
            self._refuse(missing)
            return True
        if self.name not in ("compass", "ellipse"):
            self._rest = AtRest(REST_BEFORE_TURN_TICKS if self.name in positions.TURNED else REST_TICKS)
            self._sampling.each_tick = self._on_tick
        self.state = State.COLLECTING
        return True

    def abandon(self) -> None:
        """Whatever is running ends."""
        self._dialogue.abandon()
        self._clear()
        self.state = State.IDLE
        self.result_lines = []

    def on_command(self, data: bytes) -> None:
        """What the DSP wrote; from the interrupt."""
        self._dialogue.on_answer(data)

    def service(self) -> None:
        """From the background."""
        if self.state is State.COLLECTING:
            self._collect()
        elif self.state is State.SOLVING:
            self._dialogue.service(self._clock.now_ns())
            if self._dialogue.failure:
                self._fail(self._dialogue.failure)
            elif self._dialogue.result is not None:
                self._finish(self._dialogue.result)

    # -- collecting --------------------------------------------------------------------------------

    def _clear(self) -> None:
        self._sampling.each_tick = None
        self._rest = None
        self._turn = None
        self._readings = Readings(READINGS)
        self._headings = self._sampling.compass.readings

    def _on_tick(self, _tick_ns: int) -> None:
        """In the timer's interrupt."""
        now = counts(self._raw)
        part = self._turn or self._rest
        if part is not None and not part.is_done:
            part.take(now)
            self._spend(self._cost)

    def _collect(self) -> None:
        missing = self._missing()
        if missing:
            self._refuse(missing)
            return
        if self._needs_compass:
            self._read_compass()
        rest = self._rest
        if rest is not None and rest.is_done and self._turn is None:
            if rest.has_moved:
                self._refuse("moved: take again")
            elif self.name in positions.TURNED:
                self._turn = Turn(rest.means, RUN_UP_TICKS, HOLD_TICKS)
        if self.state is State.COLLECTING and self._is_complete:
            self._accept()

    @property
    def _needs_compass(self) -> bool:
        return self.name in ("compass", "ellipse", "alignment")

    @property
    def _is_complete(self) -> bool:
        last = self._turn if self.name in positions.TURNED else self._rest
        has_rest = self.name in ("compass", "ellipse") or (last is not None and last.is_done)
        return has_rest and (self._readings.is_done or not self._needs_compass)

    def _read_compass(self) -> None:
        compass = self._sampling.compass
        if self._readings.is_done or compass.readings == self._headings:
            return
        self._headings = compass.readings
        reading = compass.take()
        field = compass.field() if self.name == "ellipse" else (0, 0, 0)
        if reading is None or field is None:
            return
        self._readings.take((*reading[:3], *field[:2]))
        if self._readings.spread(0) > LARGEST_SPREAD:
            self._refuse("heading not steady")

    def _missing(self) -> str:
        """A sensor without which there is nothing to collect."""
        if self._needs_compass and not self._sampling.compass.works:
            return "compass missing"
        if self.name in ("compass", "ellipse"):
            return ""
        chips = self._sampling.chips
        bad = chips.missing or chips.faults
        word = "missing" if chips.missing else "stuck"
        return f"chip {(bad & -bad).bit_length()} is {word}" if bad else ""

    def _refuse(self, why: str) -> None:
        self.refused += 1
        self._clear()
        self.state = State.WAITING
        self.result_lines = [why]

    def _accept(self) -> None:
        self._rows.append(self._row())
        self._clear()
        self.position += 1
        if self.position < self.positions:
            self.state = State.WAITING
        else:
            self.position = self.positions - 1
            self._solve()

    def _row(self) -> list[int]:
        """What is sent of a position."""
        row = [0] * POSITION_VALUES
        if self._turn is not None:
            row[:AXES] = self._scaled(self._turn.means.tolist())
        elif self._rest is not None:
            row[:AXES] = self._rest.means.tolist()
        if self.name == "alignment":
            row[:AXES] = self._corrected(row[:AXES])
            row[AXES] = self._readings.means[0]
            row[AXES + 1 :] = [round(x * 1e6) for x in self._calibration.deviation]
        elif self._needs_compass:
            row[:5] = self._readings.means
        return row

    def _scaled(self, values: list[int]) -> list[int]:
        scales = self._corrections.scales.tolist()
        return [value * scale // NOMINAL_SCALE for value, scale in zip(values, scales, strict=True)]

    def _corrected(self, values: list[int]) -> list[int]:
        """Counts of nominal size, without offsets; those at the origin without misalignment."""
        word = round(WORD / COUNT)
        offsets = self._corrections.offsets.tolist()
        scaled = self._scaled(values)
        felt = [value - offset * word for value, offset in zip(scaled, offsets, strict=True)]
        matrix, origin = self._calibration.force_matrix, felt[6:]
        rows = (matrix[0:3], matrix[3:6], matrix[6:9])
        aligned = [round(sum(m * x for m, x in zip(row, origin, strict=True))) for row in rows]
        return [*felt[:6], *aligned]

    # -- solving -----------------------------------------------------------------------------------

    def _solve(self) -> None:
        self.state = State.SOLVING
        self.result_lines = []
        number = positions.NAMES.index(self.name)
        self._dialogue.begin(number, self._place(), self._rows, SIZES[self.name])

    def _place(self) -> tuple[int, int, int]:
        """Latitude in 1e-7°, height in mm, whether they are known."""
        epoch = self._sampling.receiver.waiting
        known = bool(epoch[gnss.FLAGS] & gnss.HAS_POSITION and epoch[gnss.FLAGS] & gnss.HAS_HEIGHT)
        return (int(epoch[gnss.LAT_NANODEG]) // 100, int(epoch[gnss.HEIGHT_MM]), 1) if known else (0, 0, 0)

    def _finish(self, values: tuple[float, ...]) -> None:
        lines = result_lines(self.name, values)
        found = _sections(self.name, values)
        if self.name == "accelerometers" and not self._place()[2]:
            lines.append("no fix: standard g")
        if found:
            if not self._calibration.can_correct(found):
                self._fail("beyond the limits")
                return
            if not self._calibration.keep(found):
                self._fail("flash doesn't keep it")
                return
            lines.append(STORED)
        self.result_lines = [line[:LINE] for line in lines]
        self.state = State.DONE

    def _fail(self, why: str) -> None:
        self.state = State.FAILED
        self.result_lines = [why[:LINE]]


def _sections(name: str, values: tuple[float, ...]) -> dict[int, tuple[float, ...]]:
    """What of a result is stored; nothing of the Earth's rate, which cannot be observed."""
    if name == "accelerometers":
        return {ACCELEROMETERS: values}
    if name == "rates":
        return {RATES: values}
    if name == "compass":
        return {DEVIATION: values}
    if name == "ellipse":
        return {DEVIATION: values[:10], ELLIPSE: values[10:]}
    return {ALIGNMENT: values} if name == "alignment" else {}
