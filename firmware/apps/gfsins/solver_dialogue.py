"""The FPGA's side of solving: what was collected goes to the DSP, one request after the other, and its result
comes back.

A request without an answer is sent again; a DSP that has begun anew meanwhile does not know what the request
follows from, and gets all from the beginning. One that stays away is told as a failure.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from firmware.apps.gfsins.settings_packet import (
    MOST_ANSWERED,
    Answer,
    Request,
    Result,
    What,
    open_answer,
    pack_request,
)
from hal.packet_link import PacketSender

AGAIN_NS: Final = 400_000_000
MOST_TRIES: Final = 8
MOST_RESTARTS: Final = 3
WORDS: Final = {
    Result.UNKNOWN: "DSP begins anew",
    Result.NOT_TOLD: "positions too alike",
    Result.IMPLAUSIBLE: "result implausible",
}
SILENT: Final = "DSP does not answer"


class SolverDialogue:
    """One after the other; `begin` starts one."""

    def __init__(self, sender: PacketSender) -> None:
        self.result: tuple[float, ...] | None = None
        """All parts, when they are there."""
        self.failure = ""
        """At most 21 characters; empty while there is none."""
        self.progress = 0.0
        self.repeated = 0
        """Requests sent again."""
        self._sender = sender
        self._number = 0
        self._script: list[Request] = []
        self._size = 0
        self._stop()

    def _stop(self) -> None:
        self._place = -1
        self._answer: Answer | None = None

    def begin(
        self, procedure: int, place: Sequence[int], rows: Sequence[Sequence[int]], result_size: int
    ) -> None:
        """`place`: latitude 1e-7°, height mm, whether they are known; `rows`: what each position gave."""
        self._script = [Request(0, What.BEGIN, procedure, 0, tuple(place))]
        self._script += [Request(0, What.POSITION, procedure, k, tuple(row)) for k, row in enumerate(rows)]
        self._script.append(Request(0, What.SOLVE, procedure))
        parts = -(-result_size // MOST_ANSWERED)
        self._script += [Request(0, What.GIVE, procedure, k) for k in range(parts)]
        self._size = result_size
        self._restarts = 0
        self.result, self.failure, self.progress = None, "", 0.0
        self._from_the_beginning()

    def abandon(self) -> None:
        """Send nothing any more."""
        self._stop()

    def on_answer(self, data: bytes) -> None:
        """What the DSP wrote; from the interrupt."""
        answer = open_answer(data)
        if answer is not None and answer.number == self._number:
            self._answer = answer

    def service(self, now_ns: int) -> None:
        """From the background."""
        if self._place < 0:
            return
        answer, self._answer = self._answer, None
        if answer is not None:
            self._take(answer)
        if self._place >= 0 and now_ns >= self._due_ns:
            self._send(now_ns)

    def _take(self, answer: Answer) -> None:
        if answer.result is Result.UNKNOWN and self._restarts < MOST_RESTARTS:
            self._restarts += 1
            self._from_the_beginning()
            return
        if answer.result is not Result.DONE:
            self._fail(WORDS[answer.result])
            return
        if self._script[self._place].what is What.GIVE:
            self._found += answer.values
        self._place += 1
        self.progress = self._place / len(self._script)
        if self._place == len(self._script):
            whole = len(self._found) == self._size
            self._stop()
            self.result = tuple(self._found) if whole else None
            self.failure = "" if whole else "result incomplete"
        else:
            self._next()

    def _from_the_beginning(self) -> None:
        self._place = 0
        self._found: list[float] = []
        self._next()

    def _next(self) -> None:
        self._number = self._number + 1 & 0xFFFF
        self._tries = 0
        self._due_ns = 0

    def _send(self, now_ns: int) -> None:
        if self._tries == MOST_TRIES:
            self._fail(SILENT)
            return
        asked = self._script[self._place]
        request = Request(self._number, asked.what, asked.procedure, asked.index, asked.values)
        if self._sender.send(pack_request(request)):
            self.repeated += self._tries > 0
            self._tries += 1
            self._due_ns = now_ns + AGAIN_NS

    def _fail(self, why: str) -> None:
        self._stop()
        self.failure = why
