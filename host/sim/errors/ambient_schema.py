"""What may be said about the errors of a magnetometer, a compass and a barometer.

Every value defaults to no error. Fixed parts are known, the σ of `…_error…` is drawn once a run, drift is a
first-order Gauss–Markov process.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from host.sim.schema import NotNegative, PerAxis, Positive, Table, within

Row = Annotated[list[float], Field(min_length=3, max_length=3)]
LARGEST_SOFT_IRON = 10.0


class MagnetometerErrors(Table):
    """Measured = soft iron · true field in body axes + hard iron + noise."""

    hard_iron_ut: Annotated[PerAxis, within(1000)] = Field(default=0.0, examples=[[5.0, -8.0, 3.0]])
    hard_iron_error_ut: Annotated[PerAxis, within(1000, 0)] = Field(default=0.0, examples=[2.0])
    soft_iron: Annotated[list[Row], Field(min_length=3, max_length=3)] = Field(
        default=[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        examples=[[[1.05, 0.02, 0.0], [0.02, 0.97, 0.0], [0.0, 0.0, 1.0]]],
    )
    noise_ut: Annotated[PerAxis, within(1000, 0)] = Field(default=0.0, examples=[0.3])
    """1 σ of a sample."""

    @field_validator("soft_iron")
    @classmethod
    def _is_a_matrix_of_iron(cls, value: list[Row]) -> list[Row]:
        if max(abs(x) for row in value for x in row) > LARGEST_SOFT_IRON:
            raise ValueError(f"must lie in -{LARGEST_SOFT_IRON:g} … {LARGEST_SOFT_IRON:g}")
        return value


class CompassErrors(Table):
    """Of the angles that a compass shows: pitch, roll, heading. Beside them there is its resolution only."""

    noise_deg: Annotated[PerAxis, within(90, 0)] = Field(default=0.0, examples=[[0.5, 0.5, 1.0]])
    """1 σ of a reading."""
    markov_deg: Annotated[PerAxis, within(90, 0)] = Field(default=0.0, examples=[[0.03, 0.04, 0.1]])
    """1 σ of an error that lasts …"""
    markov_time_s: Positive = Field(default=300.0, ge=1.0, le=1e7, examples=[300.0])
    initial_deg: Annotated[PerAxis, within(90, 0)] = Field(default=0.0, examples=[[0.08, 0.08, 0.1]])
    """… and of what it begins with."""


class BarometerErrors(Table):
    """The atmosphere is the standard one, shifted to `sea_level_hpa`."""

    sea_level_hpa: float = Field(default=1013.25, ge=850.0, le=1100.0, examples=[1013.25])
    bias_pa: float = Field(default=0.0, ge=-1e5, le=1e5, examples=[50.0])
    bias_error_pa: NotNegative = Field(default=0.0, le=1e5, examples=[30.0])
    drift_pa: NotNegative = Field(default=0.0, le=1e5, examples=[20.0])
    drift_time_s: Positive = Field(default=3600.0, ge=1.0, le=1e7, examples=[3600.0])
    noise_pa: NotNegative = Field(default=0.0, le=1e5, examples=[3.0])
    """1 σ of a sample."""
