"""The control channel: JSON lines on TCP, each answered by one JSON line (`host.serve.commands`).

A connection whose first line is no JSON is ended after the answer: a web page that has a browser send its
request here must not get any further.

Commands have a share of the run's time, however many are sent: after `BUDGET_S` of them they rest for
`REST` times as long.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

from host.serve.address import Address, listen
from host.serve.commands import Reply, example_of
from host.serve.endpoint import Terms, Traffic
from host.serve.hub import Hub
from host.serve.sockets import SocketCarrier
from host.serve.stream import Stream

LONGEST_LINE = 1 << 16
MOST_CLIENTS = 16
BUDGET_S = 0.001
REST = 4


class ControlChannel:
    """Listens for commands, and has them done when `attend` is called."""

    def __init__(self, address: Address, hub: Hub, terms: Terms) -> None:
        """Raises UserError."""
        self._hub, self._terms = hub, terms
        self._listener = listen(address, "--control")
        host, port = self._listener.getsockname()[:2]
        self.where = str(Address(host, port))
        self._sessions: list[_Caller] = []
        self._rest_until_s = 0.0
        hub.watch(self._listener, self._accept)

    def attend(self, do: Callable[[Any], Reply]) -> None:
        """Have done what has been asked by now, as far as there is time; who was last comes first then."""
        begin_s = time.monotonic()
        if begin_s < self._rest_until_s:
            return
        for attended, caller in enumerate(self._sessions, 1):
            caller.attend(do, begin_s + BUDGET_S)
            spent_s = time.monotonic() - begin_s
            if spent_s >= BUDGET_S:
                self._rest_until_s = begin_s + (1 + REST) * spent_s
                self._sessions = self._sessions[attended:] + self._sessions[:attended]
                break
        self._let_go()

    def close(self) -> None:
        """End all connections."""
        for caller in self._sessions:
            caller.stream.close()
        self._hub.watch(self._listener, None)
        self._listener.close()

    def _let_go(self) -> None:
        """Of those who have been answered, and of the oldest who have gone when there are too many."""
        gone = [caller for caller in self._sessions if not caller.is_here]
        let_go = [caller for caller in self._sessions if caller.over or caller in gone[:-MOST_CLIENTS]]
        for caller in let_go:
            caller.stream.close(gently=False)
            self._sessions.remove(caller)

    def _accept(self) -> None:
        try:
            connection, peer = self._listener.accept()
        except OSError:
            return
        if sum(caller.is_here for caller in self._sessions) >= MOST_CLIENTS:
            connection.close()
            return
        name = f"control {Address(*peer[:2])}"
        carrier = SocketCarrier(connection)
        stream = Stream(self._hub, carrier, name, Terms(_quiet), Traffic(), answers_to_the_end=True)
        self._sessions.append(_Caller(stream))


class _Caller:
    """One connection."""

    def __init__(self, stream: Stream) -> None:
        self.stream = stream
        self._line = bytearray()
        self._proven = False
        """It has spoken JSON."""

    @property
    def is_here(self) -> bool:
        """Whether it may say something more."""
        return not (self.stream.gone or self.stream.said_all)

    @property
    def over(self) -> bool:
        """Whether it has gone, left nothing to be done and has all its answers."""
        return not (self.is_here or self.stream.waiting or self._line or self.stream.backlog)

    def attend(self, do: Callable[[Any], Reply], until_s: float) -> None:
        """Answer whole lines until `until_s` of time.monotonic()."""
        while (line := self._next_line()) is not None:
            if line.strip() and not self._answer(line, do):
                return
            if time.monotonic() >= until_s:
                return

    def _next_line(self) -> bytes | None:
        while (end := self._line.find(b"\n")) < 0:
            if len(self._line) > LONGEST_LINE:
                self._refuse(f"a command is one line of at most {LONGEST_LINE} bytes")
                return None
            data = self.stream.take(LONGEST_LINE)
            if not data and (self.is_here or not self._line):
                return None
            self._line += data or b"\n"  # the last line of one who has gone
        line = bytes(self._line[:end])
        del self._line[: end + 1]
        return line

    def _answer(self, line: bytes, do: Callable[[Any], Reply]) -> bool:
        try:
            asked = json.loads(line)
        except (ValueError, RecursionError) as error:
            if not self._proven:
                self._refuse(f"this is no JSON: {error}")
                return False
            self._say({"ok": False, "error": f"this is no JSON: {error}", "example": example_of(None)})
            return True
        self._proven = True
        self._say(do(asked))
        return True

    def _refuse(self, why: str) -> None:
        self._say({"ok": False, "error": f"{why}; the connection ends", "example": example_of(None)})
        self._line.clear()
        self.stream.take(1 << 30)
        self.stream.close(gently=False)

    def _say(self, reply: Reply) -> None:
        self.stream.send_aside(json.dumps(reply, separators=(",", ":")).encode() + b"\n")


def _quiet(_line: str) -> None:
    pass
