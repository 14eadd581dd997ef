"""Reads a capture that was cut off as if its run had decoded everything up to its last mark.

What lies behind the last decoded row comes after the messages of the file. A capture whose run reached its
end, that was cut on purpose or imported, and one of an attached board (which decodes as it goes) is read as
it stands.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from boards.validation import DescriptionError
from host.capture.reader import CaptureReader, RawMessage
from host.record.errors import UserError
from host.record.manifest import MANIFEST_FORMAT
from host.recovery.recorded_run import RecordedRun
from host.recovery.redecoding import decoded_anew
from host.recovery.tail import Tail
from host.sim.scenario.errors import ScenarioError

AS_IT_STANDS = ("cut", "repaired", "attached_to")
"""Keys of a manifest of which each says that nothing is to be decoded anew."""


class WholeReader(CaptureReader):
    """A reader that adds what is missing; `added` and `notes` tell about it afterwards."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.added: dict[str, int] = {}
        """Messages of each topic that were decoded anew."""
        self.notes: list[str] = []

    def messages(self) -> Iterator[RawMessage]:
        """Every message of the file, and behind them what was decoded anew."""
        tail = Tail()
        for message in super().messages():
            tail.add(message)
            yield message
        if self._was_cut_off() and tail.tells_clocks:
            yield from self._missing(tail)

    def _was_cut_off(self) -> bool:
        manifest = self.manifest
        is_run = manifest.get("format") == MANIFEST_FORMAT and not any(k in manifest for k in AS_IT_STANDS)
        return is_run and self.summary is None

    def _missing(self, tail: Tail) -> Iterator[RawMessage]:
        try:
            run = RecordedRun(self.manifest, tail.commands())
            found = decoded_anew(tail, run)
        except (UserError, DescriptionError, ScenarioError, KeyError, TypeError, ValueError) as error:
            self.notes.append(
                f"what was not decoded when the run was cut off cannot be decoded here: {error}"
            )
            return
        if run.without_truth is not None and found:
            self.notes.append(f"rows decoded anew have no errors against the truth: {run.without_truth}")
        known = {topic: (encoding, schema) for topic, encoding, schema in self.declared}
        for topic, time_ns, data in found:
            if topic in known:
                self.added[topic] = self.added.get(topic, 0) + 1
                yield RawMessage(topic, *known[topic], time_ns, data)
