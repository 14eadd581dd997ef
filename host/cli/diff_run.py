"""What `navtwin diff` prints."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import STANDARD_OUTPUT, write_json
from host.cli.terminal import print_section, standard_output
from host.replay.run_difference import COLUMNS, RunDifference, compare_runs
from host.report.summary import Section

SHOWN_DIVERGENCES = 6


def show_difference(first: Path, second: Path, target: str | None) -> int:
    """Compare, write, print; the exit code."""
    found = compare_runs(first, second)
    write_json(found.to_dict(), target)
    if target != STANDARD_OUTPUT:
        _tell(standard_output(), found)
    return EXIT_MET if found.same else EXIT_NOT_MET


def _tell(console: Console, found: RunDifference) -> None:
    facts = tuple((name, str(a), str(b)) for name, (a, b) in found.facts.items())
    if found.state_hashes[0] != found.state_hashes[1]:
        facts += (("state hash", str(found.state_hashes[0]), str(found.state_hashes[1])),)
    if found.ends_s[0] != found.ends_s[1]:
        facts += (("recorded, s", f"{found.ends_s[0]:.3f}", f"{found.ends_s[1]:.3f}"),)
    if facts:
        print_section(console, Section("What differs", ("", "A", "B"), facts, words=3))
    for difference in found.divergences[:SHOWN_DIVERGENCES]:
        console.print(
            f"{difference.wire} parts at {difference.time_ns / 1e9:.9f} s\n"
            f"  A: {difference.recorded}\n  B: {difference.replayed}",
            soft_wrap=True,
            markup=False,
        )
    same = [topic for topic in found.compared_topics if topic not in {one.wire for one in found.divergences}]
    if same:
        console.print(f"equal: {', '.join(same)}", soft_wrap=True)
    if found.stages:
        print_section(console, _growth(found))
        beyond = [
            f"{limit} m: {'never' if t is None else f'{t:.1f} s'}" for limit, t in found.exceeds.items()
        ]
        console.print(f"horizontal difference first beyond {', '.join(beyond)}", soft_wrap=True)
    console.print("nothing differs" if found.same else "they differ")


def _growth(found: RunDifference) -> Section:
    def cell(rms: float | None, largest: float | None) -> str:
        return "–" if rms is None or largest is None else f"{rms:.3g} / {largest:.3g}"

    rows = tuple(
        (
            f"{stage.from_s:.1f} – {stage.to_s:.1f}",
            *(cell(stage.rms[name], stage.max[name]) for name in COLUMNS),
        )
        for stage in found.stages
    )
    titles = ("horizontal, m", "vertical, m", "velocity, m/s", "roll, °", "pitch, °", "yaw, °")
    return Section("Solutions, B minus A: RMS / max", ("from – to, s", *titles), rows)
