"""What `navtwin allan` does: read, fit, tell."""

from __future__ import annotations

import json
from pathlib import Path

from boards.hints import did_you_mean
from host.cli.exit_codes import EXIT_MET
from host.cli.output_files import check_files
from host.cli.terminal import print_section, standard_error, standard_output
from host.record.atomic import write_whole
from host.record.errors import UserError
from host.sim.errors.presets import preset_names
from host.simulate.extras import must_have

RESULT_FORMAT = "navtwin-allan-1"


def execute(file: Path, output: Path | None, preset: str | None, json_file: str | None, quiet: bool) -> int:
    """Returns the exit code. Raises UserError."""
    if preset is not None and preset not in preset_names():
        raise UserError(f"--preset {preset}: no such preset; {did_you_mean(preset, preset_names())}")
    for module in ("scipy", "allantools"):
        must_have(module, "navtwin allan")
    check_files(("-o", output), ("--json", json_file), read=file)
    from host.simulate.allan import curve_of
    from host.simulate.allan_page import page, sections, to_dict
    from host.simulate.imu_record import read_record

    record = read_record(file)
    curves = [curve_of(name, values, record.rate_hz) for name, values in record.channels.items()]
    tables = sections(curves, preset)
    console = standard_error() if json_file == "-" else standard_output()
    if not quiet:
        for table in tables:
            print_section(console, table)
    if output is not None:
        write_whole(output, page(f"Allan deviation of {file.name}", curves, tables), "-o")
        console.print(f"written: {output}", soft_wrap=True)
    if json_file is not None:
        samples = len(next(iter(record.channels.values())))
        about = {"format": RESULT_FORMAT, "file": file.name, "rate_hz": record.rate_hz, "samples": samples}
        text = json.dumps(about | {"channels": to_dict(curves)}, indent=1) + "\n"
        if json_file == "-":
            print(text, end="")
        else:
            write_whole(Path(json_file), text, "--json")
    return EXIT_MET
