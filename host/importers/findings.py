"""What is wrong with a recording: counted by kind, file and channel, the first ones with place and value."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

EXAMPLES = 5


class Kind(StrEnum):
    """Kinds of findings; the words of `--json` are stable."""

    BACK = "time goes back"
    JUMP = "time jump"
    DUPLICATE = "duplicate"
    GAP = "gap"
    APART = "no time in common"
    NOT_FINITE = "not a finite number"
    IMPLAUSIBLE = "implausible value"
    STUCK = "stuck channel"
    UNIT = "wrong unit"
    DOUBTFUL_UNIT = "doubtful unit"
    CHECKSUM = "checksum error"
    UNREADABLE = "unreadable"
    CUT_OFF = "cut off"
    NO_TIME = "no time"
    MISSING = "missing"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Example:
    """One case of a finding."""

    place: str
    value: str


@dataclass(slots=True)
class Finding:
    """All cases of one kind in one channel of one file."""

    kind: Kind
    file: str
    channel: str
    count: int = 0
    text: str = ""
    """What was made of it."""
    examples: list[Example] = field(default_factory=list)

    def line(self) -> str:
        """For people."""
        times = "" if self.count <= 1 else f" {self.count:,} ×"
        first = ""
        if self.examples:
            one = self.examples[0]
            first = ", first at " if self.count > 1 else ", "
            first += f"{one.place}: {one.value}" if one.value else one.place
        done = f" ({self.text})" if self.text else ""
        channel = f" {self.channel}:" if self.channel else ""
        return f"{self.file}:{channel} {self.kind.value}{times}{first}{done}"


class Findings:
    """Collects what is found."""

    def __init__(self) -> None:
        self._found: dict[tuple[Kind, str, str], Finding] = {}

    def note(
        self,
        kind: Kind,
        file: str,
        channel: str = "",
        cases: Iterable[tuple[str, object]] = (),
        count: int | None = None,
        text: str = "",
    ) -> None:
        """More cases, each (place, value); `count` when there are more than are listed."""
        finding = self._found.setdefault((kind, file, channel), Finding(kind, file, channel))
        listed = [Example(place, _shown(value)) for place, value in cases]
        finding.count += max(len(listed), 1) if count is None else count
        finding.examples += listed[: EXAMPLES - len(finding.examples)]
        finding.text = text or finding.text

    @property
    def all(self) -> list[Finding]:
        """In the order in which the kinds were met."""
        return list(self._found.values())

    def lines(self) -> list[str]:
        """For people."""
        return [finding.line() for finding in self.all]

    def to_list(self) -> list[dict[str, Any]]:
        """For `--json`."""
        return [asdict(finding) for finding in self.all]


def _shown(value: object) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)
