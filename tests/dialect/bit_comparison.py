"""The same kernel interpreted and compiled, on the same inputs, bit by bit.

The interpreted run comes first and is strict: an index outside the array or negative (which a bare pointer
would follow), a float that does not fit the integer it is cast to, the root of a negative number and a loop
without end are breaches of their own. Only inputs that pass it reach the compiled code. For generated inputs
an index outside means that the arrays were too short: they are made longer, and given up in the end.
"""

import contextlib
import signal
import warnings
from collections.abc import Iterable, Iterator
from typing import Any

import generated_inputs
import numpy as np
from generated_inputs import MakeInputs
from kernel_builds import Built
from problems import Problem

from firmware.numerics.signature import Signature

SECONDS_ALLOWED = 2.0  # of this process, whatever else the machine does
FEWEST_TRIALS = 8
OWNERS_TRIALS = 48


class OutOfArrayError(IndexError):
    """An index that is no element, or negative."""


class _EndlessLoopError(Exception):
    pass


class StrictArray(np.ndarray):
    """An array whose elements are only reached by indices from 0 to its length."""

    def __getitem__(self, index: Any) -> Any:
        self._check(index)
        return super().__getitem__(index)

    def __setitem__(self, index: Any, value: Any) -> None:
        self._check(index)
        super().__setitem__(index, value)

    def _check(self, index: Any) -> None:
        if not 0 <= index < self.shape[0]:
            raise OutOfArrayError(f"index {index} of an array of {self.shape[0]}")


def interpret_strictly(function: Any, signature: Signature | None) -> Any:
    """Decorator: as `dialect.interpret`, but undefined casts raise RuntimeWarning."""

    def run(*arguments: Any) -> Any:
        if signature is None:
            return function(*arguments)
        pairs = zip(signature.arguments, arguments, strict=True)
        return signature.convert_result(function(*[expected.convert(value) for expected, value in pairs]))

    return run


def compare(interpreted: Built, compiled: Built, inputs: MakeInputs | None) -> Iterator[Problem]:
    """Breaches of one kernel with a signature; `inputs` from its owner, or None for generated ones."""
    name = interpreted.name
    try:
        trials = list(_owners_trials(interpreted, inputs) if inputs else _generated_trials(interpreted))
    except OutOfArrayError as error:
        hint = "" if inputs else f"; give inputs in a {generated_inputs.INPUT_FILE} of its tests"
        yield Problem(name, "index outside the array", f"{error}{hint}")
        return
    except Exception as error:
        yield Problem(name, "interpreted run failed", f"{type(error).__name__}: {error}")
        return
    for arguments, expected in trials:
        given = [value.copy() if isinstance(value, np.ndarray) else value for value in arguments]
        before = repr([_shown(value) for value in given])
        result = compiled.made(*given)
        assert compiled.signature is not None
        with np.errstate(all="ignore"):
            result = compiled.signature.convert_result(result)
        for place, (want, got) in enumerate(zip(expected, _outcome(given, result), strict=True)):
            if (difference := _difference(want, got)) is not None:
                where = f"argument {place}" if place < len(given) else f"result {place - len(given)}"
                yield Problem(name, "interpreted and compiled differ", f"{where}{difference} for {before}")
                return


def _owners_trials(built: Built, inputs: MakeInputs) -> Iterator[tuple[tuple[Any, ...], list[Any]]]:
    rng = generated_inputs.rng_of(built.name)
    for _ in range(OWNERS_TRIALS):
        arguments = tuple(inputs(rng))
        yield arguments, _run_interpreted(built, arguments)


def _generated_trials(built: Built) -> Iterable[tuple[tuple[Any, ...], list[Any]]]:
    assert built.signature is not None
    length = generated_inputs.SMALLEST_LENGTH
    while True:
        trials, outside = [], None
        rng = generated_inputs.rng_of(built.name)
        for arguments in generated_inputs.generated_inputs(built.signature, rng, length):
            try:
                trials.append((arguments, _run_interpreted(built, arguments)))
            except OutOfArrayError as error:
                outside = error
        if outside is None or (length >= generated_inputs.LARGEST_LENGTH and len(trials) >= FEWEST_TRIALS):
            return trials
        if length >= generated_inputs.LARGEST_LENGTH:
            raise outside
        length *= 4


def _run_interpreted(built: Built, arguments: tuple[Any, ...]) -> list[Any]:
    given = [_strict(value) if isinstance(value, np.ndarray) else value for value in arguments]
    with np.errstate(all="ignore", invalid="warn"), warnings.catch_warnings(), _time_limit(arguments):
        warnings.filterwarnings("ignore", category=RuntimeWarning)
        warnings.filterwarnings("error", message=".*encountered in cast", category=RuntimeWarning)
        result = built.made(*given)
    return _outcome(given, result)


def _strict(array: Any) -> StrictArray:
    return array.copy().view(StrictArray)


@contextlib.contextmanager
def _time_limit(arguments: tuple[Any, ...]) -> Iterator[None]:
    def stop(_signal: int, _frame: Any) -> None:
        shown = [_shown(value) for value in arguments]
        raise _EndlessLoopError(f"no end within {SECONDS_ALLOWED} s for {shown}")

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS_ALLOWED)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def _outcome(arguments: Iterable[Any], result: Any) -> list[Any]:
    results = result if isinstance(result, tuple) else (result,)
    return [np.asarray(value) if isinstance(value, np.ndarray) else value for value in (*arguments, *results)]


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


def _shown(value: Any) -> Any:
    return f"array of {value.size}: {value[:6].tolist()}…" if isinstance(value, np.ndarray) else value
