"""What `navtwin waves` does and prints."""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

from host.capture.places import capture_path
from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import STANDARD_OUTPUT, check_files, write_json
from host.cli.terminal import progress_bar
from host.waves.drawing import WavesRequest, draw


def make_waves(request: WavesRequest, json_target: str | None, quiet: bool) -> int:
    """Draw, and tell what was drawn."""
    request = dataclasses.replace(request, capture=capture_path(request.capture))
    check_files(("-o", request.target), ("--json", json_target), read=request.capture)
    with progress_bar("waves", quiet) as progress:
        facts = draw(request, progress)
    write_json(facts, json_target)
    if json_target != STANDARD_OUTPUT and not quiet:
        _tell(facts)
    for warning in _warnings(request, facts):
        print(f"navtwin: {warning}", file=sys.stderr)
    return EXIT_MET


def _tell(facts: dict[str, Any]) -> None:
    stretch = f"{facts['from_s']:.9g} to {facts['to_s']:.9g} s"
    print(f"{facts['file']}: {stretch}, {facts['changes']:,} edges, {facts['bytes']:,} bytes")
    for bus in facts["buses"]:
        print(f"  {bus['name']:<8} {bus['kind']:<5} {bus['units']:>10,}  {' '.join(bus['lines'])}")


def _warnings(request: WavesRequest, facts: dict[str, Any]) -> list[str]:
    told = []
    if request.to_s is not None and request.to_s > facts["to_s"]:
        told.append(f"--to {request.to_s:g}: the recording ends at {facts['recorded_s']:.9g} s")
    told += [
        f"{bus['name']}: {bus['cut_short']:,} times traffic began before the one before it had ended"
        for bus in facts["buses"]
        if bus["cut_short"]
    ]
    return told
