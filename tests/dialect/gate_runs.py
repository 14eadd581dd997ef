"""Runs the two halves of the gate in processes of their own and reads what they found."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]


@dataclass(frozen=True, slots=True)
class GateReport:
    """Breaches as (kernel, rule) -> detail, and the processor time it took."""

    seconds: float
    problems: dict[tuple[str, str], str]

    def rules_broken_by(self, kernel: str) -> set[str]:
        """All rules that `kernel` breaks."""
        return {rule for name, rule in self.problems if name == kernel}

    def text(self) -> str:
        """One line a breach."""
        return "\n".join(f"{name}: {rule}: {detail}" for (name, rule), detail in self.problems.items())


def run_half(half: str, what: str = "firmware") -> GateReport:
    """`half` is host or target; `what` a package below firmware or a file of samples."""
    environment = dict(os.environ, PYTHONPATH=str(REPOSITORY), NUMBA_DISABLE_JIT="0")
    environment["NUMBA_OPT"] = "0" if half == "target" else "3"
    done = subprocess.run(
        [sys.executable, str(HERE / "run_gate.py"), half, what],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, f"the gate itself failed:\n{done.stderr}"
    report = json.loads(done.stdout.splitlines()[-1])  # a kernel that prints may have written before
    problems = {(found["kernel"], found["rule"]): found["detail"] for found in report["problems"]}
    return GateReport(report["seconds"], problems)
