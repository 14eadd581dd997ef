"""Captures of short runs, and captures that were tampered with."""

from __future__ import annotations

import functools
import json
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from mcap.writer import Writer

from host.capture.blocks import CAN_HEAD, SENT_CAN_HEAD, SENT_HEAD, UART_HEAD, spans
from host.capture.reader import CaptureReader, RawMessage
from host.record.result import RunRequest, RunResult
from host.run.runner import run

FAULTS = """fault=[
    {kind="chip-reset",target="U2",at_s=40},
    {kind="uart-cut",target="gnss",at_s=45,duration_s=3.3},
    {kind="uart-garbage",target="gnss",at_s=52.13,parameters={length=300}},
    {kind="uart-bit-errors",target="gnss",at_s=55,duration_s=4,parameters={probability=0.003}},
    {kind="uart-wrong-baud",target="gnss",at_s=60,duration_s=3},
    {kind="uart-framing-errors",target="gnss",at_s=63,duration_s=3,parameters={probability=0.1}},
    {kind="uart-parity",target="gnss",at_s=66.2,duration_s=2},
    {kind="uart-overrun",target="gnss",at_s=68.5,duration_s=2,parameters={probability=0.05}},
    {kind="can-disturbance",target="can1",at_s=64,duration_s=1.5},
    {kind="log-removed",target="sdcard",at_s=66,duration_s=5},
    {kind="spi-bit-errors",target="imu",at_s=70,duration_s=5},
    {kind="nav-nan",target="mcu",at_s=75},
    {kind="cpu-reset",target="mcu",at_s=80},
    {kind="chip-reset",target="U3",at_s=86},
    {kind="chip-off",target="U2",at_s=92,duration_s=2},
    {kind="spi-missing",target="imu",at_s=97,duration_s=2}
]""".replace("\n", "")

_folder = tempfile.TemporaryDirectory(prefix="navtwin-replay-")


@functools.cache
def captured(profile: str, *overrides: str, seed: int = 1) -> tuple[Path, RunResult]:
    """A run of the open road with its capture, made once a process."""
    out = Path(_folder.name) / str(abs(hash((profile, overrides, seed))))
    result = run(RunRequest("car_mems", "town-open", profile, seed, overrides, out_dir=out))
    return out / "run.mcap", result


def tampered(
    source: Path,
    target: Path,
    change: Callable[[RawMessage, int, int, bytes], bytes],
    form: str | None = None,
    schema_names: Mapping[str, str] | None = None,
) -> Path:
    """A copy in which `change(message, number, time, record)` decides on each raw record (b"" drops it).

    `schema_names`: other names for schemas.
    """
    renamed = schema_names or {}
    reader = CaptureReader(source)
    numbers: dict[str, int] = {}
    with target.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="navtwin", library="navtwin")
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for message in reader.messages():
            if not schemas:
                writer.add_attachment(
                    0, 0, "manifest.json", "application/json", json.dumps(reader.manifest).encode()
                )
                writer.add_metadata("capture", {"format": form or reader.format})
                for topic, encoding, schema in reader.declared:
                    if schema.name not in schemas:
                        schemas[schema.name] = writer.register_schema(
                            renamed.get(schema.name, schema.name), schema.encoding, schema.data
                        )
                    channels[topic] = writer.register_channel(topic, encoding, schemas[schema.name])
            data = message.data
            if message.is_raw:
                kept = []
                for _record, begin, end in spans(message.schema.name, message.topic, data):
                    number = numbers[message.topic] = numbers.get(message.topic, -1) + 1
                    kept.append(change(message, number, message.time_ns, data[begin:end]))
                data = b"".join(kept)
            writer.add_message(channels[message.topic], message.time_ns, data, message.time_ns)
        assert reader.summary is not None
        writer.add_metadata("end", reader.summary)
        writer.finish()
    return target


def in_older_format(source: Path, target: Path, number: int) -> Path:
    """The same capture as format 3 wrote it, which did not know at what rate UARTs send, or as format 2 did,
    which did not know who sent CAN frames either."""

    def change(message: RawMessage, _number: int, _time_ns: int, record: bytes) -> bytes:
        if message.schema.name == "navtwin.SentBlock":
            end_ns, _baud, n = SENT_HEAD.unpack_from(record)
            return UART_HEAD.pack(end_ns, n) + record[SENT_HEAD.size :]
        if message.schema.name == "navtwin.CanFrameBlock" and number == 2:
            end_ns, identifier, n, _s = SENT_CAN_HEAD.unpack_from(record)
            data = record[SENT_CAN_HEAD.size :][:n]
            return CAN_HEAD.pack(end_ns, identifier, n) + data
        return record

    names = {"navtwin.SentBlock": "navtwin.UartBlock"}
    if number == 2:
        names["navtwin.CanFrameBlock"] = "navtwin.CanBlock"
    return tampered(source, target, change, f"navtwin-capture-{number}", names)
