"""Captures that somebody else wrote: one message and exit code 2, or the tools do what they can."""

import json
from io import BytesIO

import pytest
from mcap.writer import Writer
from replay_captures import captured
from typer.testing import CliRunner

from host.capture.reader import CaptureReader
from host.cli.main import app

RUN = {
    "format": "navtwin-run-1",
    "board": "car_mems",
    "board_text": "",
    "scenario": "x",
    "scenario_text": "",
    "profile": "thesis",
    "seed": 1,
    "overrides": [],
}
CLOCK = ("/clock", "navtwin.Clock", b'{"reset_ns":0,"processor":"mcu","rate_ppb":0,"t_s":0}')


def foreign(manifest, *messages):
    """A whole MCAP file with these messages: (topic, schema, data)."""
    stream = BytesIO()
    writer = Writer(stream)
    writer.start()
    text = manifest if isinstance(manifest, bytes) else json.dumps(manifest).encode()
    writer.add_attachment(0, 0, "manifest.json", "application/json", text)
    for topic, schema, data in messages:
        number = writer.register_schema(schema, "jsonschema", b"{}")
        writer.add_message(writer.register_channel(topic, "json", number), 5, data, 5)
    writer.finish()
    return stream.getvalue()


DAMAGED = {
    "manifest": foreign(b"{"),
    "manifest is a list": foreign([1]),
    "mark": foreign(RUN, ("/recorded", "navtwin.Mark", b"abc")),
    "block": foreign(RUN, ("/spi/a.b", "navtwin.SpiBlock", b"abc")),
    "topic": foreign(RUN, ("/spi", "navtwin.SpiBlock", bytes(16))),
    "row is a list": foreign(RUN, ("/event", "navtwin.Event", b"[1]")),
    "row is no JSON": foreign(RUN, ("/solution", "navtwin.Solution", b"\xff")),
}


def ends_with(code, *arguments):
    outcome = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert outcome.exit_code in (code if isinstance(code, tuple) else (code,)), outcome.output
    assert "Traceback" not in outcome.output
    return outcome.output


@pytest.mark.parametrize("what", DAMAGED)
def test_what_is_damaged_is_told_by_every_tool(what, tmp_path):
    path = tmp_path / "x.mcap"
    path.write_bytes(DAMAGED[what])
    ends_with(2, "capture", "export", path, "-f", "csv", "-o", tmp_path / "csv")
    ends_with(2, "replay", path, "-q")
    ends_with(2, "replay", path, "--mode", "physical", "-q")
    ends_with(2, "attach", "board", "--port", path, "-q")
    for command in (("info",), ("check",), ("cut", "--to", 5, "-o", tmp_path / "cut.mcap")):
        ends_with((0, 1, 2), "capture", *command, path)
    assert sorted(one.name for one in tmp_path.iterdir() if one.name.endswith(".part")) == []


@pytest.mark.parametrize(
    ("key", "wrong"), [*((key, "missing") for key in sorted(RUN)), ("overrides", {"a": 1}), ("seed", None)]
)
def test_a_manifest_that_lacks_something_is_told(key, wrong, tmp_path):
    manifest = {name: value for name, value in RUN.items() if name != key}
    if wrong != "missing":
        manifest[key] = wrong
    path = tmp_path / "x.mcap"
    path.write_bytes(foreign(manifest, CLOCK, ("/recorded", "navtwin.Mark", bytes(8))))
    for command in (("replay", path), ("replay", path, "--mode", "physical")):
        assert ends_with(2, *command, "-q").startswith("navtwin: ")
    ends_with(2, "attach", "board", "--port", path, "-q")
    checked = ends_with(1, "capture", "check", path)
    assert "did not reach its end" in checked


def rewritten(path, target, change=None, **told):
    """A run's capture with other texts: `change(topic, data)` of messages; `manifest`, `end`, `capture`."""
    reader = CaptureReader(path)
    messages = list(reader.messages())
    with target.open("wb") as file:
        writer = Writer(file)
        writer.start()
        text = json.dumps({**reader.manifest, **told.get("manifest", {})}).encode()
        writer.add_attachment(0, 0, "manifest.json", "application/json", text)
        writer.add_metadata("capture", told.get("capture", {"format": reader.format}))
        channels = {}
        for topic, encoding, schema in reader.declared:
            number = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[topic] = writer.register_channel(topic, encoding, number)
        for message in messages:
            data = message.data if change is None else change(message.topic, message.data)
            writer.add_message(channels[message.topic], message.time_ns, data, message.time_ns)
        writer.add_metadata("end", {**(reader.summary or {}), **told.get("end", {})})
        writer.finish()
    return target


@pytest.fixture(scope="module")
def whole():
    """Of a short run that navigates."""
    return captured("thesis", "duration_s=30")[0]


@pytest.mark.parametrize("seconds", ["x", "", "nan", "inf", "1e300", "-1"])
def test_an_end_without_a_time_is_told(seconds, whole, tmp_path):
    path = rewritten(whole, tmp_path / "x.mcap", end={"duration_s": seconds})
    assert "duration_s" in ends_with(2, "capture", "check", path)
    if seconds in ("x", "inf"):
        for command in (("diff", whole, path), ("replay", path, "-q"), ("capture", "info", path)):
            assert "duration_s" in ends_with(2, *command)
        assert "duration_s" in ends_with(2, "replay", path, "--mode", "physical", "-q")


@pytest.mark.parametrize("cut", [3, {}, {"from_s": "1", "to_s": 2}, {"from_s": 1e300, "to_s": 1e301}])
def test_a_cut_without_times_is_told(cut, whole, tmp_path):
    path = rewritten(whole, tmp_path / "x.mcap", manifest={"cut": cut})
    assert "'cut' is" in ends_with(2, "capture", "info", path)
    assert "'cut' is" in ends_with(2, "replay", path, "-q")


def test_what_info_only_shows_may_be_anything(whole, tmp_path):
    odd = {"versions": 1.5, "overrides": {"a": 1}, "board": None}
    ends_with(0, "capture", "info", rewritten(whole, tmp_path / "a.mcap", manifest=odd))
    imported = {"format": "navtwin-import-1", "files": [{"name": 1}, 2], "clock": []}
    ends_with(0, "capture", "info", rewritten(whole, tmp_path / "b.mcap", manifest=imported))
    ends_with(0, "capture", "info", rewritten(whole, tmp_path / "c.mcap", capture={}))


@pytest.mark.parametrize(
    ("column", "wrong"),
    [
        ("t_s", None),
        ("t_s", "missing"),
        ("mode", "missing"),
        ("mode", True),
        ("yaw_deg", []),
        ("yaw_deg", 1e300),
    ],
)
def test_rows_without_a_number_that_is_needed_are_told(column, wrong, whole, tmp_path):
    def change(topic, data):
        if topic != "/solution":
            return data
        row = json.loads(data)
        del row[column]
        return json.dumps(row if wrong == "missing" else {**row, column: wrong}).encode()

    path = rewritten(whole, tmp_path / "x.mcap", change)
    for command in (("replay", path, "--mode", "physical", "-q"), ("diff", path, whole)):
        told = ends_with(2, *command)
        assert column in told
        assert "a row of /solution" in told


def test_a_solution_table_of_another_program_is_told(whole, tmp_path):
    (tmp_path / "manifest.json").write_text("{}")
    for text in ("t_s,mode\n1.0,2\n", "t_s\n1.0,2,3\n", "t_s,latitude_deg\n1.0,north\n"):
        (tmp_path / "solution.csv").write_text(text)
        assert "solution.csv" in ends_with(2, "diff", tmp_path, whole)


@pytest.mark.parametrize("topic", ["/spi/spi1.imu", "/uart/gnss/rx", "/pin/GNSS_TIMEPULSE"])
def test_a_block_that_ends_inside_a_record_is_told_by_a_replay(topic, whole, tmp_path):
    path = rewritten(whole, tmp_path / "x.mcap", lambda name, data: data[:-3] if name == topic else data)
    assert topic in ends_with(2, "replay", path, "-q")


def test_rows_with_other_columns_than_the_first_are_exported(whole, tmp_path):
    count = iter(range(1_000_000))
    path = rewritten(
        whole,
        tmp_path / "x.mcap",
        lambda topic, data: b'{"t_s":1}' if topic == "/bias" and next(count) == 0 else data,
    )
    ends_with(0, "capture", "export", path, "-f", "csv", "-o", tmp_path / "csv")
    lines = (tmp_path / "csv" / "bias.csv").read_text().splitlines()
    assert len({line.count(",") for line in lines}) == 1
    assert "gyro_x_dps" in lines[0]


def test_topics_without_a_schema_are_no_stumbling_block(tmp_path):
    stream = BytesIO()
    writer = Writer(stream)
    writer.start()
    writer.add_message(writer.register_channel("/chatter", "json", 0), 5, b"{}", 5)
    writer.finish()
    path = tmp_path / "ros.mcap"
    path.write_bytes(stream.getvalue())
    for command in (("capture", "info", path), ("capture", "check", path), ("replay", path, "-q")):
        assert "not a capture of navtwin" in ends_with(2, *command)


def test_a_cut_of_a_cut_begins_where_both_do(whole, tmp_path):
    inner, outer = tmp_path / "inner.mcap", tmp_path / "outer.mcap"
    ends_with(0, "capture", "cut", whole, "--from", 10, "--to", 20, "-o", inner)
    ends_with(0, "capture", "cut", inner, "--from", 0, "--to", 25, "-o", outer)
    assert "begins at 10 s" in ends_with(2, "replay", outer, "-q")
