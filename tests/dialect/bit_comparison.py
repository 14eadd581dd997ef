"""The same kernel interpreted and compiled, on the same inputs, bit by bit.

The interpreted run comes first and is strict (host.pil.strict_run): only inputs that pass it reach the
compiled code, what it raises is a breach of its own.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from kernel_builds import Built
from problems import Problem

from host.pil.generated_inputs import INPUT_FILE, MakeInputs
from host.pil.strict_run import OutOfArrayError, outcome, shown, strict_trials


def compare(interpreted: Built, compiled: Built, inputs: MakeInputs | None) -> Iterator[Problem]:
    """Breaches of one kernel with a signature; `inputs` from its owner, or None for generated ones."""
    name = interpreted.name
    assert interpreted.signature is not None
    try:
        trials = strict_trials(name, interpreted.signature, interpreted.made, inputs)
    except OutOfArrayError as error:
        hint = "" if inputs else f"; give inputs in a {INPUT_FILE} of its tests"
        yield Problem(name, "index outside the array", f"{error}{hint}")
        return
    except Exception as error:
        yield Problem(name, "interpreted run failed", f"{type(error).__name__}: {error}")
        return
    for arguments, expected in trials:
        given = [value.copy() if isinstance(value, np.ndarray) else value for value in arguments]
        before = repr([shown(value) for value in given])
        result = compiled.made(*given)
        assert compiled.signature is not None
        with np.errstate(all="ignore"):
            result = compiled.signature.convert_result(result)
        for place, (want, got) in enumerate(zip(expected, outcome(given, result), strict=True)):
            if (difference := _difference(want, got)) is not None:
                where = f"argument {place}" if place < len(given) else f"result {place - len(given)}"
                yield Problem(name, "interpreted and compiled differ", f"{where}{difference} for {before}")
                return


def _bits(value: Any) -> bytes:
    """Bytes of an array or scalar with every NaN made the same."""
    array = np.array(value)
    if array.dtype.kind == "f":
        array = np.where(np.isnan(array), np.array(np.nan, array.dtype), array)
    return array.tobytes()


def _difference(want: Any, got: Any) -> str | None:
    if _bits(want) == _bits(got):
        return None
    if not isinstance(want, np.ndarray):
        return f": {want!r} interpreted, {got!r} compiled"
    place = next(i for i in range(want.size) if _bits(want[i]) != _bits(got[i]))
    return f"[{place}]: {want[place]!r} interpreted, {got[place]!r} compiled"
