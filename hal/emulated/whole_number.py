"""Whole numbers as firmware and chips hand them over: of Python or of NumPy."""

from operator import index
from typing import SupportsIndex


def whole_number(value: SupportsIndex, what: str) -> int:
    """`value` as an integer. Raises TypeError for what is none, 1e6 among it: times and counts are exact."""
    try:
        return index(value)
    except TypeError:
        raise TypeError(
            f"{what} = {value!r}; it must be a whole number, e.g. int(1e6) or 1_000_000"
        ) from None
