"""Topics with JSON messages, which Foxglove and PlotJuggler open as they are, and their JSON schemas."""

from __future__ import annotations

import json
from collections.abc import Mapping

from host.record.tables import BIAS, FILTER, GNSS, INNOVATION, SENSOR, SOLUTION, Table

TABLES: dict[str, tuple[str, Table]] = {
    "/solution": ("navtwin.Solution", SOLUTION),
    "/gnss": ("navtwin.Gnss", GNSS),
    "/innovation": ("navtwin.Innovation", INNOVATION),
    "/bias": ("navtwin.Bias", BIAS),
    "/sensor": ("navtwin.Sensor", SENSOR),
    "/filter": ("navtwin.Filter", FILTER),
}
IMPORT_FORMAT = "navtwin-import-1"
"""Of the manifest of a capture that was imported: no run stands behind it."""
IMU_SCHEMA = "navtwin.Imu"
EVENTS = ("/event", "navtwin.Event")
CONTROL = ("/control", "navtwin.Control")
"""What was done to the board from outside while it was served, with what belongs to each command."""

CLOCK = ("/clock", "navtwin.Clock")
"""When a processor's clock began to count: at power-on and after each reset."""

NUMBER = {"type": ["number", "null"]}


def table_schema(name: str, table: Table) -> bytes:
    """JSON schema of a table's rows: every column a number, or null where there is none."""
    return _schema(name, dict.fromkeys(table.columns, NUMBER))


def event_schema() -> bytes:
    """JSON schema of an event."""
    fields = {"t_s": {"type": "number"}, "source": {"type": "string"}, "text": {"type": "string"}}
    return _schema(EVENTS[1], fields)


def control_schema() -> bytes:
    """JSON schema of a command; each has further keys of its own."""
    fields = {"t_s": {"type": "number"}, "time_ns": {"type": "integer"}, "command": {"type": "string"}}
    return _schema(CONTROL[1], fields)


def clock_schema() -> bytes:
    """JSON schema of a clock's beginning."""
    fields = {
        "t_s": {"type": "number"},
        "reset_ns": {"type": "integer"},
        "processor": {"type": "string"},
        "rate_ppb": {"type": "integer"},
    }
    return _schema(CLOCK[1], fields)


def _schema(name: str, properties: Mapping[str, object]) -> bytes:
    document = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": name,
        "type": "object",
        "properties": properties,
        "required": list(properties),
    }
    return json.dumps(document, separators=(",", ":")).encode()
