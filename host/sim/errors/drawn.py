"""One specimen of a sensor: its preset with every random constant drawn, in SI units and the sensor's axes.

Measured = true + S true + N true + Q true² + b (+ G f for gyros) + noise, source 002 eqs. 3-35 and 3-36 with
a parabola Q for what is not linear (nothing at zero). Draws come from generators named after the component
and the quantity: changing one value leaves all others alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from host.sim.errors.output_stage import OutputStage
from host.sim.errors.processes import Process
from host.sim.errors.schema import AccelerometerErrors, GyroErrors, ImuErrors, PerAxis
from host.sim.seeding import generator

STANDARD_GRAVITY = 9.80665
DEG = math.pi / 180.0
DPH = DEG / 3600.0
MILLI_G = 1e-3 * STANDARD_GRAVITY
AXES = "xyz"
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Triad:
    """Three axes. Biases in rad/s or m/s², scale errors as fractions."""

    noise_density: Array
    """(3,) per √Hz."""
    bias: Array
    """(3,) fixed and turn-on together."""
    scale: Array
    """(3,) fixed and drawn together."""
    cross: Array
    """(3, 3) off-diagonal coupling; row = measuring axis."""
    bias_per_kelvin: Array
    scale_per_kelvin: Array
    quadratic: Array
    """(3,) of true²: 2 p / F for a deviation of p F from the best straight line over ±F (rad/s, m/s²)."""
    processes: tuple[Process, ...]
    """Nine: bias instability, bias random walk, scale instability, each x, y, z."""


@dataclass(frozen=True)
class Specimen:
    """One sensor as it came out of the factory and was switched on."""

    gyro: Triad
    accelerometer: Triad
    g_sensitivity: Array
    """(3, 3) rad/s per m/s²."""
    start_c: float
    rise_k: float
    rise_time_s: float
    reference_c: float
    output: OutputStage


def draw_specimen(errors: ImuErrors, seed: int, component: str) -> Specimen:
    """Draw the random constants of the sensor called `component`."""
    temperature = errors.temperature
    reference = temperature.start_c if temperature.reference_c is None else temperature.reference_c
    sensitivity = _axes(errors.gyro.g_sensitivity_dps_per_g) * DEG / STANDARD_GRAVITY
    draws = np.array([_normals(seed, f"{component}.gyro_{axis}.g_sensitivity", 3) for axis in AXES])
    return Specimen(
        gyro=_gyro(errors.gyro, seed, component),
        accelerometer=_accelerometer(errors.accelerometer, seed, component),
        g_sensitivity=sensitivity[:, None] * draws,
        start_c=temperature.start_c,
        rise_k=temperature.rise_k,
        rise_time_s=temperature.rise_time_s,
        reference_c=reference,
        output=OutputStage(errors),
    )


def _gyro(e: GyroErrors, seed: int, component: str) -> Triad:
    name = f"{component}.gyro"
    return Triad(
        noise_density=_axes(e.noise_dps_per_rthz) * DEG,
        bias=_axes(e.bias_dps) * DEG + _constants(seed, name, "turn_on", e.turn_on_bias_dps) * DEG,
        scale=1e-2 * (_axes(e.scale_percent) + _constants(seed, name, "scale", e.scale_error_percent)),
        cross=_cross(seed, name, e.misalignment_deg * DEG),
        bias_per_kelvin=_constants(seed, name, "bias_temperature", e.bias_temperature_dps_per_k) * DEG,
        scale_per_kelvin=1e-2
        * _constants(seed, name, "scale_temperature", e.scale_temperature_percent_per_k),
        quadratic=2e-2
        * _constants(seed, name, "nonlinearity", e.nonlinearity_percent)
        / (e.nonlinearity_range_dps * DEG),
        processes=(
            *_processes(name, "instability", _axes(e.instability_dph) * DPH, _axes(e.instability_time_s)),
            *_processes(name, "random_walk", _axes(e.random_walk_dph_per_rts) * DPH, None),
            *_processes(
                name,
                "scale_instability",
                1e-6 * _axes(e.scale_instability_ppm),
                _axes(e.scale_instability_time_s),
            ),
        ),
    )


def _accelerometer(e: AccelerometerErrors, seed: int, component: str) -> Triad:
    name = f"{component}.accelerometer"
    return Triad(
        noise_density=_axes(e.noise_ug_per_rthz) * 1e-3 * MILLI_G,
        bias=(_axes(e.bias_mg) + _constants(seed, name, "turn_on", e.turn_on_bias_mg)) * MILLI_G,
        scale=1e-2 * (_axes(e.scale_percent) + _constants(seed, name, "scale", e.scale_error_percent)),
        cross=_cross(seed, name, e.misalignment_deg * DEG),
        bias_per_kelvin=_constants(seed, name, "bias_temperature", e.bias_temperature_mg_per_k) * MILLI_G,
        scale_per_kelvin=1e-2
        * _constants(seed, name, "scale_temperature", e.scale_temperature_percent_per_k),
        quadratic=2e-2
        * _constants(seed, name, "nonlinearity", e.nonlinearity_percent)
        / (e.nonlinearity_range_g * STANDARD_GRAVITY),
        processes=(
            *_processes(name, "instability", _axes(e.instability_mg) * MILLI_G, _axes(e.instability_time_s)),
            *_processes(name, "random_walk", _axes(e.random_walk_mg_per_rts) * MILLI_G, None),
            *_processes(
                name,
                "scale_instability",
                1e-6 * _axes(e.scale_instability_ppm),
                _axes(e.scale_instability_time_s),
            ),
        ),
    )


def _axes(value: PerAxis) -> Array:
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (3,)).copy()


def _normals(seed: int, name: str, count: int) -> Array:
    return generator(seed, name).standard_normal(count)


def _constants(seed: int, triad: str, quantity: str, sigma: PerAxis) -> Array:
    draws = [_normals(seed, f"{triad}_{axis}.{quantity}", 1)[0] for axis in AXES]
    return _axes(sigma) * np.array(draws)


def _cross(seed: int, triad: str, sigma: float) -> Array:
    draws = np.array([_normals(seed, f"{triad}_{axis}.misalignment", 3) for axis in AXES])
    np.fill_diagonal(draws, 0.0)
    return sigma * draws


def _processes(triad: str, quantity: str, sigma: Array, times: Array | None) -> tuple[Process, ...]:
    return tuple(
        Process(f"{triad}_{axis}.{quantity}", float(sigma[i]), None if times is None else float(times[i]))
        for i, axis in enumerate(AXES)
    )
