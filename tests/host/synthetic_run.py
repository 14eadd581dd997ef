"""A whole recorded run with errors that a filter could have, for tests of report and command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from synthetic_drive import Errors, gnss, motion, solution, times

from host.record.manifest import build_manifest
from host.record.recorder import Recorder
from host.record.result import BusUse, CpuUse, FaultUse, RunResult, TaskUse
from host.record.run_data import BiasEstimate, Innovation, TaskTrace

OUTAGES = ((120.0, 30.0),)

TASKS = (
    TaskUse("imu_ready", 0.031, 24_000, 61.2, 48.0, 1000.0, 0, 0),
    TaskUse("navigation", 0.048, 24_000, 412.0, 51.0, 8000.0, 0, 0),
    TaskUse("filter", 0.001, 240, 2150.0, 1010.0, 50_000.0, 1, 0),
)
CPU = CpuUse("mcu", 0.081, 1, 0, 2816, 0, TASKS)
BUSES = (BusUse("spi1", 0.0114, 24_000, 384_000), BusUse("uart gnss rx", 0.52, 240, 124_000))
FAULTS = (FaultUse("cable", "uart-cut", "gnss", 200.0, 5.0, 4),)


class Limit:
    """An expectation's limit."""

    def __init__(self, relation: str, value: float | None = None, name: str | None = None) -> None:
        self.relation, self.value, self.name = relation, value, name


EXPECT = {
    "position_horizontal_rms_m": Limit("<=", name="gnss.position_horizontal_rms_m"),
    "velocity_rms_mps": Limit("<=", 0.1),
    "yaw_rms_deg": Limit("<=", 0.05),
    "availability": Limit(">=", 0.9),
}


def manifest() -> dict:
    """The manifest of the synthetic run."""
    texts = ('name = "car_mems"\n', 'name = "town"  # <script>alert("&")</script>\n')
    return build_manifest("car_mems", texts[0], "town", texts[1], "full-rate", 3, ["gnss.latency_s=0.1"])


def smooth_noise(seed: int, count: int, sigma: float, steps: int) -> np.ndarray:
    """First-order correlated noise (count, 3)."""
    rng = np.random.default_rng(seed)
    out = np.empty((count, 3))
    value, keep = rng.normal(0, sigma, 3), np.exp(-1 / steps)
    for place in range(count):
        value = keep * value + rng.normal(0, sigma * np.sqrt(1 - keep**2), 3)
        out[place] = value
    return out


def feed(recorder: Recorder, end: float = 240.0) -> None:
    """A drive with one outage, decoded traffic of all kinds and some raw traffic."""
    t, epochs = times(0, end, 10), times(0, end, 1)
    drift = np.clip(t - 120, 0, None) * ((t < 150.5) & (t > 120)) * 0.25
    position = smooth_noise(1, len(t), 0.5, 200) + np.stack((drift, -0.6 * drift, 0 * drift), axis=1)
    errors = Errors(
        position, smooth_noise(2, len(t), 0.03, 50), np.radians(smooth_noise(3, len(t), 0.3, 300))
    )
    fused = solution(t, errors)
    fused.mode[: (12 * 10)] = 1
    fix = (epochs < 120) | (epochs > 150)
    alone = gnss(
        epochs, Errors(smooth_noise(4, len(epochs), 1.6, 100), smooth_noise(5, len(epochs), 0.05, 1)), fix
    )
    rng = np.random.default_rng(9)
    spi = recorder.capture.spi_recorder("spi1") if recorder.capture is not None else None
    for begin in np.arange(0, end, 10):
        mine, own = (t >= begin) & (t < begin + 10), (epochs >= begin) & (epochs < begin + 10)
        recorder.add_gnss(_part(alone, own), motion(epochs[own]))
        for second in epochs[own]:
            recorder.add_covariance(float(second), np.diag([0.5] * 3 + [0.03] * 3 + [0.005] * 3) ** 2)
            truth = (*np.radians([0.4, -0.3, 0.2]), 0.2, -0.1, 0.3)
            values = tuple(np.array([*truth, 0.02, 0.01, 0.08]) * (1 - np.exp(-second / 30)))
            recorder.add_bias(BiasEstimate(float(second), values, (0.001,) * 3 + (0.02,) * 6, truth))
            if fix[int(second)]:
                recorder.add_innovation(
                    Innovation(float(second), tuple(rng.normal(0, 1, 3)) + tuple(rng.normal(0, 0.1, 3)),
                               (1.0,) * 3 + (0.1,) * 3, 63)
                )  # fmt: skip
        recorder.add_solution(_part(fused, mine), motion(t[mine]))
        if spi is not None:
            for instant in t[mine]:
                spi(round(instant * 1e9), round(instant * 1e9) + 24_000, bytes(16), bytes(16))
    recorder.add_event(12_000_000_000, "navigation", "aligned <at> 12 s")
    recorder.add_trace(trace())


def _part(batch, chosen):
    return type(batch)(*(getattr(batch, name)[chosen] for name in batch.__slots__))


def trace() -> TaskTrace:
    """Half a second of a processor."""
    starts, ends, tasks = [], [], []
    for tick in range(50):
        at = 100.0 + tick * 0.01
        for task, offset, length in ((0, 0, 50e-6), (1, 60e-6, 400e-6), (2, 500e-6, 1.1e-3)):
            if task < 2 or tick % 25 == 0:
                starts.append(at + offset)
                ends.append(at + offset + length)
                tasks.append(task)
    names = tuple(task.name for task in TASKS)
    return TaskTrace("mcu", names, np.array(tasks), np.array(starts), np.array(ends))


def run(out: Path | None, capture: bool = True, expect=None) -> RunResult:
    """The whole synthetic run."""
    with Recorder(manifest(), out, capture=capture, outages=OUTAGES) as recorder:
        feed(recorder)
        return recorder.finish(
            duration_s=240.0, wall_s=0.4, state_hash="5e1f" * 16,
            cpu=[CPU], buses=BUSES, faults=FAULTS, expect=EXPECT if expect is None else expect,
        )  # fmt: skip
