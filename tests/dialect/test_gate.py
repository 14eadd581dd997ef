"""Every kernel of the product keeps the rules of the dialect."""

import os
import subprocess
import sys

import pytest
import source_rules
from gate_runs import REPOSITORY, run_half
from kernel_builds import build_product, kernel_modules


def test_modules_with_kernels_are_found():
    assert {f"firmware.numerics.{name}" for name in ("trigonometry", "quaternion")} <= set(kernel_modules())


def test_sources_keep_the_rules():
    built = build_product("source_rules", lambda function, signature: function)
    functions = [one.function for one in built.values()]
    found = source_rules.violations(functions, all_kernels=functions)
    assert not found, "\n".join(str(violation) for violation in found)


@pytest.mark.parametrize("half", ["host", pytest.param("target", marks=pytest.mark.soak)])
def test_compiled_kernels_keep_the_rules(half):
    report = run_half(half)
    assert not report.problems, report.text()


def test_kernels_run_interpreted_without_numba():
    """NUMBA_DISABLE_JIT=1 as a developer would use it: every kernel module imports, none imports numba."""
    program = "import sys\n" + "".join(f"import {module}\n" for module in kernel_modules())
    program += "assert 'numba' not in sys.modules, 'numba was imported'\n"
    environment = dict(os.environ, PYTHONPATH=str(REPOSITORY), NUMBA_DISABLE_JIT="1")
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
