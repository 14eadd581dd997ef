"""What a processor needs to run a program's navigation by itself, on raw frames (`firmware.link.raw_frames`).

The image for a processor holds the program's kernels; what the program does around them on the PC is done
there by `firmware/target/loop.c`, which this tells about the program. A program that can do so has a module
`stand_alone` beside it with a function `stand_alone(profile, installation, captures) -> StandAlone`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class StandAlone:
    """A navigation loop as data."""

    floats: NDArray[np.float32]
    """The state as configured: what a reset leaves."""
    integers: NDArray[np.int64]
    sample: Any
    """Kernel (floats, integers, burst, board time of the read) for a sample; returns if it made a step."""
    epoch: Any
    """Kernel (floats, integers, epoch)."""
    temperature: Any
    """Kernel (floats, integers, °C)."""
    solution: Any
    """Kernel (floats, integers, floats of the solution, integers of the solution)."""
    each_sample: bool
    """Every sample is a step, whatever the kernel says."""
    steps: int
    """From one solution to the next."""
    clock: range
    """Of `integers`: what begins anew with the sensor."""
    solution_floats: int
    solution_integers: int
    nominal_latency_ns: int
    longest_pulse_age_ns: int
