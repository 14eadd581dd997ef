"""Instructions of the parts of a navigation step: the strapdown, and the prediction of the filter.

They are inner kernels, which the image calls by themselves on the state that the twin's run has left. The
prediction of all states comes as often as its period says; once a second their process noise is added. What a
filter of 15 states (position, velocity, attitude, both biases) would need is bounded by measured parts: the
columns of all 36 states, the noise of the nine dynamic states, and that of the six biases alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from firmware.nav import covariance, prediction, strapdown
from firmware.nav import layout as at
from firmware.numerics.signature import parse_signature
from host.pil.kernel_table import TargetKernel
from host.pil.lockstep import Lockstep

BIASES = range(at.X_GYRO_BIAS, at.X_GNSS_ERROR)
STEP_S = 0.01
PREDICTION_S = 0.2
SECOND_S = 1.0
SMALL = 1e-9

SIGNATURES = {
    strapdown.advance_between_samples: "void(float32[::1], int64[::1]" + 7 * ", float32" + ")",
    prediction.predict: "void(float32[::1])",
    prediction._map_dynamic_columns: "void(float32[::1], float32)",
    prediction._map_parameter_columns: "void(float32[::1], float32)",
    prediction._add_noise: "void(float32[::1], float32)",
    covariance.add_variance: "void(float32[::1], int64, float32)",
}


def parts_after(entries: int) -> list[TargetKernel]:
    """The parts as kernels of an image, numbered behind so many entries."""
    return [_part(entries + place, *item) for place, item in enumerate(SIGNATURES.items())]


def _part(number: int, kernel: Any, text: str) -> TargetKernel:
    code = kernel.py_func.__code__
    name = f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}"
    return TargetKernel(number, name, parse_signature(text), code.co_varnames[: code.co_argcount])


def ticks_of_parts(lockstep: Lockstep, state: tuple[Any, ...]) -> dict[str, float]:
    """Clock ticks of each part and of sums; `lockstep` is a fresh one, `state` what the run has left."""
    trial = _Trial(lockstep, np.asarray(state[0]), np.asarray(state[1]))
    trial.floats[at.SINCE_TIME] = PREDICTION_S
    trial.floats[at.PARAMETER_TIME] = 0.0
    sample = [np.float32(value) for value in (STEP_S, 0.01, -0.02, 0.05, 0.3, -0.1, -9.7)]
    step = trial.ticks(strapdown.advance_between_samples, trial.integers, *sample)
    plain = trial.ticks(prediction.predict)
    columns = trial.ticks(prediction._map_dynamic_columns, np.float32(PREDICTION_S))
    columns += trial.ticks(prediction._map_parameter_columns, np.float32(PREDICTION_S))
    noise = trial.ticks(prediction._add_noise, np.float32(PREDICTION_S))
    biases = sum(trial.ticks(covariance.add_variance, state, np.float32(SMALL)) for state in BIASES)
    trial.floats[at.PARAMETER_TIME] = SECOND_S
    whole = trial.ticks(prediction.predict)
    return {
        "strapdown": step,
        "prediction of 36 states": plain,
        "prediction of 36 states with their process noise": whole,
        "strapdown and prediction of 36 states": step + plain,
        "strapdown and prediction of 15 states with their process noise": step + columns + noise + biases,
        "strapdown and prediction of 36 states with their process noise": step + whole,
    }


class _Trial:
    """Calls a part on a copy of the state."""

    def __init__(self, lockstep: Lockstep, floats: Any, integers: Any) -> None:
        self.floats = floats.copy()
        self.integers = integers.copy()
        self._lockstep = lockstep
        self._by_name = {kernel.name: kernel for kernel in lockstep.image.kernels}

    def ticks(self, kernel: Any, *arguments: Any) -> float:
        """Of one call."""
        function = kernel.py_func
        part = self._by_name[f"{function.__module__}.{function.__qualname__}"]
        lockstep = self._lockstep
        lockstep.counts.pop(part.name, None)
        kept, integers = self.floats.copy(), self.integers.copy()
        lockstep.call(part, kernel, self.floats, *arguments)
        lockstep.flush()
        self.floats[:] = kept
        self.integers[:] = integers
        return float(lockstep.counts[part.name].total)
