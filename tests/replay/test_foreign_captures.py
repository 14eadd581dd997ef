"""Captures that somebody else wrote: one message and exit code 2, or the tools do what they can."""

import json
from io import BytesIO

import pytest
from mcap.writer import Writer
from typer.testing import CliRunner

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
