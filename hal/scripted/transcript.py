"""A transcript: what a driver must do, in order, and what the world answers.

One step a line; `#` starts a comment, which also names the step in messages. Bytes are pairs of hex digits,
`..` stands for any one word.

    what the driver does                        reply after `->`
    spi NAME BYTES                              as many BYTES (required)
    i2c NAME ADDRESS [write BYTES] [read N]     N BYTES; or: address-nack, data-nack, timeout
    uart NAME write BYTES                       number taken (all of them without a reply)
    uart NAME baud RATE
    can NAME send ID BYTES                      full (queued without a reply); an ID with x is extended
    memory NAME read ADDRESS N                  N words, as BYTES
    memory NAME write ADDRESS BYTES
    memory NAME ring VALUE
    packets NAME send BYTES                     busy (taken without a reply)
    slave NAME answer BYTES
    pin NAME high|low
    timer NAME start RATE, timer NAME stop, capture NAME start
    log NAME append BYTES, log NAME sync        failed (done without a reply)
    flash NAME read PLACE N                     N BYTES
    flash NAME erase BLOCK                      failed (done without a reply)
    flash NAME program PLACE BYTES              failed (done without a reply)
    watchdog start NS, watchdog kick
    delay NS

    what comes by itself, at once after the step before it
    <- uart NAME BYTES          into the ring; pends the port's line (as the line falls idle)
    <- uart NAME errors N
    <- can NAME ID BYTES
    <- memory NAME ring VALUE   into the mailbox; pends its line
    <- packets NAME BYTES       into the ring; pends its line when a packet is whole
    <- slave NAME BYTES         written by the master; pends its line
    <- pin NAME high|low        pends the line of that edge
    <- line NAME                pends a line of the controller
    <- timer NAME, <- capture NAME CLOCK_NS
    <- time NS                  the clock moves on

Reads without effect (`received`, `tx_free`, `read` of a pin, `rung`, `captured`, `now_ns`) are not steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from types import TracebackType

ANY = ".."
Arrival = Callable[[list[str]], None]

ACTIONS = (
    "spi",
    "i2c",
    "uart",
    "can",
    "memory",
    "packets",
    "slave",
    "pin",
    "timer",
    "capture",
    "log",
    "flash",
    "watchdog",
    "delay",
)
ARRIVALS = ("uart", "can", "memory", "packets", "slave", "pin", "line", "timer", "capture", "time")


@dataclass(frozen=True)
class Step:
    """One line of a transcript."""

    line: int
    words: tuple[str, ...]
    reply: tuple[str, ...]
    comment: str
    arrives: bool

    def __str__(self) -> str:
        text = ("<- " if self.arrives else "") + " ".join(self.words)
        return text + (" -> " + " ".join(self.reply) if self.reply else "")


class Transcript:
    """The steps of a test and how far the driver has come. Use as `with Transcript(text) as transcript:`."""

    def __init__(self, text: str | Iterable[str]) -> None:
        lines = text.splitlines() if isinstance(text, str) else list(text)
        steps = (_parse(number, line) for number, line in enumerate(lines, 1))
        self.steps = [step for step in steps if step is not None]
        self.position = 0
        self._arrivals: dict[tuple[str, str], Arrival] = {}

    def __enter__(self) -> Transcript:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.finish()

    def finish(self) -> None:
        """Raises AssertionError when steps are left over."""
        self.play()
        if self.position < len(self.steps):
            raise AssertionError(
                f"transcript not finished, next is {self._where()}\n"
                f"  expected: {self.steps[self.position]}\n  got:      the end"
            )

    def on_arrival(self, kind: str, name: str, arrival: Arrival) -> None:
        """A scripted peripheral takes what comes in for `kind name`; `arrival` gets the words after them."""
        self._arrivals[kind, name] = arrival

    def take(self, action: str) -> tuple[str, ...]:
        """The driver does `action`: returns the reply, or raises AssertionError when another was expected."""
        self.play()
        if self.position == len(self.steps):
            raise AssertionError(
                f"transcript of {len(self.steps)} steps is over\n  expected: the end\n  got:      {action}"
            )
        step = self.steps[self.position]
        words = action.split()
        difference = _difference(step.words, words)
        if difference is not None:
            raise AssertionError(
                f"{self._where()}: the driver differs {difference}\n"
                f"  expected: {' '.join(step.words)}\n  got:      {action}{self._history()}"
            )
        self.position += 1
        return step.reply

    def play(self) -> None:
        """Let everything come in that is next in the transcript."""
        while self.position < len(self.steps) and self.steps[self.position].arrives:
            step = self.steps[self.position]
            kind, *rest = step.words
            name = "" if kind == "time" else rest.pop(0)
            arrival = self._arrivals.get((kind, name))
            if arrival is None:
                raise AssertionError(
                    f"{self._where()}: {step} comes in, but the driver has not set up {kind} {name!r} for it"
                )
            self.position += 1
            arrival(rest)

    def _where(self) -> str:
        step = self.steps[self.position]
        comment = f", {step.comment}" if step.comment else ""
        return f"step {self.position + 1} of {len(self.steps)} (line {step.line}{comment})"

    def _history(self) -> str:
        before = self.steps[max(0, self.position - 3) : self.position]
        return "".join(f"\n  before:   {step}" for step in reversed(before))


def _difference(expected: tuple[str, ...], got: list[str]) -> str | None:
    """Where two actions differ, in words; None when they match."""
    for index, (want, have) in enumerate(zip(expected, got, strict=False)):
        if want not in (ANY, have):
            return f"in word {index + 1} ({want} expected, {have} got)"
    if len(expected) != len(got):
        return f"in length ({len(expected)} words expected, {len(got)} got)"
    return None


def _parse(number: int, line: str) -> Step | None:
    body, _, comment = line.partition("#")
    action, arrow, reply = body.partition("->")
    words = action.split()
    if not words:
        if arrow:
            raise ValueError(f"transcript line {number}: {line.strip()!r} has a reply but no action")
        return None
    arrives = words[0] == "<-"
    if arrives:
        words = words[1:]
    known = ARRIVALS if arrives else ACTIONS
    if not words or words[0] not in known:
        raise ValueError(
            f"transcript line {number}: {line.strip()!r} does not start with one of {', '.join(known)}; "
            "a valid line is 'spi imu 80 00 -> 00 d1' or '<- uart gnss 24 47'"
        )
    if len(words) < 2 or (arrives and arrow):
        raise ValueError(
            f"transcript line {number}: {line.strip()!r} is incomplete or has a reply to an arrival"
        )
    return Step(number, tuple(words), tuple(reply.split()), comment.strip(), arrives)


def hex_words(data: bytes | bytearray) -> str:
    """Bytes as a transcript writes them."""
    return data.hex(" ")


def to_bytes(words: Iterable[str]) -> bytes:
    """Pairs of hex digits as bytes. Raises ValueError that shows the offending word."""
    data = bytearray()
    for word in words:
        try:
            value = bytes.fromhex(word)
        except ValueError:
            raise ValueError(f"{word!r} in a transcript is no byte; write two hex digits, e.g. d1") from None
        data += value
    return bytes(data)
