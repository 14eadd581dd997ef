"""Which runs a campaign consists of: profiles × swept values × seeds, in one order on every machine."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from host.campaign.swept_value import swept_value
from host.record.errors import UserError
from host.record.result import RunRequest
from host.sim.seeding import LARGEST_SEED

MOST_RUNS = 1_000_000
RANGE = re.compile(r"^\s*(\d+)\s*(?:-\s*(\d+)\s*)?$")
OPENING, CLOSING = "[{(", "]})"


@dataclass(frozen=True, slots=True)
class Setup:
    """One point of a campaign besides the seed: a profile and one value of each swept key."""

    profile: str
    swept: tuple[tuple[str, str], ...] = ()
    """(key, value as text) in the order of the command line."""

    @property
    def label(self) -> str:
        """For tables: the profile and the swept values."""
        return " ".join([self.profile, *(f"{key}={value}" for key, value in self.swept)])


@dataclass(frozen=True, slots=True)
class Job:
    """One run of a campaign."""

    number: int
    """Place in the plan, from 0."""
    setup: Setup
    request: RunRequest

    @property
    def key(self) -> str:
        """Names the run within its campaign."""
        return f"{self.setup.label} seed={self.request.seed}"


@dataclass(frozen=True)
class Plan:
    """All runs of a campaign."""

    board: str
    """As it was asked for: a name, or a path."""
    scenario: str
    profiles: tuple[str, ...]
    seeds: tuple[int, ...]
    fixed: tuple[str, ...] = ()
    """`key=value` that all runs share."""
    swept: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """Keys with the values they take."""
    data_dir: Path | None = None

    def __post_init__(self) -> None:
        if len(self) > MOST_RUNS:
            raise UserError(
                f"the campaign has {len(self):,} runs ({len(self.seeds):,} seeds times swept values);"
                f" at most {MOST_RUNS:,} can be asked for, for example --seeds 1-200"
            )

    def __len__(self) -> int:
        count = len(self.profiles) * len(self.seeds)
        for _, values in self.swept:
            count *= len(values)
        return count

    def setups(self) -> Iterator[Setup]:
        """Every profile with every combination of swept values."""
        keys = [key for key, _ in self.swept]
        for profile in self.profiles:
            for values in itertools.product(*(values for _, values in self.swept)):
                yield Setup(profile, tuple(zip(keys, values, strict=True)))

    def jobs(self) -> Iterator[Job]:
        """All runs in order."""
        numbers = itertools.count()
        for setup in self.setups():
            for seed in self.seeds:
                yield Job(next(numbers), setup, self.request(setup, seed))

    def request(self, setup: Setup, seed: int) -> RunRequest:
        """What is asked of the runner for one run; it writes nothing."""
        changes = tuple(f"{key}={value}" for key, value in setup.swept)
        return RunRequest(
            board=self.board,
            scenario=self.scenario,
            profile=setup.profile,
            seed=seed,
            overrides=self.fixed + changes,
            data_dir=self.data_dir,
            capture=False,
        )


def parse_seeds(text: str) -> tuple[int, ...]:
    """`1-200`, `7`, `1,3,8-10` as ascending seeds. Raises UserError."""
    seeds: set[int] = set()
    for part in text.split(","):
        match = RANGE.match(part)
        if match is None:
            raise UserError(f"--seeds {text}: {part.strip()!r} is neither a seed nor a range; {_SEEDS}")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            raise UserError(f"--seeds {text}: the range {part.strip()} is empty; {_SEEDS}")
        if last > LARGEST_SEED:
            raise UserError(f"--seeds {text}: a seed is at most {LARGEST_SEED}; {_SEEDS}")
        if last - first >= MOST_RUNS:
            raise UserError(f"--seeds {text}: more than {MOST_RUNS:,} seeds; {_SEEDS}")
        seeds.update(range(first, last + 1))
    return tuple(sorted(seeds))


_SEEDS = "for example --seeds 1-200, or --seeds 1,5,9-12"


def parse_changes(changes: Iterable[str]) -> tuple[tuple[str, ...], tuple[tuple[str, tuple[str, ...]], ...]]:
    """`key=value` and `key=a,b,c` apart: what all runs share, and what is swept. Raises UserError."""
    fixed: list[str] = []
    swept: list[tuple[str, tuple[str, ...]]] = []
    seen: set[str] = set()
    for change in changes:
        key, equals, text = change.partition("=")
        key = key.strip()
        if not equals or not key:
            raise UserError(
                f"--set {change}: must be key=value; for example --set gnss.latency_s=0.05,0.1,0.2"
            )
        if key in seen:
            raise UserError(f"--set {change}: {key} is set twice; give all its values at once: {key}=a,b,c")
        seen.add(key)
        values = parse_values(text, f"--set {change}")
        if len(values) == 1:
            fixed.append(f"{key}={values[0]}")
        else:
            swept.append((key, values))
    return tuple(fixed), tuple(swept)


def parse_values(text: str, option: str) -> tuple[str, ...]:
    """Values between commas; commas in brackets or quotation marks belong to a value. Raises UserError."""
    values = [part.strip() for part in _split(text)]
    if not all(values):
        raise UserError(f"{option}: a value between the commas is missing; for example 0.05,0.1,0.2")
    known: dict[tuple[type, object], str] = {}
    for place, one in enumerate(values):
        meant = swept_value(one)
        first = known.setdefault((type(meant), meant), one)
        if len(known) <= place:
            raise UserError(
                f"{option}: the value {first} is given twice{'' if one == first else f', as {one}'}"
            )
    return tuple(values)


def _split(text: str) -> list[str]:
    parts = [""]
    depth, quote = 0, ""
    for sign in text:
        if quote:
            quote = "" if sign == quote else quote
        elif sign in "\"'":
            quote = sign
        elif sign in OPENING:
            depth += 1
        elif sign in CLOSING:
            depth -= 1
        elif sign == "," and depth <= 0:
            parts.append("")
            continue
        parts[-1] += sign
    return parts


def seeds_text(seeds: Sequence[int]) -> str:
    """The shortest text that `parse_seeds` reads as these ascending seeds."""
    parts: list[str] = []
    first = last = seeds[0]
    for seed in [*seeds[1:], None]:
        if seed == last + 1:
            last = seed
            continue
        parts.append(str(first) if first == last else f"{first}-{last}")
        if seed is not None:
            first = last = seed
    return ",".join(parts)
