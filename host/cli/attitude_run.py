"""What `navtwin attitude` does: find, read, run every filter, tell."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from boards.hints import did_you_mean
from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import check_files, for_people, write_json
from host.cli.terminal import print_section
from host.record.errors import UserError

NONE = "none"
LONGEST_DELAY_MS = 100.0


@dataclass(frozen=True, slots=True)
class Choice:
    """What was asked for, lists as they were written."""

    recordings: Sequence[str]
    feeds: str
    beside: str
    arithmetics: str
    gyro_delay_ms: float


def execute(choice: Choice, data: Path | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    from firmware.nav.drift.settings import DriftSettings
    from host.attitude.comparison import FEEDS, compared, contenders, table, to_dict
    from host.attitude.estimates import ARITHMETICS, FIXED
    from host.attitude.finding import find_recordings
    from host.attitude.peers import PEERS, is_installed
    from host.attitude.recording import read_recording

    feeds = _listed("--feed", choice.feeds, FEEDS)
    beside = [] if choice.beside.strip() == NONE else _listed("--beside", choice.beside, (*PEERS, NONE))
    arithmetics = _listed("--arithmetic", choice.arithmetics, ARITHMETICS)
    if NONE in beside:
        raise UserError(f"--beside {choice.beside}: {NONE} stands alone")
    delay = choice.gyro_delay_ms
    if not (math.isfinite(delay) and 0.0 <= delay <= LONGEST_DELAY_MS):
        raise UserError(f"--gyro-delay {delay:g}: it lies in 0 … {LONGEST_DELAY_MS:g} ms, e.g. 2.6")
    if delay > 0.0 and FIXED in arithmetics:
        raise UserError("--gyro-delay is known to the float filters only: add --arithmetic float32")
    check_files(("--json", json_file))
    paths = find_recordings(choice.recordings, data)
    recordings = [read_recording(path) for path in paths]
    for peer in beside:
        if not is_installed(peer):
            print(f"navtwin: {peer} is not installed and left out: pip install {peer}", file=sys.stderr)
    settings = DriftSettings(gyro_delay=1e-3 * delay)
    line_up = contenders(feeds, [peer for peer in beside if is_installed(peer)], settings, arithmetics)
    results = [compared(recording, contender) for recording in recordings for contender in line_up]
    for result in results:
        if result.left_out is not None:
            print(f"navtwin: {result.left_out}", file=sys.stderr)
    if not quiet:
        print_section(for_people(json_file), table(results))
    write_json(to_dict(results), json_file)
    return EXIT_MET


def _listed(option: str, text: str, possible: Sequence[str]) -> list[str]:
    """Names of a list with commas, each once."""
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise UserError(f"{option}: names nothing; possible: {', '.join(possible)}")
    for name in names:
        if name not in possible:
            raise UserError(f"{option} {name}: {did_you_mean(name, possible)}")
    return list(dict.fromkeys(names))
