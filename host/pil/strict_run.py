"""Inputs of a kernel that it can bear: tried on the interpreted kernel first, strictly.

An index outside the array or negative (which a bare pointer would follow), a float that does not fit the
integer it is cast to, the root of a negative number and a loop without end are errors. For generated inputs
an index outside means that the arrays were too short: they are made longer, and given up in the end.
"""

from __future__ import annotations

import contextlib
import signal
import warnings
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from firmware.numerics.signature import Signature
from host.pil import generated_inputs
from host.pil.generated_inputs import MakeInputs

SECONDS_ALLOWED = 2.0  # of this process, whatever else the machine does
FEWEST_TRIALS = 8
OWNERS_TRIALS = 48

Trial = tuple[tuple[Any, ...], list[Any]]
"""Arguments, and what the kernel left: its arguments, then its results."""


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


def strict_trials(
    name: str, signature: Signature, run: Callable[..., Any], inputs: MakeInputs | None
) -> list[Trial]:
    """Trials of the kernel `name`, whose `run` is of `interpret_strictly`; `inputs` from its owner, or None.

    Raises what the kernel raises: OutOfArrayError, RuntimeWarning …
    """
    if inputs is not None:
        return list(_owners_trials(name, run, inputs))
    return list(_generated_trials(name, signature, run))


def _owners_trials(name: str, run: Callable[..., Any], inputs: MakeInputs) -> Iterator[Trial]:
    rng = generated_inputs.rng_of(name)
    for _ in range(OWNERS_TRIALS):
        arguments = tuple(inputs(rng))
        yield arguments, _run_interpreted(run, arguments)


def _generated_trials(name: str, signature: Signature, run: Callable[..., Any]) -> Iterable[Trial]:
    length = generated_inputs.SMALLEST_LENGTH
    while True:
        trials, outside = [], None
        rng = generated_inputs.rng_of(name)
        for arguments in generated_inputs.generated_inputs(signature, rng, length):
            try:
                trials.append((arguments, _run_interpreted(run, arguments)))
            except OutOfArrayError as error:
                outside = error
        if outside is None or (length >= generated_inputs.LARGEST_LENGTH and len(trials) >= FEWEST_TRIALS):
            return trials
        if length >= generated_inputs.LARGEST_LENGTH:
            raise outside
        length *= 4


def _run_interpreted(run: Callable[..., Any], arguments: tuple[Any, ...]) -> list[Any]:
    given = [_strict(value) if isinstance(value, np.ndarray) else value for value in arguments]
    with np.errstate(all="ignore", invalid="warn"), warnings.catch_warnings(), _time_limit(arguments):
        warnings.filterwarnings("ignore", category=RuntimeWarning)
        warnings.filterwarnings("error", message=".*encountered in cast", category=RuntimeWarning)
        result = run(*given)
    return outcome(given, result)


def _strict(array: Any) -> StrictArray:
    return array.copy().view(StrictArray)


@contextlib.contextmanager
def _time_limit(arguments: tuple[Any, ...]) -> Iterator[None]:
    def stop(_signal: int, _frame: Any) -> None:
        shown = [shown(value) for value in arguments]
        raise _EndlessLoopError(f"no end within {SECONDS_ALLOWED} s for {shown}")

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS_ALLOWED)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def outcome(arguments: Iterable[Any], result: Any) -> list[Any]:
    """What a call left: its arguments, then its results."""
    results = result if isinstance(result, tuple) else (result,)
    return [np.asarray(value) if isinstance(value, np.ndarray) else value for value in (*arguments, *results)]


def shown(value: Any) -> Any:
    """An argument for a message."""
    return f"array of {value.size}: {value[:6].tolist()}…" if isinstance(value, np.ndarray) else value
