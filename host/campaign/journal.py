"""The journal of a campaign: one line for each finished run, on disk before the next one is taken in.

`runs.jsonl` begins with a line that names the campaign; each further line is an `Outcome`. A line torn by a
kill or a full disk is cut off when the journal is opened again: only the runs under way are lost. Wall-clock
times and tracebacks go to `times.jsonl`: they never repeat.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

from host.campaign.folder_lock import FolderLock
from host.campaign.identity import CAMPAIGN_FORMAT
from host.record.errors import UserError

JOURNAL = "runs.jsonl"
TIMES = "times.jsonl"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one run left: its row of the result file, the series of its report, and how long it took."""

    key: str
    number: int
    row: dict[str, Any]
    series: dict[str, Any] = field(default_factory=dict)
    times: dict[str, Any] = field(default_factory=dict)
    again: bool = False
    """The run failed for no reason of its own (its worker died): it is tried again by the next resume."""


class Journal:
    """Opens or begins the journal in a campaign's locked folder; closing it lets go of the lock.

    Raises UserError when it is not this campaign's.
    """

    def __init__(self, folder: Path, campaign: str, lock: FolderLock) -> None:
        self.path = folder / JOURNAL
        self.outcomes: dict[str, Outcome] = {}
        self._campaign = campaign
        self._lock = lock
        try:
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise UserError(f"--out {folder}: cannot be written: {error.strerror}") from None
        try:
            self._length = self._read()
            os.ftruncate(self._file, self._length)
            self._times = (folder / TIMES).open("a", encoding="utf-8")
            if self._length == 0:
                self._append({"format": CAMPAIGN_FORMAT, "campaign": campaign})
        except BaseException:
            os.close(self._file)
            raise

    def add(self, outcome: Outcome) -> None:
        """Keep a finished run: it is on disk when this returns. OSError: it is not, all earlier ones are."""
        line = asdict(outcome)
        times = line.pop("times")
        self._append(line)
        self.outcomes[outcome.key] = outcome
        self._times.write(json.dumps({"key": outcome.key, **times}) + "\n")
        self._times.flush()

    def read_again(self) -> None:
        """Take in what is on disk: an interrupt may have come between a line and its outcome."""
        self._length = self._read()

    def close(self) -> None:
        """Let go of the files."""
        os.close(self._file)
        self._times.close()
        self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _append(self, line: Mapping[str, Any]) -> None:
        text = (json.dumps(line, separators=(",", ":"), allow_nan=False) + "\n").encode()
        try:
            written = 0
            while written < len(text):
                written += os.pwrite(self._file, text[written:], self._length + written)
            os.fsync(self._file)
        except OSError as error:
            os.ftruncate(self._file, self._length)
            raise OSError(error.errno, error.strerror, str(self.path)) from None
        self._length += len(text)

    def _read(self) -> int:
        """Take in all whole lines; returns their length."""
        content = os.pread(self._file, os.fstat(self._file).st_size, 0)
        whole = content[: content.rfind(b"\n") + 1]
        for number, text in enumerate(whole.splitlines(), start=1):
            try:
                line = json.loads(text)
                if number == 1:
                    self._check(line)
                else:
                    outcome = Outcome(**line)
                    self.outcomes[outcome.key] = outcome
            except (ValueError, TypeError):
                raise UserError(
                    f"{self.path}: line {number} is not one of a campaign; remove the file to begin anew"
                ) from None
        return len(whole)

    def _check(self, header: Any) -> None:
        found = header.get("format") if isinstance(header, dict) else None
        if found != CAMPAIGN_FORMAT:
            raise UserError(
                f"{self.path}: is of format {found!r}, this navtwin writes {CAMPAIGN_FORMAT!r};"
                " name a new folder, e.g. --out runs/second"
            )
        if header.get("campaign") != self._campaign:
            raise UserError(f"{self.path}: holds another campaign; name a new folder, e.g. --out runs/second")
