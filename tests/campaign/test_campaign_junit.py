"""`navtwin campaign --junit`, read by ElementTree and held against the result file."""

from __future__ import annotations

import shlex
from pathlib import Path
from xml.etree import ElementTree

import pytest
from campaign_rig import campaign, navtwin, rows

SHORT = ("-j", 2)


def suites(file: Path) -> list[ElementTree.Element]:
    return ElementTree.parse(file).getroot().findall("testsuite")


def cases(suite: ElementTree.Element) -> dict[str, ElementTree.Element]:
    return {case.attrib["name"]: case for case in suite.findall("testcase")}


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four runs with a limit that two of them keep."""
    out = tmp_path_factory.mktemp("junit")
    campaign(out / "free", *SHORT, "--set", "expect={}", seeds="1-4")
    values = sorted(row["velocity_rms_mps"] for row in rows(out / "free"))
    limits = f'expect={{velocity_rms_mps={sum(values[1:3]) / 2!r}, availability=">= 0.5"}}'
    result = campaign(out / "c", *SHORT, "--set", limits, "--junit", out / "j.xml", seeds="1-4")
    assert result.exit_code == 1
    return out


def test_a_case_for_each_expectation_with_share_figure_limit_seeds_and_command(judged: Path) -> None:
    (suite,) = suites(judged / "j.xml")
    found = cases(suite)
    assert [name.split()[0] for name in found] == ["velocity_rms_mps", "availability", "all"]
    assert (suite.attrib["tests"], suite.attrib["failures"]) == ("3", "2")
    table = rows(judged / "c")
    missed = [row for row in table if not row["expect.velocity_rms_mps.met"]]
    assert len(missed) == 2
    (name,) = [name for name in found if name.startswith("velocity")]
    assert name == f"velocity_rms_mps <= {table[0]['expect.velocity_rms_mps.limit']}"
    failure = found[name].find("failure")
    assert failure is not None
    assert failure.attrib["message"].startswith("2 of 4 runs met it, 100.00 % must; mean ")
    assert failure.text is not None
    seeds, worst, again = failure.text.splitlines()[1:]
    assert seeds in {f"seeds that missed it: {text}" for text in _texts(missed)}
    largest = max(missed, key=lambda row: row["velocity_rms_mps"])
    assert worst.startswith(f"worst: seed {largest['seed']}: {largest['velocity_rms_mps']!r}, limit ")
    assert found["availability >= 0.5"].find("failure") is None
    command = shlex.split(again.removeprefix("reproduce: "))
    assert command[:2] == ["navtwin", "run"]
    repeated = navtwin(*command[1:], "--no-capture", "--out", judged / "again", "-q")
    assert repeated.exit_code == 1, repeated.output


def _texts(missed: list[dict[str, object]]) -> list[str]:
    one, other = sorted(int(str(row["seed"])) for row in missed)
    return [f"{one},{other}", f"{one}-{other}"]


def test_a_share_that_is_enough_makes_a_case_pass(judged: Path) -> None:
    limits = f"expect={_expect(judged)}"
    more = ("--set", limits, "--pass-share", "50%", "--junit", judged / "share.xml")
    assert campaign(judged / "c", *SHORT, *more, seeds="1-4").exit_code == 0
    (suite,) = suites(judged / "share.xml")
    assert suite.attrib["failures"] == "0"
    told = [case.findtext("system-out") or "" for case in cases(suite).values()]
    assert told[0].startswith("2 of 4 runs met it; mean ")
    assert "seeds that missed it: " in told[0]


def _expect(judged: Path) -> str:
    limit = rows(judged / "c")[0]["expect.velocity_rms_mps.limit"]
    return f'{{velocity_rms_mps={limit!r}, availability=">= 0.5"}}'


def test_set_ups_are_suites_and_a_baseline_is_one_more(judged: Path, tmp_path: Path) -> None:
    swept = ("--set", "gnss.latency_s=0.05,0.3", "--set", f"expect={_expect(judged)}")
    campaign(tmp_path / "a", *SHORT, *swept, "--junit", tmp_path / "j.xml", seeds="1-2")
    names = [suite.attrib["name"] for suite in suites(tmp_path / "j.xml")]
    assert names == [f"car_mems.rest.full-rate gnss.latency_s={value}" for value in ("0.05", "0.3")]
    base = tmp_path / "good.json"
    campaign(tmp_path / "b", *SHORT, "--set", "expect={}", seeds="1-2")
    assert navtwin("baseline", "update", base, tmp_path / "b").exit_code == 0
    same = ("--set", "expect={}", "--baseline", base, "--junit", tmp_path / "base.xml")
    assert campaign(tmp_path / "b", *SHORT, *same, seeds="1-2").exit_code == 0
    last = suites(tmp_path / "base.xml")[-1]
    assert [*cases(last)] == ["no worse than the baseline"]
    assert last.attrib["failures"] == "0"


def test_a_file_that_cannot_be_written_is_told_before_any_run(tmp_path: Path) -> None:
    result = campaign(tmp_path / "c", "--junit", tmp_path / "no" / "j.xml")
    assert result.exit_code == 2
    assert "--junit" in result.stderr
    assert not (tmp_path / "c").exists()
