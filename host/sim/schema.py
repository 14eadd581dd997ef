"""Base of all tables of a scenario file, and the number types whose messages show a valid example."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field


class Table(BaseModel):
    """One table: unknown keys are errors, text is never taken for a number, nothing changes after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


NotNegative = Annotated[float, Field(ge=0.0)]
Positive = Annotated[float, Field(gt=0.0)]
PerAxis = float | Annotated[list[float], Field(min_length=3, max_length=3)]
"""One number for all three axes, or a list of three."""


def within(largest: float, least: float | None = None) -> AfterValidator:
    """Every value lies between `least` (left out: −`largest`) and `largest`; what is beyond is no sensor,
    receiver or vehicle but a slip of the pen.
    """
    lower = -largest if least is None else least

    def check(value: PerAxis) -> PerAxis:
        values = value if isinstance(value, list) else [value]
        if lower == 0.0 and min(values) < 0.0:
            raise ValueError("must not be negative")
        if min(values) < lower or max(values) > largest:
            raise ValueError(f"must lie in {lower:g} … {largest:g}")
        return value

    return AfterValidator(check)
