"""Base of all tables of a scenario file, and the number types whose messages show a valid example."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class Table(BaseModel):
    """One table: unknown keys are errors, text is never taken for a number, nothing changes after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


NotNegative = Annotated[float, Field(ge=0.0)]
Positive = Annotated[float, Field(gt=0.0)]
PerAxis = float | Annotated[list[float], Field(min_length=3, max_length=3)]
"""One number for all three axes, or a list of three."""
