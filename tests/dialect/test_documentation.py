"""The page for developers names every rule that the gate knows, and none that no sample proves."""

import re
from pathlib import Path

from gate_runs import REPOSITORY, run_half

PAGE = (REPOSITORY / "docs" / "kernel-dialect.md").read_text(encoding="utf-8")
SAMPLES = (Path(__file__).resolve().parent / "bad_kernels.py").read_text(encoding="utf-8")

# Proved with code of their own in test_gate_catches.py: no sample in Python can break these.
PROVED_ELSEWHERE = {"fused multiply-add"}


def rules_on_the_page():
    rows = [line for line in PAGE.splitlines() if line.startswith("| ") and line.count("|") == 5]
    return {name for row in rows for name in re.findall(r"`([^`]+)`", row.split("|")[4])}


def rules_with_a_sample():
    comments = re.findall(r"^# (.*)\n@kernel", SAMPLES, re.MULTILINE)
    return {breach.split(": ")[1] for comment in comments for breach in comment.split("; ")}


def test_every_rule_on_the_page_is_proved_by_a_sample():
    assert rules_on_the_page() - PROVED_ELSEWHERE == rules_with_a_sample()


def test_modules_named_on_the_page_exist():
    for module in set(re.findall(r"`firmware\.numerics\.(\w+)`", PAGE)):
        assert (REPOSITORY / "firmware" / "numerics" / f"{module}.py").exists(), module


def test_example_on_the_page_keeps_the_rules(tmp_path):
    example = re.search(r"```python\n(import math.*?)```", PAGE, re.DOTALL)
    path = tmp_path / "example.py"
    path.write_text(example[1], encoding="utf-8")
    for half in ("host", "target"):
        report = run_half(half, str(path))
        assert not report.problems, report.text()
