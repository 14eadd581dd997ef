"""The typed signature of a kernel, written as numba writes it.

    void(float32[::1], int64[::1])            arrays: contiguous, one-dimensional
    float32(float32)                          scalar in, scalar out
    UniTuple(float32, 4)(float32, float32)    several results of one type
    Tuple((float32, int32))(int64)            several results of different types

The text is parsed here, not by numba, because the interpreted kernels must convert their arguments as
the compiled ones do and must run without numba.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

SCALARS: dict[str, Callable[[Any], Any]] = {
    "float32": np.float32,
    "float64": np.float64,
    "int8": np.int8,
    "int16": np.int16,
    "int32": np.int32,
    "int64": np.int64,
    "uint8": np.uint8,
    "uint16": np.uint16,
    "uint32": np.uint32,
    "uint64": np.uint64,
    "boolean": bool,
}
_ARGUMENT = re.compile(r"\s*(\w+)\s*(\[::1\])?\s*")
_EXAMPLE = 'a valid one: "void(float32[::1], int64)"'


@dataclass(frozen=True, slots=True)
class Argument:
    """One parameter or result: the name of its scalar type, and whether it is an array of it."""

    scalar: str
    is_array: bool

    def convert(self, value: Any) -> Any:
        """`value` as the compiled kernel would receive it; TypeError for an array of another type."""
        if not self.is_array:
            return SCALARS[self.scalar](value)
        if not isinstance(value, np.ndarray):
            raise TypeError(f"a kernel expects a 1-d array of {self.scalar}, got a {type(value).__name__}")
        flat = value.ndim == 1 and value.flags.c_contiguous
        if value.dtype.name != self.scalar or not flat or not value.flags.writeable:
            raise TypeError(
                f"a kernel expects a writable, contiguous, 1-d array of {self.scalar}, "
                f"got {value.dtype} of shape {value.shape} with strides {value.strides}"
            )
        return value


@dataclass(frozen=True, slots=True)
class Signature:
    """Parsed signature; `results` is empty for void."""

    text: str
    results: tuple[Argument, ...]
    arguments: tuple[Argument, ...]
    returns_tuple: bool

    def convert_result(self, value: Any) -> Any:
        """The result of the interpreted function narrowed to the declared type, as the compiled one does."""
        if self.returns_tuple:
            pairs = zip(self.results, value, strict=True)
            return tuple(result.convert(item) for result, item in pairs)
        return self.results[0].convert(value) if self.results else None


def parse_signature(text: str) -> Signature:
    """Parse `text`; ValueError says what is wrong and shows a valid example."""
    opening = _opening_of_last_group(text)
    arguments = _parse_list(text[opening + 1 : text.rindex(")")], text)
    result = text[:opening].strip()
    if result == "void":
        return Signature(text, (), arguments, False)
    if uniform := re.fullmatch(r"UniTuple\((\w+)\s*,\s*(\d+)\)", result):
        one = _parse_list(uniform[1], text)
        return Signature(text, one * int(uniform[2]), arguments, True)
    if mixed := re.fullmatch(r"Tuple\(\((.*)\)\)", result):
        return Signature(text, _parse_list(mixed[1], text), arguments, True)
    return Signature(text, _parse_list(result, text), arguments, False)


def _opening_of_last_group(text: str) -> int:
    depth = 0
    for position in range(len(text) - 1, -1, -1):
        depth += {")": 1, "(": -1}.get(text[position], 0)
        if text[position] == "(" and depth == 0:
            if position == 0 or not text.endswith(")"):
                break
            return position
    raise ValueError(f"kernel signature {text!r} has not the form result(arguments); {_EXAMPLE}")


def _parse_list(items: str, text: str) -> tuple[Argument, ...]:
    if not items.strip():
        return ()
    parsed = []
    for item in items.rstrip(", ").split(","):
        match = _ARGUMENT.fullmatch(item)
        if match is None or match[1] not in SCALARS:
            raise ValueError(f"kernel signature {text!r}: unknown type {item.strip()!r}; {_EXAMPLE}")
        parsed.append(Argument(match[1], match[2] is not None))
    return tuple(parsed)
