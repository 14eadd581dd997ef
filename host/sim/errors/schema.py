"""What may be said about the errors of an inertial sensor: units of data sheets, one value or one per axis.

Every value defaults to no error. `bias` and `scale` are fixed and known, the σ of `turn_on_…`, `scale_…` and
`misalignment_…` are drawn once a run, Gauss–Markov and random-walk parts run on. Source 002, section 2.5.
Beyond it: temperature, non-linearity, bandwidth, range and resolution.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from host.sim.schema import NotNegative, PerAxis, Positive, Table, within

CorrelationTime = Annotated[PerAxis, within(1e7, 1.0)]
"""Parts that change faster than within a second belong to the white noise."""


class GyroErrors(Table):
    """Gyro triad."""

    noise_dps_per_rthz: Annotated[PerAxis, within(100, 0)] = Field(default=0.0, examples=[0.005])
    bias_dps: Annotated[PerAxis, within(2_000)] = Field(default=0.0, examples=[[0.3, -0.2, 0.1]])
    turn_on_bias_dps: Annotated[PerAxis, within(2_000, 0)] = Field(default=0.0, examples=[0.5])
    instability_dph: Annotated[PerAxis, within(1e6, 0)] = Field(default=0.0, examples=[8.0])
    instability_time_s: CorrelationTime = Field(default=100.0, examples=[100.0])
    random_walk_dph_per_rts: Annotated[PerAxis, within(1e6, 0)] = Field(default=0.0, examples=[0.3])
    scale_percent: Annotated[PerAxis, within(50)] = Field(default=0.0, examples=[0.5])
    scale_error_percent: Annotated[PerAxis, within(50, 0)] = Field(default=0.0, examples=[0.5])
    scale_instability_ppm: Annotated[PerAxis, within(100000, 0)] = Field(default=0.0, examples=[100.0])
    scale_instability_time_s: CorrelationTime = Field(default=1000.0, examples=[1000.0])
    misalignment_deg: NotNegative = Field(default=0.0, le=45.0, examples=[0.2])
    g_sensitivity_dps_per_g: Annotated[PerAxis, within(100, 0)] = Field(default=0.0, examples=[0.01])
    bias_temperature_dps_per_k: Annotated[PerAxis, within(100, 0)] = Field(default=0.0, examples=[0.05])
    scale_temperature_percent_per_k: Annotated[PerAxis, within(10, 0)] = Field(default=0.0, examples=[0.02])
    nonlinearity_percent: Annotated[PerAxis, within(10, 0)] = Field(default=0.0, examples=[0.01])
    nonlinearity_range_dps: Positive = Field(default=450.0, le=1e5, examples=[450.0])
    bandwidth_hz: Positive | None = Field(default=None, le=1e5, examples=[50.0])
    range_dps: Positive | None = Field(default=None, le=1e5, examples=[450.0])
    resolution_dps: Positive | None = Field(default=None, le=1e3, examples=[0.02])


class AccelerometerErrors(Table):
    """Accelerometer triad."""

    noise_ug_per_rthz: Annotated[PerAxis, within(1e6, 0)] = Field(default=0.0, examples=[180.0])
    bias_mg: Annotated[PerAxis, within(16_000)] = Field(default=0.0, examples=[[10.0, -20.0, 5.0]])
    turn_on_bias_mg: Annotated[PerAxis, within(16_000, 0)] = Field(default=0.0, examples=[40.0])
    instability_mg: Annotated[PerAxis, within(16_000, 0)] = Field(default=0.0, examples=[0.1])
    instability_time_s: CorrelationTime = Field(default=100.0, examples=[100.0])
    random_walk_mg_per_rts: Annotated[PerAxis, within(16_000, 0)] = Field(default=0.0, examples=[0.005])
    scale_percent: Annotated[PerAxis, within(50)] = Field(default=0.0, examples=[0.5])
    scale_error_percent: Annotated[PerAxis, within(50, 0)] = Field(default=0.0, examples=[0.5])
    scale_instability_ppm: Annotated[PerAxis, within(100000, 0)] = Field(default=0.0, examples=[100.0])
    scale_instability_time_s: CorrelationTime = Field(default=1000.0, examples=[1000.0])
    misalignment_deg: NotNegative = Field(default=0.0, le=45.0, examples=[0.2])
    bias_temperature_mg_per_k: Annotated[PerAxis, within(1_000, 0)] = Field(default=0.0, examples=[1.0])
    scale_temperature_percent_per_k: Annotated[PerAxis, within(10, 0)] = Field(default=0.0, examples=[0.03])
    nonlinearity_percent: Annotated[PerAxis, within(10, 0)] = Field(default=0.0, examples=[0.1])
    nonlinearity_range_g: Positive = Field(default=10.0, le=1e5, examples=[10.0])
    bandwidth_hz: Positive | None = Field(default=None, le=1e5, examples=[50.0])
    range_g: Positive | None = Field(default=None, le=1e5, examples=[18.0])
    resolution_mg: Positive | None = Field(default=None, le=1e3, examples=[0.8])


class Temperature(Table):
    """Temperature of the chip: start + rise · (1 − exp(−t / time)).

    Drift counts from `reference_c`, where the turn-on bias applies; left out, that is the start.
    """

    start_c: float = Field(default=25.0, ge=-60.0, le=125.0, examples=[25.0])
    rise_k: float = Field(default=0.0, ge=-100.0, le=100.0, examples=[5.0])
    rise_time_s: Positive = Field(default=900.0, le=1e7, examples=[900.0])
    reference_c: float | None = Field(default=None, ge=-60.0, le=125.0, examples=[25.0])


class ImuErrors(Table):
    """Both triads of one inertial sensor."""

    preset: str | None = Field(default=None, examples=["bmi160"])
    gyro: GyroErrors = GyroErrors()
    accelerometer: AccelerometerErrors = AccelerometerErrors()
    temperature: Temperature = Temperature()
