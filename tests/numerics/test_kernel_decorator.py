"""The decorator from its user's side, compiled and interpreted."""

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import kernel_samples
import numpy as np
import pytest

from firmware.numerics.dialect import compiled_forms, kernel, registered_kernels

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]


def run_python(program, **variables):
    environment = dict(os.environ, PYTHONPATH=f"{REPOSITORY}{os.pathsep}{HERE}", **variables)
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout


CALL_ENTRY = """
import json, sys
import numpy as np
import kernel_samples as k
f, i = np.array([3.0, 1.0], np.float32), np.zeros(1, np.int64)
k.entry(f, i, 5, 8.0)
one = k.overflows(1e30)
print(json.dumps([f[:1].tolist(), bool(np.isinf(f[1])), i.tolist(), k.hypotenuse(3, 4.0).hex() if
    isinstance(k.hypotenuse(3, 4.0), float) else float(k.hypotenuse(3, 4.0)).hex(), [float(x) for x in one]]))
print("numba" in sys.modules, file=sys.stderr)
"""


@pytest.mark.parametrize("disable", ["0", "1"])
def test_same_results_compiled_and_interpreted_without_warnings(disable):
    first, infinite, counted, root, (overflowed, rest) = json.loads(
        run_python(CALL_ENTRY, NUMBA_DISABLE_JIT=disable)
    )
    assert first == [10.0]
    assert infinite
    assert counted == [5]
    assert float.fromhex(root) == 5.0
    assert (overflowed, rest) == (float("inf"), 0.0)


def test_interpreted_kernels_do_not_need_numba():
    program = CALL_ENTRY + "assert 'numba' not in sys.modules"
    run_python(program, NUMBA_DISABLE_JIT="1")


def test_importing_the_dialect_does_not_import_numba():
    run_python("import sys, firmware.numerics.dialect; assert 'numba' not in sys.modules")


def test_registry_knows_function_file_and_signature():
    found = {one.name: one for one in registered_kernels()}
    entry = found["kernel_samples.entry"]
    assert entry.file == HERE / "kernel_samples.py"
    assert entry.signature is not None
    assert entry.signature.text == "void(float32[::1], int64[::1], int64, float32)"
    assert entry.callable is kernel_samples.entry
    assert found["kernel_samples.doubled"].signature is None


def test_signature_must_fit_the_parameters():
    with pytest.raises(ValueError, match=r"takes 2 arguments, its signature 'float32\(float32\)' names 1"):

        @kernel("float32(float32)")
        def two_parameters(x, y):
            return x + y


@pytest.mark.parametrize("attempt", [1, 2])
def test_wrong_array_is_refused_at_the_first_and_at_later_calls(attempt):
    @kernel("void(float32[::1])")
    def clear(p):
        p[0] = p[0] - p[0]

    if attempt == 2:
        clear(np.zeros(1, np.float32))
    with pytest.raises(TypeError):
        clear(np.zeros(1, np.float64))


def test_scalars_of_any_python_type_are_converted():
    assert kernel_samples.hypotenuse(3, np.float64(4.0)) == 5.0
    assert kernel_samples.hypotenuse(np.float32(3.0), 4) == 5.0


def test_inner_kernel_is_compiled_once_for_all_literals():
    @kernel
    def plus(x, n):
        return x + n

    @kernel("int64(int64)")
    def many(x):
        return plus(plus(plus(x, 1), 2), 300)

    assert many(0) == 303
    assert len(compiled_forms(plus)) == 1


def test_first_call_may_come_from_several_threads():
    @kernel("float32(float32)")
    def halved(x):
        return x / kernel_samples.TWO

    results = []
    threads = [threading.Thread(target=lambda: results.append(halved(3.0))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [1.5] * 4
