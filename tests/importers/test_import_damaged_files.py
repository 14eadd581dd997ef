"""Cut, changed, senseless files of every kind: an import or one message, never a traceback or half a file."""

from __future__ import annotations

import functools
import json
import tempfile
from pathlib import Path

import mcap.reader
import numpy as np
from circle_drive import write_kf_gins
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from test_import_arrays import broad
from test_import_can_logs import DATABASE, frames, written
from test_import_receiver_logs import esf, nmea_log, pvt, raw_bytes
from test_import_tables import IMU_MAP, write_csv
from typer.testing import CliRunner

from host.cli.main import app

_folder = tempfile.TemporaryDirectory(prefix="navtwin-import-")
HERE = Path(_folder.name)


@functools.cache
def source(kind):
    """(good file, further arguments) of one kind."""
    folder = HERE / kind
    folder.mkdir()
    if kind == "ubx":
        data = b"".join(
            pvt(k) + esf(1000 * k, [(14, 5), (13, 6), (5, 7), (16, 1), (17, 2), (18, -9)]) for k in range(12)
        )
        (folder / "x.ubx").write_bytes(data + nmea_log([100.0 + k for k in range(5)]))
        return folder / "x.ubx", ()
    if kind == "nmea":
        (folder / "x.nmea").write_bytes(nmea_log([86_390.0 + k for k in range(20)]))
        return folder / "x.nmea", ()
    if kind in ("log", "asc", "blf", "csv-can"):
        (folder / "x.dbc").write_text(DATABASE)
        sent = frames(30)
        for one in sent:
            one.channel = 0
        file = written(folder / f"x.{kind.removesuffix('-can')}", sent)
        return file, ("--dbc", folder / "x.dbc")
    if kind == "kf-gins":
        return write_kf_gins(folder, 3.0)[0], ("--week", 2300)
    if kind == "csv":
        imu, _ = write_csv(folder, 2.0, IMU_MAP)
        return imu, ("--map", folder / "map.toml")
    arrays = {key: value[:200] if np.ndim(value) else value for key, value in broad().items()}
    np.savez(folder / "x.npz", **arrays)
    return folder / "x.npz", ()


KINDS = ("ubx", "nmea", "log", "asc", "blf", "csv-can", "kf-gins", "csv", "broad")
CHANGES = st.lists(
    st.tuples(
        st.sampled_from(["set", "insert", "delete", "repeat"]),
        st.floats(0, 1),
        st.binary(min_size=1, max_size=12),
    ),
    max_size=6,
)


def changed(data, changes, keep):
    data = bytearray(data)
    for what, where, piece in changes:
        place = round(where * len(data))
        if what == "set":
            data[place : place + len(piece)] = piece
        elif what == "insert":
            data[place:place] = piece
        elif what == "delete":
            del data[place : place + 8 * len(piece)]
        else:
            data[place:place] = data[place : place + 20 * len(piece)]
    return bytes(data[: round(keep * len(data))])


@settings(max_examples=30, suppress_health_check=[HealthCheck.too_slow], deadline=None)
@example("log", [("repeat", 0.01171875, b"\x00")], 1.0)
@given(st.sampled_from(KINDS), CHANGES, st.sampled_from([1.0, 1.0, 0.99, 0.5, 0.03, 0.0]))
def test_damaged_files_are_imported_or_refused_in_one_line(kind, changes, keep):
    good, options = source(kind)
    command = "can" if kind in ("log", "asc", "blf", "csv-can") else kind
    with tempfile.TemporaryDirectory(prefix="navtwin-damaged-") as name:
        folder = Path(name)
        (folder / good.name).write_bytes(changed(good.read_bytes(), changes, keep))
        arguments = ["import", command, folder / good.name, "-o", folder / "x.mcap", "--json", "-", *options]
        outcome = CliRunner().invoke(app, [str(one) for one in arguments])
        assert outcome.exit_code in (0, 2), outcome.output
        assert "Traceback" not in outcome.output
        left = {path.name for path in folder.iterdir()}
        if outcome.exit_code == 2:
            assert outcome.stderr.startswith("navtwin: ")
            assert left == {good.name}
            return
        assert left == {good.name, "x.mcap"}
        report = json.loads(outcome.stdout)
        with (folder / "x.mcap").open("rb") as file:
            reader = mcap.reader.make_reader(file, validate_crcs=True)
            times: dict[str, int] = {}
            for _, channel, message in reader.iter_messages(log_time_order=False):
                if channel.topic in ("/gnss", "/imu/imu"):
                    assert message.log_time > times.get(channel.topic, -1)
                    times[channel.topic] = message.log_time
                if channel.message_encoding == "json":
                    json.loads(message.data)
        assert report["duration_s"] >= 0.0
        if kind in ("ubx", "nmea"):
            assert raw_bytes(folder / "x.mcap") == (folder / good.name).read_bytes()
        check = CliRunner().invoke(app, ["capture", "check", str(folder / "x.mcap")])
        assert check.exit_code in (0, 1), check.output


def test_the_good_files_are_good():
    for kind in KINDS:
        good, options = source(kind)
        command = "can" if kind in ("log", "asc", "blf", "csv-can") else kind
        target = HERE / f"{kind}.mcap"
        outcome = CliRunner().invoke(
            app, ["import", command, str(good), "-o", str(target), *map(str, options)]
        )
        assert outcome.exit_code == 0, outcome.output
