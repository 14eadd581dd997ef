"""What may be said about a GNSS receiver's solutions in a scenario. The defaults are a NEO-M8N's.

Position error per horizontal axis: white noise per epoch plus a first-order Gauss–Markov process; vertical
both times `vertical_factor`. Velocity error: white per axis. The latency (validity to first byte of output)
is `latency_s` plus one normal draw of `latency_sigma_s` per run, plus one of `latency_jitter_s` per epoch.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from host.sim.schema import NotNegative, Table


class BaselineSettings(Table):
    """Errors of the vector between two antennas `for_length_m` apart; those of angles go with its inverse."""

    heading_white_deg: NotNegative = Field(default=0.08, le=90.0, examples=[0.08])
    heading_markov_deg: NotNegative = Field(default=0.06, le=90.0, examples=[0.06])
    markov_time_s: float = Field(default=60.0, ge=1.0, le=1e6, examples=[60.0])
    for_length_m: float = Field(default=2.0, ge=0.1, le=100.0, examples=[2.0])
    pitch_factor: NotNegative = Field(default=1.7, le=100.0, examples=[1.7])
    length_white_m: NotNegative = Field(default=0.005, le=100.0, examples=[0.005])
    fixing_s: NotNegative = Field(default=10.0, le=3600.0, examples=[10.0])
    float_factor: float = Field(default=10.0, ge=1.0, le=1000.0, examples=[10.0])


class GnssSettings(Table):
    """Errors and sky of one receiver."""

    position_white_m: NotNegative = Field(default=0.5, le=10000.0, examples=[0.5])
    position_markov_m: NotNegative = Field(default=1.5, le=10000.0, examples=[1.5])
    position_markov_time_s: float = Field(default=300.0, ge=1.0, le=1e6, examples=[300.0])
    vertical_factor: NotNegative = Field(default=1.7, le=100.0, examples=[1.7])
    velocity_white_mps: NotNegative = Field(default=0.05, le=1000.0, examples=[0.05])
    latency_s: float = Field(default=0.08, ge=0.0, le=2.0, examples=[0.08])
    latency_sigma_s: float = Field(default=0.015, ge=0.0, le=0.5, examples=[0.015])
    latency_jitter_s: float = Field(default=0.0, ge=0.0, le=0.5, examples=[0.005])
    reacquisition_s: NotNegative = Field(default=2.0, le=3600.0, examples=[2.0])
    constellations: list[Literal["GPS", "GLONASS"]] = Field(
        default=["GPS", "GLONASS"], min_length=1, examples=[["GPS", "GLONASS"]]
    )
    elevation_mask_deg: float = Field(default=5.0, ge=0.0, le=60.0, examples=[5.0])
    baseline: BaselineSettings = BaselineSettings()
    """Of receivers with two antennas."""
