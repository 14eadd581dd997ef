"""What is asked of a run and what comes back: `RunRequest` and `RunResult`.

`RunResult.to_dict()` is what `navtwin run --json` prints. Its keys are stable: keys are added, never renamed,
while `format` stays the same. A figure that could not be computed is None (JSON null).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from host.record.run_data import RunData

RESULT_FORMAT = "navtwin-result-1"

Progress = Callable[[float, float], None]
"""Called now and then with (virtual time reached, duration of the run), both in s."""


@dataclass(frozen=True, slots=True)
class RunRequest:
    """One run. None stands for the board's or the scenario's own choice."""

    board: str
    """Name of a board that comes along, a folder with a board.toml, or that file."""
    scenario: str | None = None
    """Name of one of the board's scenarios, or a file."""
    profile: str | None = None
    seed: int = 1
    overrides: tuple[str, ...] = ()
    """`key=value` each, as given to --set: keys of the scenario, or of the board after `board.`."""
    data_dir: Path | None = None
    """Folder of real recordings; None: the environment variable NAVTWIN_DATA."""
    out_dir: Path | None = None
    """Folder for capture, solution and report; None: nothing is written."""
    capture: bool = True
    progress: Progress | None = None
    notice: Callable[[str], None] | None = None
    """Told in a line what takes long before virtual time begins."""


@dataclass(frozen=True, slots=True)
class TaskUse:
    """One interrupt line or task of a processor over the whole run."""

    name: str
    load: float
    """Share of the processor's time, 0 … 1."""
    activations: int
    worst_response_us: float
    """From the request to the end of the handler."""
    worst_busy_us: float
    deadline_us: float | None
    deadline_misses: int
    overruns: int
    """Requests lost because the one before was still waiting."""


@dataclass(frozen=True, slots=True)
class CpuUse:
    """One processor over the whole run."""

    name: str
    load: float
    deadline_misses: int
    overruns: int
    stack_worst_bytes: int
    resets: int
    tasks: tuple[TaskUse, ...]


@dataclass(frozen=True, slots=True)
class BusUse:
    """One bus, UART direction or CAN bus over the whole run."""

    name: str
    load: float
    """Share of the time in which the wire was busy, 0 … 1."""
    transactions: int
    bytes: int | None = None
    errors: int = 0


@dataclass(frozen=True, slots=True)
class FaultUse:
    """A fault of the scenario and how often it really struck."""

    name: str
    kind: str
    target: str
    at_s: float
    duration_s: float | None
    fired: int


@dataclass(frozen=True, slots=True)
class Outage:
    """A time without GNSS and where the solution had drifted by its end. None: no solution there."""

    start_s: float
    duration_s: float
    horizontal_drift_m: float | None
    horizontal_error_at_start_m: float | None = None
    vertical_drift_m: float | None = None


@dataclass(frozen=True, slots=True)
class Expectation:
    """A figure, the limit that the scenario sets for it, and whether it is met."""

    name: str
    value: float | None
    relation: str
    """ "<=" or ">="."""
    limit: float | None
    ok: bool
    limit_name: str | None = None
    """Set when the limit is itself a figure of the run, e.g. "gnss.position_horizontal_rms_m"."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something worth telling that happened in the run."""

    at_s: float
    source: str
    text: str


@dataclass(frozen=True, slots=True)
class RunResult:
    """The outcome of a run. Everything but `wall_s` and `real_time_factor` repeats exactly for a seed."""

    board: str
    scenario: str
    profile: str
    seed: int
    duration_s: float
    wall_s: float
    state_hash: str
    metrics: Mapping[str, float | None]
    gnss: Mapping[str, float | None]
    outages: tuple[Outage, ...] = ()
    cpu: tuple[CpuUse, ...] = ()
    buses: tuple[BusUse, ...] = ()
    faults: tuple[FaultUse, ...] = ()
    expectations: tuple[Expectation, ...] = ()
    events: tuple[Event, ...] = ()
    recording: Mapping[str, Any] | None = None
    """For recordings: the same figures with one constant time shift and offset fitted; else None."""
    out_dir: Path | None = None
    data: RunData | None = field(default=None, repr=False, compare=False)

    @property
    def real_time_factor(self) -> float:
        """Virtual time per wall-clock time."""
        return self.duration_s / self.wall_s if self.wall_s > 0 else math.inf

    @property
    def ok(self) -> bool:
        """Whether every expectation is met (True when there is none)."""
        return all(expectation.ok for expectation in self.expectations)

    def to_dict(self) -> dict[str, Any]:
        """The stable JSON object of `--json`; numbers that are not finite become None."""
        lists = ("outages", "cpu", "buses", "faults", "expectations", "events")
        document: dict[str, Any] = {
            "format": RESULT_FORMAT,
            "board": self.board,
            "scenario": self.scenario,
            "profile": self.profile,
            "seed": self.seed,
            "duration_s": self.duration_s,
            "wall_s": self.wall_s,
            "real_time_factor": self.real_time_factor,
            "state_hash": self.state_hash,
            "ok": self.ok,
            "metrics": dict(self.metrics),
            "gnss": dict(self.gnss),
            "recording": self.recording,
            "out_dir": None if self.out_dir is None else str(self.out_dir),
        }
        for name in lists:
            document[name] = [asdict(item) for item in getattr(self, name)]
        cleaned: dict[str, Any] = finite_or_none(document)
        return cleaned


def finite_or_none(value: Any) -> Any:
    """A copy of a JSON-like value in which NaN and infinities are None: JSON has neither."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite_or_none(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite_or_none(item) for item in value]
    return value
