"""The report page: whole, offline, safe, of bounded size, and the same each time."""

import base64
import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import synthetic_run

from host.record.run_data import NAVIGATING
from host.report.numbers import number, percent
from host.report.page import render
from host.report.summary import limit_text, sections, verdict


@pytest.fixture(scope="module")
def result():
    return synthetic_run.run(None)


@pytest.fixture(scope="module")
def page(result):
    return render(result, synthetic_run.manifest())


def block(page, key):
    return json.loads(re.search(rf'<script type="application/json" id="{key}">(.*?)</script>', page, re.S)[1])


def test_the_page_loads_nothing_from_anywhere(page):
    outside_of_the_library = re.sub(r"<script>/\*\*.*?</script>", "", page, count=1, flags=re.S)
    assert not re.search(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", outside_of_the_library)
    assert "<link" not in outside_of_the_library
    assert len(page.encode()) < 6_000_000


def test_the_same_run_gives_the_same_page_whatever_the_wall_clock(result, page):
    assert render(replace(result, wall_s=99.0), synthetic_run.manifest()) == page


def test_texts_of_users_are_shown_not_run(page):
    assert '<script>alert("&")' not in page
    assert "&lt;script&gt;alert(&quot;&amp;&quot;)" in page
    assert "aligned &lt;at&gt; 12 s" in page


def test_verdict_and_expectations_stand_first(page):
    assert '<div class="verdict bad">1 of 4 expectations NOT MET</div>' in page
    assert page.index("Expectations") < page.index("Errors against the truth") < page.index("Track")


def test_every_chart_has_its_place_and_its_columns(page):
    figures, data = block(page, "figures"), block(page, "data")
    keys = [figure["key"] for figure in figures]
    assert keys == ["track", "position", "velocity", "attitude", "innovations", "biases", "timeline-mcu"]
    for figure in figures:
        assert page.count(f'id="{figure["key"]}"') == 1
        for trace in figure["traces"]:
            for axis in ("x", "y"):
                if "$" in trace[axis]:
                    assert trace[axis]["$"] in data
    lengths = {name: len(base64.b64decode(text)) // 4 for name, text in data.items()}
    assert {lengths[name] for name in lengths if name.startswith("solution.")} == {2400}


def test_columns_hold_the_series(result, page):
    text = block(page, "data")["solution.error_north_m"]
    shown = np.frombuffer(base64.b64decode(text), dtype="<f4")
    np.testing.assert_array_equal(shown, result.data.solution.column("error_north_m").astype("<f4"))


def test_before_alignment_there_is_no_place_on_the_track(result):
    solution = result.data.solution
    waiting = solution.column("mode") < NAVIGATING
    assert waiting.any()
    assert np.isnan(solution.column("east_m")[waiting]).all()
    assert np.isfinite(solution.column("east_m")[~waiting]).all()


def test_a_result_without_series_is_a_page_of_tables(result):
    page = render(replace(result, data=None), synthetic_run.manifest())
    assert "Errors against the truth" in page
    assert "plotly" not in page.lower()


def test_tables_tell_the_figures_of_the_result(result):
    tables = {section.title: section for section in sections(result)}
    rows = {row[0]: row for row in tables["Errors against the truth"].rows}
    assert rows["horizontal position, m"][1] == number(result.metrics["position_horizontal_rms_m"])
    assert rows["horizontal position, m"][4] == number(result.gnss["position_horizontal_rms_m"])
    assert [row[-1] for row in tables["Expectations"].rows] == ["OK", "OK", "NOT MET", "OK"]
    assert tables["GNSS outages"].rows[0][:2] == ("120", "30")
    assert ("imu_ready", "24,000", "3.10 %", "48", "61.2", "1,000", "0", "0") in tables["Tasks"].rows
    assert tables["Faults"].rows == (("cable", "uart-cut", "gnss", "200", "5", "4"),)


def test_a_board_without_receiver_shows_its_errors_over_all_solutions(result):
    metrics = {
        "continuous_roll_rms_deg": 0.25,
        "continuous_roll_p95_deg": 0.5,
        "continuous_roll_max_deg": 1.0,
    }
    metrics["continuous_position_horizontal_max_m"] = 7.0
    tables = {section.title: section for section in sections(replace(result, metrics=metrics, gnss={}))}
    errors = tables["Errors against the truth"]
    assert errors.columns == ("error", "RMS", "95 %", "max")
    assert errors.rows[-1] == ("roll, °", "0.250", "0.500", "1")
    assert errors.rows[0] == ("horizontal position, m", "–", "–", "7")
    assert "no epochs of a receiver" in errors.note


def test_verdicts_and_limits_in_words(result):
    assert verdict(replace(result, expectations=())) == "no expectations set"
    met = tuple(one for one in result.expectations if one.ok)
    assert verdict(replace(result, expectations=met)) == "all 3 expectations met"
    assert limit_text(result.expectations[1]) == "≤ 0.1"
    assert limit_text(result.expectations[0]).endswith("(gnss.position_horizontal_rms_m)")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"), (float("nan"), "–"), (0.0, "0"), (0.03123, "0.0312"), (1.934, "1.93"), (12.36, "12.4"),
        (123.4, "123"), (1240.2, "1,240"), (-0.5, "-0.500"), (3.2e-6, "3.20e-06"), (5.0, "5"),
    ],
)  # fmt: skip
def test_numbers_for_people(value, text):
    assert number(value) == text


def test_percentages():
    assert percent(0.0812) == "8.12 %"
    assert percent(None) == "–"


@pytest.mark.soak
@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs the Debian package chromium")
def test_a_browser_draws_all_charts_without_network(page, tmp_path):
    (tmp_path / "report.html").write_text(page)
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--host-rules=MAP * ~NOTFOUND"]
    command += ["--virtual-time-budget=8000", "--dump-dom", f"--user-data-dir={tmp_path / 'profile'}"]
    command += [Path(tmp_path / "report.html").as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
    assert dom.count('class="main-svg"') >= 7
    for key in ("track", "position", "velocity", "attitude", "innovations", "biases", "timeline-mcu"):
        assert re.search(
            rf'id="{key}"[^>]*class="[^"]*js-plotly-plot|class="[^"]*js-plotly-plot[^>]*id="{key}"', dom
        )
