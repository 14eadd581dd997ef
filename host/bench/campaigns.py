"""How well a campaign uses two cores: its runs a second beside twice those of one process."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BOARD, SCENARIO = "car_mems", "static"
WORKERS = 2
FEWEST_ALONE = 5


def campaign_speed(runs: int) -> dict[str, float]:
    """Figures of `runs` runs of ten minutes on two workers, start and report included.

    `start_up_ms` is the median time of a run outside its virtual time, scoring included.
    """
    alone_s = _alone_s(max(FEWEST_ALONE, runs // 10))
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "campaign"
        words = ("campaign", BOARD, "--scenario", SCENARIO, "--seeds", f"1-{runs}", "--quiet")
        command = [
            sys.executable,
            "-m",
            "host.cli.main",
            *words,
            "--workers",
            str(WORKERS),
            "--out",
            str(out),
        ]
        begin = time.perf_counter()
        subprocess.run(command, check=False, stdout=subprocess.DEVNULL)
        wall_s = time.perf_counter() - begin
        times = [json.loads(line) for line in (out / "times.jsonl").read_text().splitlines()]
    return {
        "runs": runs,
        "wall_s": wall_s,
        "one_process_s_per_run": alone_s,
        "share_of_twice_one_process": len(times) * alone_s / (WORKERS * wall_s),
        "start_up_ms": 1e3 * statistics.median(one["total_s"] - one["loop_s"] for one in times),
    }


def _alone_s(runs: int) -> float:
    """Seconds a run takes in one warm process, the mean of several."""
    from host.record.result import RunRequest
    from host.run.garbage import settle
    from host.run.runner import run

    run(RunRequest(BOARD, SCENARIO, capture=False))
    settle()
    begin = time.perf_counter()
    for seed in range(1, runs + 1):
        run(RunRequest(BOARD, SCENARIO, seed=seed, capture=False))
    return (time.perf_counter() - begin) / runs
