"""The measurements. All on one core, best of several where a time is told."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from hal import engine
from host.bench.sampling import Shares
from host.record.result import RunRequest

BOARD, SCENARIO = "car_mems", "town-open"
SCENARIOS = {BOARD: SCENARIO, "uav_ahrs": "flight", "dual_antenna": "road", "gfsins": "chapter5"}
"""What each board's speed is measured on."""
TICKS_PER_S = 100
BARE_FROM_S, BARE_TO_S = 200, 300


def speed(repeats: int, duration_s: float | None, board: str = BOARD) -> dict[str, Any]:
    """× real time without and with capture, and where the time goes (of the runs without)."""
    from host.run.runner import run

    scenario = SCENARIOS[board]
    overrides = () if duration_s is None else (f"duration_s={duration_s:g}",)
    run(RunRequest(board, scenario, overrides=("duration_s=10",), capture=False))
    shares = Shares()
    plain, captured = [], []
    with tempfile.TemporaryDirectory() as folder:
        for k in range(repeats):
            plain.append(run(RunRequest(board, scenario, overrides=overrides, capture=False)))
            out = Path(folder) / str(k)
            captured.append(run(RunRequest(board, scenario, overrides=overrides, out_dir=out)))
        with shares.taken():
            sampled = run(RunRequest(board, scenario, overrides=overrides, capture=False))
    best = max(result.real_time_factor for result in plain)
    microseconds = 1e6 / TICKS_PER_S / best
    return {
        "duration_s": sampled.duration_s,
        "real_time_factor": best,
        "real_time_factor_with_capture": max(result.real_time_factor for result in captured),
        "microseconds_per_tick": microseconds,
        "shares_us": shares.of(microseconds),
        "state_hash": sampled.state_hash,
        "engine": engine.description(),
    }


def bare_kernel_us() -> float:
    """The navigation step alone, called in a loop on the bursts of a drive, in µs."""
    from boards.assembly import assemble
    from firmware.apps.car_mems.navigation import NavigationKernels
    from hal.emulated.virtual_time import SECOND
    from host.run.setup import resolve
    from host.run.surroundings import Surroundings
    from host.sim.world import World

    setup = resolve(RunRequest(BOARD, SCENARIO))
    board = assemble(setup.board, setup.profile, Surroundings(World(setup.scenario, 1), None))
    board.machine.run_until(BARE_FROM_S * SECOND)
    memory = next(iter(board.programs.values())).memory()
    bursts: list[tuple[int, bytes]] = []
    board.spi_devices["imu"].observer = lambda start, _end, mosi, miso: (
        bursts.append((start, bytes(miso))) if len(mosi) == 16 else None
    )
    board.machine.run_until(BARE_TO_S * SECOND)
    board.machine.power_off()
    kernels = NavigationKernels("float32")
    f, i = _arrays(memory, kernels)
    raws = [np.frombuffer(bytearray(data), np.uint8) for _, data in bursts]
    times = [start for start, _ in bursts]
    step = kernels.data_ready_step
    begin = time.perf_counter()
    for raw, t in zip(raws, times, strict=True):
        step(f, i, raw, t)
    return (time.perf_counter() - begin) / len(raws) * 1e6


def _arrays(memory: bytes, kernels: Any) -> tuple[Any, Any]:
    """The navigation state as the program's `memory` gives it: floats, then int64."""
    from firmware.apps.car_mems.sample_clock import CLOCK_SIZE
    from firmware.apps.car_mems.steps import CLOCK_AT

    integers = 8 * (int(CLOCK_AT) + CLOCK_SIZE)
    f = np.frombuffer(bytearray(memory[:-integers]), kernels.real)
    i = np.frombuffer(bytearray(memory[-integers:]), np.int64)
    return f, i


def help_s(repeats: int) -> float:
    """Wall-clock seconds of `navtwin --help`."""
    return min(_timed("-m", "host.cli.main", "--help") for _ in range(repeats))


def start_s(repeats: int) -> float:
    """From the start of the process to virtual time in a warm run, s."""
    code = (
        "import time, sys, host.run.runner as runner\n"
        "from host.record.result import RunRequest\n"
        "def reached(*_):\n    raise SystemExit\n"
        "runner._work_off = reached\n"
        f"runner.run(RunRequest({BOARD!r}, {SCENARIO!r}, capture=False))\n"
    )
    return min(_timed("-c", code) for _ in range(repeats))


def _timed(*arguments: str) -> float:
    begin = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=False, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begin


def memory_growth_mb(short_s: float, long_s: float) -> dict[str, float]:
    """Peak resident memory of a short and a long run with capture and report, each in a process of its own,
    in MB (Linux).
    """
    _peak_mb(1.0)  # a process that compiles needs more than one that runs
    peaks = [_peak_mb(duration_s) for duration_s in (short_s, long_s)]
    return {
        "short_s": short_s,
        "long_s": long_s,
        "short_mb": peaks[0],
        "long_mb": peaks[1],
        "growth_mb": peaks[1] - peaks[0],
    }


def _peak_mb(duration_s: float) -> float:
    """VmHWM; the ru_maxrss of a process also holds what its parent had when it began."""
    code = (
        "import sys, tempfile\n"
        "from pathlib import Path\n"
        "from host.record.result import RunRequest\n"
        "from host.run.runner import run\n"
        "with tempfile.TemporaryDirectory() as folder:\n"
        "    change = 'duration_s=' + sys.argv[1]\n"
        f"    run(RunRequest({BOARD!r}, {SCENARIO!r}, overrides=(change,), out_dir=Path(folder) / 'run'))\n"
        "lines = Path('/proc/self/status').read_text().splitlines()\n"
        "print(next(line.split()[1] for line in lines if line.startswith('VmHWM')))\n"
    )
    command = [sys.executable, "-c", code, f"{duration_s:g}"]
    return float(subprocess.run(command, check=True, capture_output=True).stdout) / 1024
