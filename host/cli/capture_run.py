"""What `navtwin capture` does and prints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from host.capture.cutting import cut
from host.capture.export import export
from host.capture.overview import NS, Overview, look_over
from host.capture.places import capture_path
from host.capture.topics import IMPORT_FORMAT
from host.cli.exit_codes import EXIT_MET, EXIT_NOT_MET
from host.cli.output_files import STANDARD_OUTPUT, write_json
from host.cli.terminal import print_section, standard_output
from host.recovery.repair import repair
from host.recovery.whole_reader import WholeReader
from host.report.summary import Section


def show_info(capture: Path, target: str | None) -> int:
    """What was captured."""
    overview, reader = _looked_over(capture)
    write_json({**overview.to_dict(), "decoded_anew": reader.added}, target)
    if target != STANDARD_OUTPUT:
        console = standard_output()
        print_section(console, Section("Capture", ("", ""), tuple(_facts(overview, reader)), words=2))
        print_section(console, _topics(overview))
    return EXIT_MET


def show_check(capture: Path, target: str | None) -> int:
    """What is missing."""
    overview, reader = _looked_over(capture)
    write_json({**overview.to_dict(), "decoded_anew": reader.added}, target)
    if target != STANDARD_OUTPUT:
        console = standard_output()
        for finding in overview.findings:
            console.print(f"- {finding}", soft_wrap=True, markup=False)
        verdict = "whole" if not overview.findings else f"{len(overview.findings)} findings"
        console.print(f"{overview.path}: {verdict}, {overview.recorded_s:,.3f} s recorded", soft_wrap=True)
    return EXIT_MET if not overview.findings else EXIT_NOT_MET


def _looked_over(capture: Path) -> tuple[Overview, WholeReader]:
    reader = WholeReader(capture_path(capture))
    overview = look_over(reader)
    overview.findings += reader.notes
    return overview, reader


def make_cut(capture: Path, target: Path, from_s: float, to_s: float) -> int:
    """A stretch as a capture of its own."""
    messages = cut(WholeReader(capture_path(capture)), target, from_s, to_s)
    print(f"{target}: {messages:,} messages")
    return EXIT_MET


def make_export(capture: Path, kind: str, target: Path, topic: str | None) -> int:
    """Other formats."""
    for path in export(WholeReader(capture_path(capture)), kind, target, topic):
        print(f"  {path}  {path.stat().st_size:,} bytes")
    return EXIT_MET


def make_repair(capture: Path, target: Path) -> int:
    """What is missing, and an index."""
    reader = repair(capture_path(capture), target)
    added = ", ".join(f"{count:,} to {topic}" for topic, count in sorted(reader.added.items()))
    print(f"{target}: added {added or 'an index'}")
    for note in reader.notes:
        print(f"- {note}")
    return EXIT_MET


def _facts(overview: Overview, reader: WholeReader) -> list[tuple[str, str]]:
    manifest = overview.manifest
    if manifest.get("format") == IMPORT_FORMAT:
        return _facts_of_import(overview)
    run = " ".join(str(manifest.get(name, "?")) for name in ("board", "scenario", "profile"))
    versions, overrides = manifest.get("versions"), manifest.get("overrides")
    made_with = versions.items() if isinstance(versions, dict) else ()
    changed = overrides if isinstance(overrides, list) else []
    facts = [
        ("file", f"{overview.path}, {overview.size:,} bytes, {overview.format}"),
        ("run", f"{run} seed {manifest.get('seed', '?')}"),
        ("changed", ", ".join(map(str, changed)) or "nothing"),
        ("made with", ", ".join(f"{name} {version}" for name, version in made_with)),
        ("recorded", f"{overview.recorded_s:,.3f} s{'' if overview.duration_s else ', the run did not end'}"),
        ("state hash", overview.state_hash or "none"),
    ]
    if reader.added:
        facts.append(("decoded anew", f"{sum(reader.added.values()):,} messages, from the raw traffic"))
    if "repaired" in manifest:
        facts.append(("repaired", "what was missing is decoded anew"))
    if "cut" in manifest:
        facts.append(("cut", f"from {manifest['cut']['from_s']:g} to {manifest['cut']['to_s']:g} s"))
    return facts


def _facts_of_import(overview: Overview) -> list[tuple[str, str]]:
    manifest = overview.manifest
    sources, clock = manifest.get("files"), manifest.get("clock")
    files = ", ".join(_source(file) for file in (sources if isinstance(sources, list) else []))
    begins = (clock if isinstance(clock, dict) else {}).get(
        "origin_utc", "not known: the recording's own clock"
    )
    facts = [
        ("file", f"{overview.path}, {overview.size:,} bytes, {overview.format}"),
        ("imported", f"{manifest.get('kind', '?')}: {files}"),
        ("begins", str(begins)),
        ("recorded", f"{overview.recorded_s:,.3f} s"),
    ]
    if "cut" in manifest:
        facts.append(("cut", f"from {manifest['cut']['from_s']:g} to {manifest['cut']['to_s']:g} s"))
    return facts


def _source(file: Any) -> str:
    """One of the files that were imported; in captures of others, anything may stand there."""
    match file:
        case {"name": name, "bytes": int(size)}:
            return f"{name} ({size:,} bytes)"
        case _:
            return str(file)


def _topics(overview: Overview) -> Section:
    rows = []
    for use in overview.topics:
        first = 0 if use.first_ns is None else use.first_ns
        span = (use.last_ns - first) / NS
        rate = f"{(use.records - 1) / span:,.2f}" if span > 0 else "–"
        times = (f"{first / NS:,.3f}", f"{use.last_ns / NS:,.3f}")
        rows.append((use.topic, use.schema, f"{use.records:,}", f"{use.bytes:,}", rate, *times))
    columns = ("topic", "schema", "records", "bytes", "a second", "first, s", "last, s")
    return Section("Topics", columns, tuple(rows), words=2)
