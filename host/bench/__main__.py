"""Benchmark of the car_mems board.

python -m host.bench               speed, shares and start-up: about five minutes of a quiet core at most
python -m host.bench --memory      also a run of ten hours beside one of one hour
python -m host.bench --campaign N  only N runs of ten minutes on two workers beside one process
python -m host.bench --chips       only what a read costs through driver, bus and chip model
python -m host.bench --board NAME  only the speed of another board (uav_ahrs, dual_antenna, gfsins)
python -m host.bench --bytecodes   only byte codes a tick by function, the same on a busy machine
python -m host.bench --json FILE   the figures as JSON ("-": standard output)
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hal import engine

WANTED = {
    "real_time_factor": 1440.0,
    "real_time_factor_with_capture": 1000.0,
    "help_s": 0.4,
    "start_s": 1.5,
}
WANTED_OF_BOARD = {"car_mems": 1440.0, "uav_ahrs": 400.0, "dual_antenna": 200.0, "gfsins": 200.0}
HOUR_S = 3600.0
LEAST_BYTECODES = 0.5
"""A tick; functions with fewer are not listed."""


def main() -> None:
    """Measure, print, and write."""
    parser = argparse.ArgumentParser(prog="python -m host.bench", description=__doc__)
    parser.add_argument("--json", metavar="FILE", help='write the figures ("-": standard output)')
    parser.add_argument("--memory", action="store_true", help="compare ten hours with one")
    parser.add_argument("--campaign", type=int, metavar="N", help="only a campaign of N runs on two workers")
    parser.add_argument("--chips", action="store_true", help="only reads through driver, bus and chip model")
    parser.add_argument("--board", choices=sorted(WANTED_OF_BOARD), help="only this board's speed")
    parser.add_argument("--bytecodes", action="store_true", help="only byte codes a tick by function")
    parser.add_argument("--repeats", type=int, default=3, help="runs of which the best counts")
    parser.add_argument("--duration", type=float, help="seconds of the drive (default: all)")
    options = parser.parse_args()
    if options.campaign:
        from host.bench.campaigns import campaign_speed

        print(json.dumps(campaign_speed(options.campaign), indent=1))
        return
    if options.chips:
        from host.bench.chip_reads import read_us

        print(json.dumps(read_us(options.repeats), indent=1))
        return
    if options.bytecodes:
        os.environ[engine.CHOICE] = "interpreted"  # machine code has no byte codes
        _show_bytecodes()
        return
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    from host.bench import measure

    if options.board:
        figures: dict[str, Any] = measure.speed(options.repeats, options.duration, options.board)
        _write(figures, options.json, lambda: _show_board(options.board, figures))
        return
    figures = measure.speed(options.repeats, options.duration)
    bare = min(measure.bare_kernel_us() for _ in range(options.repeats))
    figures["bare_kernel_us"] = bare
    figures["ratio_to_bare_kernel"] = figures["microseconds_per_tick"] / bare
    figures["help_s"] = measure.help_s(options.repeats)
    figures["start_s"] = measure.start_s(options.repeats)
    if options.memory:
        figures["memory"] = measure.memory_growth_mb(HOUR_S, 10.0 * HOUR_S)
    _write(figures, options.json, lambda: _show(figures))


def _write(figures: dict[str, Any], to: str | None, show: Callable[[], None]) -> None:
    """As JSON where that is wanted; tables unless standard output is taken by it."""
    text = json.dumps(figures, indent=1) + "\n"
    if to == "-":
        sys.stdout.write(text)
        return
    if to:
        Path(to).write_text(text, encoding="utf-8")
    show()


def _show_board(board: str, figures: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    from host.bench.measure import SCENARIOS

    table = Table("figure", "measured", "wanted", title=f"{board}, {SCENARIOS[board]}, one core")
    table.add_row(
        "real_time_factor", f"{figures['real_time_factor']:,.0f} ×", f"{WANTED_OF_BOARD[board]:,g} ×"
    )
    table.add_row("real_time_factor_with_capture", f"{figures['real_time_factor_with_capture']:,.0f} ×", "")
    console = Console()
    console.print(table)
    console.print(_where(figures))
    console.print(f"engine: {figures['engine']}")


def _show_bytecodes() -> None:
    from host.bench.bytecodes import bytecodes_per_tick
    from host.bench.measure import BOARD, SCENARIO

    counts = bytecodes_per_tick(BOARD, SCENARIO)
    print(f"{sum(counts.values()):8.1f} byte codes a tick of 10 ms")
    for name, count in counts.items():
        if count >= LEAST_BYTECODES:
            print(f"{count:8.1f} {name}")


def _show(figures: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("figure", "measured", "wanted", title="car_mems, town-open, full-rate, one core")
    for name, unit in (
        ("real_time_factor", "×"),
        ("real_time_factor_with_capture", "×"),
        ("help_s", "s"),
        ("start_s", "s"),
    ):
        digits = 0 if unit == "×" else 2
        table.add_row(name, f"{figures[name]:,.{digits}f} {unit}", f"{WANTED[name]:,g} {unit}")
    table.add_row("bare_kernel_us", f"{figures['bare_kernel_us']:.2f} µs", "")
    table.add_row("ratio_to_bare_kernel", f"{figures['ratio_to_bare_kernel']:.1f}", "")
    if "memory" in figures:
        table.add_row("memory growth, 1 h to 10 h", f"{figures['memory']['growth_mb']:.0f} MB", "50 MB")
    console = Console()
    console.print(table)
    console.print(_where(figures))
    console.print(f"engine: {figures['engine']}")


def _where(figures: dict[str, Any]) -> Any:
    from rich.table import Table

    where = Table("where (sampled)", "µs a tick of 10 ms", title="where the time goes, without capture")
    for room, microseconds in figures["shares_us"].items():
        where.add_row(room, f"{microseconds:.2f}")
    where.add_row("together", f"{figures['microseconds_per_tick']:.2f}")
    return where


if __name__ == "__main__":
    main()
