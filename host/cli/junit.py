"""Expectations as JUnit XML: one test case each, so that a CI server lists them.

A failure tells value and limit, and the command line that makes the run again; properties of the suite tell
what ran.
"""

from __future__ import annotations

from xml.etree import ElementTree

from host.record.result import RunResult
from host.report.numbers import number
from host.report.summary import limit_text


def junit_xml(result: RunResult, command: str | None = None) -> bytes:
    """The whole document. `command`: the command line that makes the run again."""
    suite_name = f"{result.board}.{result.scenario}.{result.profile}.seed{result.seed}"
    missed = sum(not expectation.ok for expectation in result.expectations)
    totals = {"tests": str(len(result.expectations)), "failures": str(missed), "errors": "0"}
    root = ElementTree.Element("testsuites", {"name": "navtwin", **totals})
    suite = ElementTree.SubElement(
        root, "testsuite", {"name": suite_name, **totals, "time": f"{result.wall_s:.3f}"}
    )
    properties = ElementTree.SubElement(suite, "properties")
    for name in ("board", "scenario", "profile", "seed", "duration_s", "state_hash"):
        ElementTree.SubElement(properties, "property", {"name": name, "value": str(getattr(result, name))})
    for one in result.expectations:
        attributes = {
            "classname": suite_name,
            "name": f"{one.name} {one.relation} {one.limit_name or one.limit}",
            "time": "0",
        }
        case = ElementTree.SubElement(suite, "testcase", attributes)
        if not one.ok:
            message = f"{one.name} is {number(one.value)}, expected {limit_text(one)}"
            failure = ElementTree.SubElement(case, "failure", {"message": message, "type": "expectation"})
            exact = f"{message} (exact: {one.value!r} {one.relation} {one.limit!r})"
            again = f"\nseed: {result.seed}\nreproduce: {command}" if command is not None else ""
            failure.text = exact + again
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"
