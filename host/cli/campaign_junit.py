"""A campaign as JUnit XML: a suite for each set-up, in it one case for each expectation, one for the verdict.

A case of an expectation fails when fewer runs than `--pass-share` met it. Its failure tells the share, the
figure over the runs, the limit, the seeds that missed it and the command line of the worst of them. The case
`all expectations` is what decides how the command ends: so many runs met every one. With a baseline, the
case `no worse than the baseline` holds its verdict.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree

from host.baseline.comparison import Comparison
from host.campaign.campaign import Finished
from host.campaign.plan import seeds_text
from host.campaign.row import FINISHED, Value
from host.campaign.summary import SetupSummary, Summary
from host.campaign.tables import interval
from host.record.command_line import command_line
from host.report.numbers import counted, number, percent

ALL = "all expectations"
BASELINE = "no worse than the baseline"

Row = Mapping[str, Value]


def campaign_junit(
    finished: Finished, summary: Summary, share: float, comparison: Comparison | None = None
) -> bytes:
    """The whole document."""
    root = ElementTree.Element("testsuites", {"name": "navtwin"})
    for one in summary.setups:
        _suite(root, finished, one, share)
    if comparison is not None:
        suite = _begin(root, f"{finished.manifest['board']}.{finished.manifest['scenario']}.baseline")
        text = "" if comparison.ok else "\n".join("  ".join(row) for row in comparison.section().rows)
        _case(suite, BASELINE, "" if comparison.ok else comparison.verdict(), text)
        _count(suite)
    _total(root)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _suite(root: ElementTree.Element, finished: Finished, one: SetupSummary, share: float) -> None:
    manifest = finished.manifest
    suite = _begin(root, f"{manifest['board']}.{manifest['scenario']}.{one.setup.label}")
    properties = ElementTree.SubElement(suite, "properties")
    told = {
        "profile": one.setup.profile,
        **{f"set.{key}": value for key, value in one.setup.swept},
        "seeds": seeds_text(finished.plan.seeds),
        "runs": str(one.runs),
        "failed": str(one.failed),
        "pass_share": percent(share),
    }
    for name, value in told.items():
        ElementTree.SubElement(properties, "property", {"name": name, "value": value})
    for name, met in one.expectations.items():
        missed = [row for row in one.rows if not row.get(f"expect.{name}.met")]
        text = _figure_text(one, name)
        message = f"{met} of {counted(one.runs, 'run')} met it, {percent(share)} must; {text}"
        bad = met < share * one.runs
        out = f"{met} of {counted(one.runs, 'run')} met it; {text}"
        _case(suite, _title(one, name), message if bad else "", _detail(finished, one, name, missed), out)
    missed = [row for row in one.rows if not row["met"]]
    bad = one.met < share * one.runs
    message = f"{one.met} of {counted(one.runs, 'run')} met all expectations, {percent(share)} must"
    _case(suite, ALL, message if bad else "", _detail(finished, one, None, missed))
    _count(suite)


def _title(one: SetupSummary, name: str) -> str:
    """The expectation as it is written, `yaw_rms_deg <= 1.5`; a limit may be another figure of the run."""
    limits = {row.get(f"expect.{name}.limit") for row in one.rows if row["status"] == FINISHED}
    relation = next(row[f"expect.{name}.relation"] for row in one.rows if row["status"] == FINISHED)
    return f"{name} {relation} {limits.pop() if len(limits) == 1 else 'a figure of the same run'}"


def _figure_text(one: SetupSummary, name: str) -> str:
    found = one.figures.get(name)
    if found is None:
        return f"{name} could not be computed in any run"
    return (
        f"mean {number(found.mean)} ({interval(found)}), median {number(found.median)},"
        f" 95 % {number(found.p95)}, least {number(found.minimum)}, largest {number(found.maximum)}"
    )


def _detail(finished: Finished, one: SetupSummary, name: str | None, missed: Sequence[Row]) -> str:
    """The seeds that missed it, and the command of the worst."""
    if not missed:
        return ""
    seeds = sorted(int(row["seed"]) for row in missed)  # type: ignore[arg-type]
    lines = [f"seeds that missed it: {seeds_text(seeds)}"]
    worst = missed[0] if name is None else max(missed, key=lambda row: _excess(row, name))
    if name is not None and worst["status"] == FINISHED:
        value, limit = worst.get(name), worst[f"expect.{name}.limit"]
        lines.append(f"worst: seed {worst['seed']}: {value!r}, limit {limit!r}")
    lines += [f"seed {row['seed']}: {row['error']}" for row in missed if row["status"] != FINISHED][:10]
    request = finished.plan.request(one.setup, int(worst["seed"]))  # type: ignore[arg-type]
    return "\n".join([*lines, f"reproduce: {command_line(request)}"])


def _excess(row: Row, name: str) -> float:
    """How far beyond its limit; a figure that could not be computed is farthest, a failed run comes last."""
    if row["status"] != FINISHED:
        return float("-inf")
    value, limit = row.get(name), row[f"expect.{name}.limit"]
    return float("inf") if value is None or limit is None else abs(float(value) - float(limit))


def _begin(root: ElementTree.Element, name: str) -> ElementTree.Element:
    return ElementTree.SubElement(root, "testsuite", {"name": name})


def _case(suite: ElementTree.Element, name: str, message: str, detail: str, out: str = "") -> None:
    attributes = {"classname": suite.attrib["name"], "name": name, "time": "0"}
    case = ElementTree.SubElement(suite, "testcase", attributes)
    if message:
        failure = ElementTree.SubElement(case, "failure", {"message": message, "type": "expectation"})
        failure.text = f"{message}\n{detail}"
    elif out or detail:
        ElementTree.SubElement(case, "system-out").text = "\n".join(filter(None, (out, detail)))


def _count(suite: ElementTree.Element) -> None:
    cases = suite.findall("testcase")
    failed = sum(case.find("failure") is not None for case in cases)
    suite.attrib |= {"tests": str(len(cases)), "failures": str(failed), "errors": "0", "time": "0"}


def _total(root: ElementTree.Element) -> None:
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.attrib[name]) for suite in root)))
