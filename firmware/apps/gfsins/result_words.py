"""A result on the screen: lines of at most 21 characters."""

from __future__ import annotations

import math
from collections.abc import Sequence

G = 9.80665
AXES = 9


def result_lines(name: str, values: Sequence[float]) -> list[str]:
    """Of the DSP's numbers for a procedure."""
    if name == "accelerometers":
        return _accelerometers(values)
    if name == "rates":
        scales = values[0], values[4], values[8]
        return [f"{axis} x {scale:.4f}" for axis, scale in zip("xyz", scales, strict=True)] + [
            f"sigma {_mean(values[12:21:4]) * 100.0:.2f} %"
        ]
    if name == "earth-rate":
        return ["of the Earth's rate", f"scale 1 +- {_mean(values[12:21:4]):.3g}", "not observable"]
    if name == "alignment":
        told = zip(("heading", "pitch", "roll"), values[:3], strict=True)
        return [f"{what} {math.degrees(angle):.1f} deg" for what, angle in told]
    pairs = zip("ABCDE", values[:5], values[5:10], strict=True)
    return [f"{k} {math.degrees(x):+.2f} +-{math.degrees(sigma):.2f}" for k, x, sigma in pairs]


def _accelerometers(values: Sequence[float]) -> list[str]:
    axes = [values[6 * k : 6 * k + 6] for k in range(AXES)]
    scales = [axis[0] for axis in axes]
    offsets = [1e3 * axis[3] / G for axis in axes]
    return [
        f"scale {min(scales):.3f}...{max(scales):.3f}",
        f"+- {_mean([axis[4] for axis in axes]) * 100.0:.3f} %",
        f"zero {min(offsets):+.0f}...{max(offsets):+.0f} mg",
        f"+- {_mean([axis[5] for axis in axes]) * 1e3 / G:.2f} mg",
    ]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
