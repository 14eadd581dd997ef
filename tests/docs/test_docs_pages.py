"""The documentation holds together: links lead somewhere, commands exist, tables match the code."""

import re
import tomllib

import pytest
from pages import PAGES, ROOT, commands, text
from pydantic import BaseModel
from typer.testing import CliRunner

from host.cli.main import app
from host.run.faults import KINDS
from host.sim.errors.schema import AccelerometerErrors, GyroErrors, Temperature
from host.sim.gnss.faults import GNSS_FAULT_KINDS
from host.sim.gnss.settings import BaselineSettings, GnssSettings
from host.sim.scenario.composite_schema import CompositeModel
from host.sim.scenario.motion_schema import SegmentModel
from host.sim.scenario.schema import (
    Fault,
    Initial,
    OutageWindow,
    Place,
    RecordingSource,
    Scenario,
    Start,
    Sway,
    Trajectory,
    Vibration,
)

NAMES = [str(page.relative_to(ROOT)) for page in PAGES]
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
FORBIDDEN = re.compile(r"/work/|/tmp/|\.\./shared|\bissue \d|#\d+\b|TODO|FIXME", re.I)
HEADED = {
    "place": Place, "start": Start, "initial": Initial, "trajectory": Trajectory, "sway": Sway,
    "vibration": Vibration, "gnss": GnssSettings, "outage": OutageWindow, "fault": Fault,
    "recording": RecordingSource, "gnss.baseline": BaselineSettings,
}  # fmt: skip
COMMANDS = [words for page in NAMES for words in commands(page) if words[0] == "navtwin"]


def anchors(page_text: str) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", page_text, re.M)
    return {re.sub(r"[^\w\- ]", "", heading).strip().lower().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", NAMES)
def test_links_lead_somewhere(name):
    page = ROOT / name
    prose = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for target in LINK.findall(prose):
        if target.startswith("https://"):
            continue
        path, _, anchor = target.partition("#")
        linked = (page.parent / path).resolve() if path else page
        assert linked.is_file(), f"{name} links {target}"
        assert linked.is_relative_to(ROOT), f"{name} links {target}"
        if anchor:
            assert anchor in anchors(linked.read_text(encoding="utf-8")), f"{name} links {target}"


@pytest.mark.parametrize("name", NAMES)
def test_nothing_of_one_machine_stands_in_the_pages(name):
    assert not FORBIDDEN.findall(text(name))


def test_every_page_is_reachable_from_the_readme():
    seen, waiting = set(), ["README.md"]
    while waiting:
        name = waiting.pop()
        seen.add(name)
        page = ROOT / name
        for target in LINK.findall(text(name)):
            path = target.partition("#")[0]
            linked = (page.parent / path).resolve() if path and "://" not in path else None
            if linked is not None and linked.suffix == ".md":
                found = str(linked.relative_to(ROOT))
                waiting += [found] if found not in seen else []
    assert set(NAMES) <= seen


def test_the_picture_is_a_small_png():
    content = (ROOT / "docs/images/report.png").read_bytes()
    assert content.startswith(b"\x89PNG")
    assert len(content) < 400_000


# -- commands --------------------------------------------------------------------------------------


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_options_of_commands_exist(words):
    import typer

    command = typer.main.get_command(app).commands[words[1]]
    rest = list(words[2:])
    while hasattr(command, "commands") and rest and not rest[0].startswith("-"):
        command = command.commands[rest.pop(0)]
    known = {option for parameter in command.params for option in parameter.opts}
    for word in rest:
        if word.startswith("-") and len(word) > 1:
            assert word in known, f"navtwin {command.name} has no {word}"


def test_make_targets_of_the_readme_exist():
    targets = re.findall(r"^([a-z]+):.*##", (ROOT / "Makefile").read_text(), re.M)
    named = set(re.findall(r"(?:`|^    )make ([a-z]+)", text("README.md"), re.M))
    assert {"run", "test", "setup", "help", "soak"} <= named <= set(targets)


def test_the_readme_names_every_scenario_and_profile():
    board = tomllib.loads(text("boards/car_mems/board.toml"))
    scenarios = [path.stem for path in (ROOT / "boards/car_mems/scenarios").glob("*.toml")]
    for name in (*scenarios, *board["profiles"]):
        assert f"`{name}`" in text("README.md")


def test_commands_of_the_readme_are_accepted(tmp_path, monkeypatch):
    """Each with its run cut to two seconds: every --set, scenario and profile in it is valid."""
    monkeypatch.chdir(tmp_path)
    short = ["--set", "duration_s=2.0", "--set", "outage=[]", "--set", "expect={}", "--no-capture"]
    runs = [words for words in commands("README.md") if words[:2] == ["navtwin", "run"]]
    chosen = [words for words in runs if "./drive.toml" not in words and "real-drive" not in words]
    assert len(chosen) >= 5
    for number, (_, *words) in enumerate(chosen):
        if any(word.startswith("fault=") for word in words):
            words = [word.replace("at_s=300.0", "at_s=1.0") for word in words]
        ended = CliRunner().invoke(app, [*words, *short, "--out", f"run{number}"])
        assert ended.exit_code == 0, f"{words}\n{ended.output}"


# -- scenarios -------------------------------------------------------------------------------------


def section(page: str, heading: str) -> str:
    """The part of a page below a heading, up to the next one."""
    found = re.search(rf"^#+ {re.escape(heading)}$(.*?)(?=^#+ |\Z)", page, re.M | re.S)
    assert found, heading
    return found[1]


def keys(part: str) -> dict[str, list[str]]:
    """Rows of the tables of a part by the keys that their first cell names in backticks."""
    rows = [line.strip("|").split("|") for line in part.splitlines() if line.startswith("| `")]
    return {key: cells for cells in rows for key in re.findall(r"`([\w.-]+)`", cells[0])}


def fields(model: type[BaseModel]) -> set[str]:
    return set(model.model_fields)


@pytest.mark.parametrize("heading", list(HEADED))
def test_every_key_of_a_table_is_told(heading):
    told = keys(section(text("docs/scenarios.md"), heading))
    described = {key for key in told if key not in KINDS and key not in GNSS_FAULT_KINDS}
    assert described == fields(HEADED[heading])


@pytest.mark.parametrize("heading", list(HEADED))
def test_defaults_are_told_rightly(heading):
    told = keys(section(text("docs/scenarios.md"), heading))
    for key, field in HEADED[heading].model_fields.items():
        cell = told[key][-3].strip()
        if field.is_required():
            assert cell == "needed", key
        elif isinstance(field.default, bool):
            assert cell == str(field.default).lower(), key
        elif isinstance(field.default, int | float):
            assert float(cell) == field.default, key
        elif isinstance(field.default, str):
            assert cell.strip('`"') == field.default, key


def test_every_error_of_a_sensor_is_told():
    part = section(text("docs/scenarios.md"), "imu")
    gyro, accelerometer, temperature = part.split("| key of `imu.")[1:]
    for told, model in ((gyro, GyroErrors), (accelerometer, AccelerometerErrors), (temperature, Temperature)):
        assert set(keys(told)) == fields(model)


def test_every_key_at_the_top_is_told():
    told = set(keys(section(text("docs/scenarios.md"), "Top level")))
    assert told == fields(Scenario) - {"name", "path"}


def test_every_kind_of_segment_and_its_keys_are_told():
    told = keys(section(text("docs/scenarios.md"), "Motion"))
    common = {"kind", "duration_s", "pitch_to_deg", "roll_to_deg", "pitch_rate_dps", "roll_rate_dps"}
    for model in SegmentModel.__args__:
        for kind in model.model_fields["kind"].annotation.__args__:
            further = set(re.findall(r"`([a-z0-9_]+)`", told[kind][1]))
            assert further == fields(model) - common, kind
    assert common <= set(told)
    for composite in CompositeModel.__args__:
        (kind,) = composite.model_fields["kind"].annotation.__args__
        assert set(re.findall(r"`([a-z0-9_]+)`", told[kind][1])) == fields(composite) - {"kind"}, kind


def test_every_fault_is_told():
    told = set(keys(section(text("docs/scenarios.md"), "fault")))
    assert told == fields(Fault) | set(KINDS) | set(GNSS_FAULT_KINDS)


def test_the_scenario_of_the_page_is_valid(tmp_path):
    from host.sim.scenario.load import load_scenario

    example = re.search(r"^```toml\n(.*?)^```$", text("docs/scenarios.md"), re.M | re.S)[1]
    (tmp_path / "square.toml").write_text(example)
    scenario = load_scenario(tmp_path / "square.toml")
    assert len(scenario.segment) == 9
    assert set(scenario.expect) == {"metrics.yaw_rms_deg"}


# -- results and assumptions -----------------------------------------------------------------------


def test_every_key_of_the_result_is_told():
    from dataclasses import fields as parts

    from host.record.result import BusUse, CpuUse, Event, Expectation, FaultUse, Outage, RunResult, TaskUse

    page = text("docs/results.md")
    result = RunResult("b", "s", "p", 1, 1.0, 1.0, "", {}, {})
    listed = {"outages": Outage, "cpu": CpuUse, "cpu[].tasks": TaskUse, "buses": BusUse,
              "faults": FaultUse, "expectations": Expectation, "events": Event}  # fmt: skip
    rows = {
        line.split("|")[1]: line for line in section(page, "Keys of the JSON").splitlines() if "|" in line
    }
    for key in result.to_dict():
        assert any(f"`{key}`" in cell or f"`{key}[]`" in cell for cell in rows), key
    for key, kind in listed.items():
        for part in parts(kind):
            assert f"`{part.name}" in rows[f" `{key}[]` "], f"{key}: {part.name}"


def test_every_metric_is_told():
    from host.score.scorer import Scorer

    page = text("docs/results.md")
    score = Scorer().result(0.0)
    for name in (*score.metrics, *score.gnss):
        stem = re.sub(r"_(rms|max|p95)_(mps|deg|m)$", "", name.removeprefix("continuous_"))
        assert stem in page, name


def test_exit_codes_are_told():
    from host.cli import exit_codes

    told = {
        int(key) for key in re.findall(r"^\| (\d+) \|", section(text("docs/results.md"), "Exit codes"), re.M)
    }
    assert told == {value for name, value in vars(exit_codes).items() if name.startswith("EXIT_")}


def test_the_cost_table_is_the_board_s():
    board = tomllib.loads(text("boards/car_mems/board.toml"))
    told = re.findall(r"^\| `(\w+)` \| ([\d,]+) \| ([\d.]+) µs", text("docs/FIDELITY.md"), re.M)
    costs = {name: int(cycles.replace(",", "")) for name, cycles, _ in told}
    assert costs == board["processors"]["mcu"]["costs"]
    for name, _, microseconds in told:
        assert float(microseconds) == pytest.approx(costs[name] / 168.0, abs=0.06)


def test_every_dependency_has_its_reason():
    project = tomllib.loads(text("pyproject.toml"))["project"]
    page = text("docs/dependencies.md").lower()
    for wanted in (*project["dependencies"], *project["optional-dependencies"]["dev"]):
        name = re.match(r"[\w-]+", wanted)[0].lower()
        assert re.search(rf"^\|[^|]*\b{re.escape(name)}\b", page, re.M), name
