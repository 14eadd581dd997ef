"""What a capture holds, and what is missing in it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from host.capture.blocks import I2cTransaction, LineCut, Mark, SpiTransaction, time_of, unpack
from host.capture.reader import CaptureReader, RawMessage
from host.capture.topics import IMPORT_FORMAT

NS = 1_000_000_000
LONGEST_MARK_STEP_NS = NS
"""Further apart than this, more could have been lost than a capture promises."""
GAP_FACTOR = 5
"""A pause on a sensor's bus this many times its usual step is told."""
PACED = ("/imu/", "/gnss")
TOLD = 20
"""Findings of one kind that are listed."""


@dataclass(slots=True)
class TopicUse:
    """One topic of a capture."""

    topic: str
    schema: str
    records: int = 0
    bytes: int = 0
    first_ns: int | None = None
    last_ns: int = 0

    def add(self, time_ns: int) -> None:
        """One more record."""
        self.records += 1
        if self.first_ns is None:
            self.first_ns = time_ns
        self.last_ns = max(self.last_ns, time_ns)


@dataclass(slots=True)
class Overview:
    """The result of reading a capture once."""

    path: Path
    format: str
    manifest: dict[str, Any]
    size: int
    whole_bytes: int
    complete: bool
    """Whether the file can be read to its very end."""
    state_hash: str | None
    duration_s: float | None
    """Of a run that reached its end."""
    recorded_s: float
    """Everything up to here is in the file."""
    topics: list[TopicUse] = field(default_factory=list)
    findings: list[str] = field(default_factory=list)
    """What is missing or wrong; empty for a capture that is whole."""

    def to_dict(self) -> dict[str, Any]:
        """For `--json`."""
        names = ("board", "scenario", "profile", "seed", "overrides", "versions", "machine")
        return {
            "capture": str(self.path),
            "format": self.format,
            **{name: self.manifest.get(name) for name in names},
            "bytes": self.size,
            "complete": self.complete and self.duration_s is not None,
            "duration_s": self.duration_s,
            "recorded_s": self.recorded_s,
            "state_hash": self.state_hash,
            "topics": [
                {
                    "topic": use.topic,
                    "schema": use.schema,
                    "records": use.records,
                    "bytes": use.bytes,
                    "first_s": None if use.first_ns is None else use.first_ns / NS,
                    "last_s": use.last_ns / NS,
                }
                for use in self.topics
            ],
            "findings": self.findings,
        }


def look_over(reader: CaptureReader) -> Overview:
    """Read a capture once. Raises UserError when it is none."""
    uses: dict[str, TopicUse] = {}
    doubts = Doubts()
    for message in reader.messages():
        if not uses:
            doubts.mark_ns = round(reader.cut_from_s * NS)
            doubts.paced_topics = PACED if reader.manifest.get("format") == IMPORT_FORMAT else ()
        use = uses.setdefault(message.topic, TopicUse(message.topic, message.schema.name))
        use.bytes += len(message.data)
        for time_ns in _times(message, doubts):
            use.add(time_ns)
    duration_ns = reader.end_ns
    last_ns = max((use.last_ns for use in uses.values()), default=0) if doubts.paced_topics else 0
    recorded_ns = duration_ns if duration_ns is not None else max(doubts.mark_ns, last_ns)
    overview = Overview(
        path=reader.path,
        format=reader.format,
        manifest=reader.manifest,
        size=reader.path.stat().st_size,
        whole_bytes=reader.whole_bytes,
        complete=reader.complete,
        state_hash=(reader.summary or {}).get("state_hash"),
        duration_s=None if duration_ns is None else duration_ns / NS,
        recorded_s=recorded_ns / NS,
        topics=sorted(uses.values(), key=lambda use: use.topic),
    )
    overview.findings = [*_ending(overview), *doubts.told()]
    return overview


def _ending(overview: Overview) -> list[str]:
    found = []
    if not overview.complete:
        lost = overview.size - overview.whole_bytes
        found.append(
            f"the file is cut off or damaged behind byte {overview.whole_bytes:,}: the last {lost:,} bytes"
            " cannot be read"
            if lost
            else f"the file ends behind byte {overview.whole_bytes:,}, without the index that a whole one has"
        )
    if overview.duration_s is None and "cut" not in overview.manifest:
        found.append(
            f"the run did not reach its end: everything up to {overview.recorded_s:.3f} s is there,"
            " less than a second more was lost"
        )
        last = [use for use in overview.topics if use.topic in ("/solution", "/gnss")]
        found += [
            f"{use.topic} ends at {use.last_ns / NS:.3f} s; the raw traffic it was decoded from is there"
            for use in last
            if use.last_ns / NS < overview.recorded_s - 1.0
        ]
    return found


class Doubts:
    """Follows times through a capture."""

    def __init__(self) -> None:
        self.mark_ns = 0
        self.paced_topics: tuple[str, ...] = ()
        """Decoded topics that sensors fill at a steady rate; of a run, the raw traffic tells that better."""
        self._last: dict[str, int] = {}
        self._steps: dict[str, int] = {}
        self._gaps: list[str] = []
        self._backward: list[str] = []

    def mark(self, time_ns: int) -> None:
        """Everything up to here has been read."""
        if time_ns - self.mark_ns > LONGEST_MARK_STEP_NS:
            self._gaps.append(
                f"nothing is marked as recorded from {self.mark_ns / NS:.3f} to {time_ns / NS:.3f} s"
            )
        self.mark_ns = time_ns

    def record(self, topic: str, time_ns: int, paced: bool) -> None:
        """A record; `paced`: of a bus that is used at a steady rate."""
        last = self._last.get(topic)
        self._last[topic] = time_ns
        if last is None:
            return
        step = time_ns - last
        if step < 0:
            self._backward.append(f"{topic}: time goes back from {last / NS:.9f} to {time_ns / NS:.9f} s")
        if not paced:
            return
        usual = self._steps.get(topic, 0)
        if usual and step > GAP_FACTOR * usual and step > NS // 10:
            self._gaps.append(f"{topic}: silent from {last / NS:.3f} to {time_ns / NS:.3f} s")
        else:  # the longest step that is no gap, slowly forgotten
            self._steps[topic] = max(step, usual - usual // 64)

    def told(self) -> list[str]:
        """What was found, of each kind at most so many."""
        found = []
        for kind in (self._backward, self._gaps):
            found += kind[:TOLD]
            if len(kind) > TOLD:
                found.append(f"… and {len(kind) - TOLD} more like this")
        return found


def _times(message: RawMessage, doubts: Doubts) -> Iterator[int]:
    if not message.is_raw:
        if doubts.paced_topics and message.topic.startswith(doubts.paced_topics):
            doubts.record(message.topic, message.time_ns, paced=True)
        yield message.time_ns
        return
    for record in unpack(message.schema.name, message.topic, message.data):
        time_ns = time_of(record)
        if isinstance(record, Mark):
            doubts.mark(time_ns)
        elif not isinstance(record, LineCut):
            doubts.record(message.topic, time_ns, isinstance(record, SpiTransaction | I2cTransaction))
        yield time_ns
