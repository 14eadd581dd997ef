"""The Markdown summary and the JUnit file of a run, read by other libraries."""

from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from host.cli.junit import junit_xml
from host.record.result import Event, Expectation, RunResult
from host.report.markdown import run_summary, summary, table
from host.report.summary import Section

RESULT = RunResult(
    "tilt", "slope", "plain", 7, 60.0, 0.1, "ab12", {"yaw_rms_deg": 2.0}, {},
    expectations=(
        Expectation("yaw_rms_deg", 2.0, "<=", 1.5, False),
        Expectation("deadline_misses", 0.0, "<=", 0.0, True),
    ),
    events=tuple(Event(float(k), "mcu", f"event {k}") for k in range(30)),
)  # fmt: skip
COMMAND = "navtwin run tilt --seed 7"


def tokens(markdown: str):
    return MarkdownIt("commonmark").enable("table").parse(markdown)


def cells(markdown: str) -> list[str]:
    """Text of the cells of all tables, as a reader sees it."""
    found = []
    parsed = tokens(markdown)
    for opening, inline in pairwise(parsed):
        if opening.type in ("th_open", "td_open"):
            found.append("".join(part.content for part in inline.children if part.type.startswith("text")))
    return found


def test_the_verdict_stands_first_and_what_is_missed_is_bold():
    page = run_summary(RESULT, COMMAND)
    assert page.startswith("### tilt slope plain seed 7: 1 of 2 expectations NOT MET\n")
    assert cells(page)[:8] == ["figure", "limit", "value", "verdict", "yaw_rms_deg", "≤ 1.5", "2", "NOT MET"]
    assert page.count("**NOT MET**") == 1
    (fence,) = [token for token in tokens(page) if token.type == "fence"]
    assert fence.content == f"{COMMAND}\n"


def test_numbers_stand_to_the_right_and_words_to_the_left():
    sides = [token.attrGet("style") for token in tokens(run_summary(RESULT)) if token.type == "th_open"]
    assert sides[:4] == [None, None, "text-align:right", None]


def test_notes_stand_below_their_tables_and_without_them():
    extra = [Section("x", ("a",), (("1",),), note="note of x"), Section("y", ("a",), (), note="note of y")]
    page = run_summary(RESULT, None, extra)
    assert page.index("| 1 |") < page.index("note of x") < page.index("note of y") < page.index("<details>")


def test_other_tables_are_folded_and_long_lists_cut():
    page = run_summary(RESULT)
    shown, _, folded = page.partition("<details>")
    assert "Events" not in shown
    assert "event 19" in folded
    assert "event 20" not in folded
    assert "… and 10 more in the report" in folded
    assert "Run it again" not in page


def test_a_run_without_expectations_has_a_page_too():
    page = run_summary(replace(RESULT, expectations=(), events=()))
    assert page.startswith("### tilt slope plain seed 7: no expectations set\n")


TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Zl", "Zp", "Zs")), min_size=1)


@given(st.lists(st.tuples(TEXTS, TEXTS), min_size=1, max_size=4))
def test_no_text_breaks_out_of_its_cell(rows):
    section = Section("any", ("a", "b"), tuple(rows))
    assert cells(table(section)) == ["a", "b", *(text for row in rows for text in row)]


@pytest.mark.parametrize("command", ["navtwin run 'a```b'", "navtwin run '`x`'"])
def test_no_command_breaks_out_of_its_block(command):
    (fence,) = [token for token in tokens(summary("t", "v", [], command=command)) if token.type == "fence"]
    assert fence.content == f"{command}\n"


def test_junit_has_a_case_for_each_expectation_and_tells_how_to_run_it_again():
    suite = ElementTree.fromstring(junit_xml(RESULT, COMMAND)).find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    assert {item.get("name"): item.get("value") for item in suite.iter("property")} == {
        "board": "tilt", "scenario": "slope", "profile": "plain", "seed": "7", "duration_s": "60.0",
        "state_hash": "ab12",
    }  # fmt: skip
    missed, kept = suite.findall("testcase")
    assert missed.get("name") == "yaw_rms_deg <= 1.5"
    failure = missed.find("failure")
    assert failure is not None
    assert failure.get("message") == "yaw_rms_deg is 2, expected ≤ 1.5"
    assert failure.text.splitlines()[1:] == ["seed: 7", f"reproduce: {COMMAND}"]
    assert kept.find("failure") is None
