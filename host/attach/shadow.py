"""The shadow: the firmware's navigation loop runs along on the raw frames of a board, bit for bit.

    waiting ──START, or a whole copy of the memory──► in step
    in step ──an input is missing──► lost ──START, or a whole copy of the memory──► in step

Every input has its number, so a missing one is always noticed. But a SOLUTION has none: one that differs
counts only when the next input shows that none was missing before it. A copy of the board's memory takes
some seconds to arrive; what comes meanwhile is kept and done after it. In step, each copy is compared with
the twin's own memory as it was at that input, byte for byte.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import Any, Protocol

import numpy as np

from firmware.link.frames import PAYLOADS, SOLUTION
from firmware.link.raw_frames import RAW_START
from host.attach.difference import Difference, solution_difference
from host.link.raw import RawInput, RawSlice, open_raw

MOST_KEPT = 200_000
"""Frames that are kept while a copy arrives; more do not come in that time."""
DIFFERENCES_KEPT = 100
START_WORDS = (
    "format of raw frames", "steps for each sample", "bytes of a float", "steps between solutions",
    "floats in the state", "integers in the state", "check sum of the configured memory",
)  # fmt: skip
"""Fields of START behind its number; the last one on the wire, the board's clock, is not compared."""


FOREIGN_WORDS = {0, 1, 2, 4, 5}
"""Of these, what makes it another program: nothing can be compared."""


class Loop(Protocol):
    """A program's navigation loop: what `raw_loop` in the module of a board's program returns."""

    def take(self, kind: int, values: tuple[Any, ...]) -> None:
        """One input, its values behind the number."""
        ...

    def solution(self) -> bytes:
        """Payload of the SOLUTION that the board sends in this state."""
        ...

    def start_words(self) -> tuple[int, ...]:
        """What START says of program and configuration."""
        ...

    def memory(self) -> bytes:
        """All that a copy of the memory holds."""
        ...

    def restore(self, memory: bytes) -> bool:
        """Go on from a copy; False when it is not of this program."""
        ...

    def configuration(self) -> dict[str, float]:
        """What nothing changes in flight, by name."""
        ...

    def place(self, offset: int) -> str:
        """Name of a place in `memory`."""
        ...


class Phase(Enum):
    """How the shadow stands to the board."""

    WAITING = "waiting for a start of the board or a copy of its memory"
    IN_STEP = "in step"
    LOST = "lost track, waiting for a start of the board or a copy of its memory"
    FOREIGN = "the board's program is another one"


@dataclass
class ShadowCounts:
    """What was compared."""

    inputs: int = 0
    """Inputs that the twin has taken."""
    inputs_missing: int = 0
    solutions_equal: int = 0
    solutions_different: int = 0
    solutions_unchecked: int = 0
    """That came while the shadow was not in step, or were not confirmed."""
    copies_equal: int = 0
    copies_different: int = 0
    starts: int = 0
    losses: int = 0
    joined: int = 0
    """Times it came in step by a copy of the memory."""


@dataclass
class _Copy:
    number: int
    places: int
    own: bytes | None
    """The twin's memory at that input; None: to be restored from."""
    data: bytearray = field(default_factory=bytearray)
    arrived: int = 0
    kept: list[RawInput | bytes] = field(default_factory=list)
    """Inputs and solutions that came behind the copy's instant."""


class Shadow:
    """Feeds a loop and compares. `notice` lines are for people."""

    def __init__(self, loop: Loop) -> None:
        self.counts = ShadowCounts()
        self.differences: list[Difference] = []
        self.phase = Phase.WAITING
        self._loop = loop
        self._configured = loop.configuration()
        self._expected = 0
        self._copy: _Copy | None = None
        self._pending: list[Difference] = []
        self._board_s = 0.0

    @property
    def in_step(self) -> bool:
        """Whether solutions can be compared now."""
        return self.phase is Phase.IN_STEP

    @property
    def first_difference(self) -> Difference | None:
        """Confirmed; None: all that was compared is equal."""
        return self.differences[0] if self.differences else None

    def take(self, kind: int, payload: bytes) -> None:
        """A frame of the board, in the order of the link."""
        if kind == SOLUTION and len(payload) == PAYLOADS[SOLUTION].size:
            self._take_solution(payload)
        elif kind >= RAW_START:
            message = open_raw(kind, payload)
            if isinstance(message, RawInput):
                self._take_input(message)
            elif isinstance(message, RawSlice):
                self._take_slice(message)

    def finish(self) -> None:
        """Nothing more will come; what could not be confirmed does not count."""
        self._forget_pending()
        self._give_up_copy()

    def to_dict(self) -> dict[str, Any]:
        """For `--json`."""
        return {
            "phase": self.phase.name.lower(),
            **asdict(self.counts),
            "differences": [one.to_dict() for one in self.differences],
        }

    # -- inputs --------------------------------------------------------------------------------------

    def _take_input(self, message: RawInput) -> None:
        if message.kind == RAW_START:
            self._start(message)
        elif self.in_step:
            if message.number == self._expected:
                self._confirm_pending()
                self._do(message)
            else:
                self._lose((message.number - self._expected) & 0xFFFF_FFFF)
        else:
            self._keep(message)

    def _do(self, message: RawInput) -> None:
        self._loop.take(message.kind, message.values)
        self._expected = (message.number + 1) & 0xFFFF_FFFF
        self.counts.inputs += 1

    def _start(self, message: RawInput) -> None:
        """The board begins anew, and so does the twin."""
        self._forget_pending()
        self.counts.starts += 1
        self._copy = None
        self._loop.take(RAW_START, message.values)
        self._expected = 1
        self.phase = Phase.IN_STEP
        self._board_s = message.values[-1] / 1e6
        own = self._loop.start_words()
        told = message.values[:-1]
        different = [k for k, pair in enumerate(zip(told, own, strict=True)) if pair[0] != pair[1]]
        if not FOREIGN_WORDS.isdisjoint(different):
            self.phase = Phase.FOREIGN
        if different:
            k = different[0]
            self._report(
                Difference(self._board_s, "start", START_WORDS[k], told[k], own[k], None, len(different))
            )

    def _lose(self, missing: int) -> None:
        self._forget_pending()
        self.counts.losses += 1
        self.counts.inputs_missing += missing
        self.phase = Phase.LOST
        self._copy = None

    # -- solutions -----------------------------------------------------------------------------------

    def _take_solution(self, payload: bytes) -> None:
        self._board_s = int.from_bytes(payload[:8], "little") / 1e6
        if self.in_step:
            self._compare(payload)
        elif self._copy is not None:
            self._copy.kept.append(payload)
        else:
            self.counts.solutions_unchecked += 1

    def _compare(self, payload: bytes) -> None:
        found = solution_difference(payload, self._loop.solution())
        if found is None:
            self.counts.solutions_equal += 1
        else:
            self._pending.append(found)

    def _confirm_pending(self) -> None:
        if self._pending:
            self.counts.solutions_different += len(self._pending)
            for found in self._pending:
                self._report(found)
            self._pending.clear()

    def _forget_pending(self) -> None:
        self.counts.solutions_unchecked += len(self._pending)
        self._pending.clear()

    def _report(self, found: Difference) -> None:
        first = all(one.what != found.what for one in self.differences)
        if first or len(self.differences) < DIFFERENCES_KEPT:
            self.differences.append(found)

    # -- copies of the memory ------------------------------------------------------------------------

    def _take_slice(self, part: RawSlice) -> None:
        if part.place == 0:
            self._begin_copy(part)
        copy = self._copy
        if copy is None:
            return
        if (part.number, part.places, part.place) != (copy.number, copy.places, copy.arrived):
            self._give_up_copy()
            return
        copy.data += part.data
        copy.arrived += 1
        if copy.arrived == copy.places:
            self._copy = None
            self._end_copy(copy)

    def _begin_copy(self, part: RawSlice) -> None:
        self._give_up_copy()
        if self.in_step and part.number != self._expected:
            self._lose((part.number - self._expected) & 0xFFFF_FFFF)
        if self.in_step:
            self._confirm_pending()
        if self.phase is not Phase.FOREIGN:
            self._copy = _Copy(part.number, part.places, self._loop.memory() if self.in_step else None)

    def _give_up_copy(self) -> None:
        if self._copy is not None:
            self.counts.solutions_unchecked += sum(isinstance(one, bytes) for one in self._copy.kept)
            self._copy = None

    def _keep(self, message: RawInput) -> None:
        """An input while a copy arrives: it must follow on the one before, or the copy is of no use."""
        copy = self._copy
        if copy is None or copy.own is not None:
            return
        last = next((one for one in reversed(copy.kept) if isinstance(one, RawInput)), None)
        follows = copy.number if last is None else (last.number + 1) & 0xFFFF_FFFF
        if message.number != follows or len(copy.kept) >= MOST_KEPT:
            self._give_up_copy()
        else:
            copy.kept.append(message)

    def _end_copy(self, copy: _Copy) -> None:
        board = bytes(copy.data)
        if copy.own is None:
            self._join(board, copy)
        elif board == copy.own:
            self.counts.copies_equal += 1
        else:
            self.counts.copies_different += 1
            self._report(self._memory_difference("state", board, copy.own))

    def _join(self, board: bytes, copy: _Copy) -> None:
        """Go on from the board's own memory; its configuration must be ours."""
        own_size = len(self._loop.memory())
        if not self._loop.restore(board):
            self.phase = Phase.FOREIGN
            self._report(
                Difference(self._board_s, "state", "bytes of the memory", len(board), own_size, None, 1)
            )
            self.counts.solutions_unchecked += sum(isinstance(one, bytes) for one in copy.kept)
            return
        self.counts.joined += 1
        self.phase = Phase.IN_STEP
        self._expected = copy.number
        told, own = self._loop.configuration(), self._configured
        different = [name for name in own if told[name] != own[name]]
        if different:
            name = different[0]
            self._report(
                Difference(self._board_s, "configuration", name, told[name], own[name], None, len(different))
            )
        for one in copy.kept:
            if isinstance(one, RawInput):
                self._take_input(one)
            else:
                self._take_solution(one)

    def _memory_difference(self, what: str, board: bytes, own: bytes) -> Difference:
        if len(board) != len(own):
            return Difference(self._board_s, what, "bytes of the memory", len(board), len(own), None, 1)
        offsets = np.flatnonzero(np.frombuffer(board, np.uint8) != np.frombuffer(own, np.uint8))
        first = int(offsets[0])
        places = {self._loop.place(int(offset)) for offset in offsets}
        return Difference(
            self._board_s,
            what,
            self._loop.place(first),
            f"0x{board[first]:02X}",
            f"0x{own[first]:02X}",
            None,
            len(places),
        )
