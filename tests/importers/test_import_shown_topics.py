"""What Foxglove and PlotJuggler need to show a capture as it is: schemas that hold, as published."""

import json

import mcap.reader
import numpy as np
import pytest
from imports import imported
from test_import_arrays import broad
from test_import_receiver_logs import nmea_log, pvt

from host.record.result import RunRequest
from host.run.runner import run

jsonschema = pytest.importorskip("jsonschema")

LOCATION_FIX = {
    "timestamp": {"sec": 0, "nsec": 999_999_999},
    "frame_id": "board",
    "latitude": 47.0,
    "longitude": 8.5,
    "altitude": 480.0,
    "position_covariance": [0.0] * 9,
    "position_covariance_type": 2,
}
"""A message that the published schema foxglove.LocationFix takes; it demands all of these."""


def assert_same_fields(message):
    assert {key: type(value) for key, value in message.items()}.items() >= {
        "timestamp": dict, "frame_id": str, "latitude": float, "longitude": float,
        "position_covariance": list, "position_covariance_type": int,
    }.items()  # fmt: skip
    assert 0 <= message["timestamp"]["nsec"] < 1_000_000_000
    assert len(message["position_covariance"]) == 9
    assert message["position_covariance_type"] in (0, 1, 2, 3)


def messages(path):
    with path.open("rb") as file:
        for schema, channel, message in mcap.reader.make_reader(file, validate_crcs=True).iter_messages():
            if channel.message_encoding == "json":
                assert schema.encoding == "jsonschema"
                yield channel.topic, json.loads(schema.data), json.loads(message.data)


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shown")
    run(RunRequest("car_mems", "town-open", overrides=("duration_s=90",), out_dir=folder / "run"))
    (folder / "x.nmea").write_bytes(nmea_log([86_390.0 + k for k in range(20)]))
    (folder / "x.ubx").write_bytes(b"".join(pvt(k) for k in range(9)))
    np.savez(folder / "x.npz", **broad())
    made = [imported(folder, kind, folder / f"x.{end}", name=f"{kind}.mcap")[1] for kind, end in
            (("nmea", "nmea"), ("ubx", "ubx"), ("broad", "npz"))]  # fmt: skip
    return [folder / "run" / "run.mcap", *made]


def test_every_message_is_as_its_schema_says(captures):
    for capture in captures:
        checkers = {}
        count = 0
        for topic, schema, message in messages(capture):
            if topic not in checkers:
                jsonschema.Draft202012Validator.check_schema(schema)
                checkers[topic] = jsonschema.Draft202012Validator(schema)
            checkers[topic].validate(message)
            assert set(message) == set(schema["properties"])
            count += 1
        assert count > 9


def test_positions_are_what_the_well_known_schema_demands(captures):
    found = 0
    for capture in captures[:3]:
        for topic, schema, message in messages(capture):
            if not topic.startswith("/fix/"):
                continue
            found += 1
            assert_same_fields(message)
            if found % 50 != 1:
                continue
            assert schema["title"] == "foxglove.LocationFix"
            assert set(schema["required"]) == set(LOCATION_FIX)
            jsonschema.validate(LOCATION_FIX, schema)
            for key in LOCATION_FIX:
                with pytest.raises(jsonschema.ValidationError):
                    jsonschema.validate({k: v for k, v in LOCATION_FIX.items() if k != key}, schema)
    assert found > 50
