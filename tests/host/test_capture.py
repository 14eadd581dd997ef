"""Captures: what goes in comes out, also of a cut-off file; other tools' readers open them; bytes repeat."""

import contextlib
import json
import os
import signal
import struct
import subprocess
import sys
import textwrap
from pathlib import Path

import mcap.reader
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.can import CanFrame
from hal.emulated.i2c import I2cTransfer
from hal.errors import ErrorKind
from host.capture.blocks import (
    SCHEMAS,
    CanMessage,
    I2cTransaction,
    SpiTransaction,
    UartChunk,
    can_records,
    i2c_record,
    unpack,
)
from host.capture.can_senders import with_senders
from host.capture.reader import CaptureReader, Decoded
from host.capture.writer import CaptureWriter
from host.record.errors import UserError
from host.record.tables import GNSS, SOLUTION

SECOND = 1_000_000_000


def write(path, seconds=5, close=True):
    """A few seconds of 100 Hz SPI, 1 Hz UART, 10 Hz CAN and solutions. Returns what was recorded."""
    capture = CaptureWriter(path, {"board": "car_mems", "seed": 3})
    spi, uart, can = (
        capture.spi_recorder("spi1"),
        capture.uart_recorder("gnss", "rx"),
        capture.can_recorder("can1"),
    )
    recorded = []
    buffer = bytearray(16)
    for tick in range(seconds * 100):
        now = tick * SECOND // 100 + 5_000_000
        buffer[:2] = struct.pack("<H", tick)
        spi(now, now + 24_381, buffer, bytes(reversed(buffer)))
        recorded.append(SpiTransaction("spi1", now, now + 24_381, bytes(buffer), bytes(reversed(buffer))))
        if tick % 10 == 0:
            end = now + 300_000
            heard = [(CanFrame(0x18FF0000 + tick, b"\x01\x02\x03", True), end, "mcu")]
            can(can_records(heard), heard)
            recorded.append(CanMessage("can1", end, 0x18FF0000 + tick, True, b"\x01\x02\x03", "mcu"))
            capture.rows("/solution", np.full((1, len(SOLUTION.columns)), now / 1e9))
            recorded.append(("/solution", now))
        if tick % 80 == 79:
            capture.flush(now + 9_000_000)
        if tick % 100 == 50:
            uart(now + 1, b"$GNRMC,*\r\n")
            recorded.append(UartChunk("gnss", "rx", now + 1, b"$GNRMC,*\r\n"))
    capture.event(SECOND, "filter", "first fix")
    if close:
        capture.close({"state_hash": "abc"})
    else:
        capture.abandon()
    return recorded


def of_kind(records, kind):
    return [record for record in records if isinstance(record, kind)]


def test_what_is_recorded_is_read_back(tmp_path):
    recorded = write(tmp_path / "run.mcap")
    reader = CaptureReader(tmp_path / "run.mcap")
    read = list(reader)
    for kind in (SpiTransaction, UartChunk, CanMessage):
        assert of_kind(read, kind) == of_kind(recorded, kind)
    solutions = [record for record in read if isinstance(record, Decoded) and record.topic == "/solution"]
    assert [("/solution", record.time_ns) for record in solutions] == of_kind(recorded, tuple)
    assert set(solutions[0].value) == set(SOLUTION.columns)
    assert [r.value["text"] for r in read if isinstance(r, Decoded) and r.topic == "/event"] == ["first fix"]
    assert reader.manifest == {"board": "car_mems", "seed": 3}
    assert reader.complete
    assert reader.summary == {"state_hash": "abc"}
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap"]


def test_the_ordinary_indexed_reader_opens_it_with_valid_json_schemas(tmp_path):
    write(tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = mcap.reader.make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert {c.topic for c in summary.channels.values()} == {
            *("/spi/spi1", "/uart/gnss/rx", "/can/can1"),
            *(
                "/solution",
                "/gnss",
                "/innovation",
                "/bias",
                "/sensor",
                "/clock",
                "/filter",
                "/event",
                "/recorded",
                "/fix/solution",
                "/fix/gnss",
            ),
        }
        for schema in summary.schemas.values():
            if schema.encoding == "jsonschema":
                assert json.loads(schema.data)["type"] == "object"
        times = [message.log_time for _, _, message in reader.iter_messages(topics=["/solution"])]
        assert times == sorted(times)
        assert len(times) == 50
        ((_, _, event),) = reader.iter_messages(
            topics=["/event"], starting_at=SECOND // 2, ending_before=2 * SECOND
        )
        assert json.loads(event.data) == {"t_s": 1.0, "source": "filter", "text": "first fix"}
        assert reader.get_header().library == "navtwin"


def test_the_same_run_gives_the_same_bytes(tmp_path):
    write(tmp_path / "a.mcap")
    write(tmp_path / "b.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


@pytest.mark.parametrize("share", [0.3, 0.5, 0.62, 0.9, 0.999])
def test_a_file_cut_anywhere_gives_a_prefix(tmp_path, share):
    recorded = write(tmp_path / "run.mcap")
    whole = (tmp_path / "run.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: int(len(whole) * share)])
    reader = CaptureReader(tmp_path / "cut.mcap")
    read = of_kind(reader, SpiTransaction)
    assert not reader.complete
    assert read == of_kind(recorded, SpiTransaction)[: len(read)]
    if share > 0.5:
        assert len(read) > 100


def test_a_flipped_bit_never_gives_wrong_traffic(tmp_path):
    recorded = of_kind(write(tmp_path / "run.mcap"), SpiTransaction)
    whole = (tmp_path / "run.mcap").read_bytes()
    cut_short = 0
    for place in range(20, len(whole), len(whole) // 40):
        damaged = bytearray(whole)
        damaged[place] ^= 0x10
        (tmp_path / "run.mcap").write_bytes(damaged)
        reader, read = CaptureReader(tmp_path / "run.mcap"), []
        with contextlib.suppress(UserError):
            read.extend(of_kind(reader, SpiTransaction))
        assert read == recorded[: len(read)]
        assert len(read) == len(recorded) or not reader.complete
        cut_short += len(read) < len(recorded)
    assert cut_short > 10


KILLED = """
import os, sys
from pathlib import Path
from host.capture.writer import CaptureWriter
capture = CaptureWriter(Path(sys.argv[1]), {"board": "car_mems"})
record = capture.spi_recorder("spi1")
for tick in range(100_000):
    record(tick * 10_000_000, tick * 10_000_000 + 25_000, b"abcd", b"efgh")
    if tick % 80 == 79:
        capture.flush()
    if tick == 1234:
        print("here", flush=True)
        sys.stdin.read()
"""


def test_after_kill_minus_nine_less_than_a_second_is_missing(tmp_path):
    command = [sys.executable, "-c", textwrap.dedent(KILLED), str(tmp_path / "run.mcap")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"here\n"
        os.kill(process.pid, signal.SIGKILL)
    assert not (tmp_path / "run.mcap").exists()
    reader = CaptureReader(tmp_path / "run.mcap.part")
    read = list(reader)
    assert not reader.complete
    assert 12.34 - read[-1].end_ns / 1e9 < 1.0
    assert [r.start_ns for r in read] == [tick * 10_000_000 for tick in range(len(read))]


def test_decoded_rows_alone_are_written_out_as_well(tmp_path):
    capture = CaptureWriter(tmp_path / "run.mcap", {"board": "car_mems"})
    for second in range(20):
        capture.rows("/solution", np.full((1, len(SOLUTION.columns)), float(second)))
        capture.flush()
    read = [one for one in CaptureReader(tmp_path / "run.mcap.part") if one.topic == "/solution"]
    assert [record.value["t_s"] for record in read] == list(range(20))[: len(read)]
    assert len(read) >= 19


def test_an_interrupted_run_keeps_its_provisional_name_but_is_whole(tmp_path):
    write(tmp_path / "run.mcap", close=False)
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap.part"]
    reader = CaptureReader(tmp_path / "run.mcap.part")
    assert len(of_kind(reader, SpiTransaction)) == 500
    assert reader.complete
    assert reader.summary is None


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 something else entirely", b"\x89MCAP0\r\n"])
def test_another_file_is_told_from_a_capture(tmp_path, content):
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(UserError, match=r"capture .*x\.mcap: not a capture of navtwin"):
        list(CaptureReader(tmp_path / "x.mcap"))


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(UserError, match=r"nothing\.mcap: cannot be read: No such file"):
        list(CaptureReader(tmp_path / "nothing.mcap"))


@given(st.binary(max_size=80), st.sampled_from(sorted(SCHEMAS)))
def test_a_block_of_any_bytes_is_read_or_refused(block, schema):
    topic = "/uart/a/rx" if "Uart" in schema else "/spi/a"
    records = unpack(schema, topic, block)
    read = 0
    with contextlib.suppress(ValueError):
        read = len(list(records)) + 1
    assert read != 1 or not block


def test_a_row_without_a_number_is_null(tmp_path):
    capture = CaptureWriter(tmp_path / "run.mcap", {"board": "car_mems"})
    row = np.full((1, len(GNSS.columns)), np.nan)
    row[0, :2] = 2.5, 0
    capture.rows("/gnss", row)
    capture.close()
    (record,) = CaptureReader(tmp_path / "run.mcap")
    assert record.value["t_s"] == 2.5
    assert record.value["fix"] == 0
    assert record.value["height_m"] is None


def test_the_worked_example_of_the_documentation_is_true():
    text = (Path(__file__).parents[2] / "docs" / "capture.md").read_text()
    (line,) = [line for line in text.splitlines() if line.startswith("    40 42 0F")]
    (record,) = unpack("navtwin.SpiBlock", "/spi/spi1", bytes.fromhex(line))
    assert record == SpiTransaction("spi1", 1_000_000, 1_003_000, b"\x80\x00", b"\x00\xd1")


FRAMES = st.one_of(
    st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8)),
    st.builds(CanFrame, st.integers(0, 0x1FFF_FFFF), st.binary(min_size=8, max_size=8), st.just(True)),
)
FULL_FRAMES = st.builds(
    CanFrame, st.integers(0, 0x7FF), st.binary(min_size=8, max_size=8) | st.just(bytes(8)), st.booleans()
)


NAMES = st.text(max_size=300) | st.sampled_from(["mcu", "ecu"])


@given(
    st.lists(st.tuples(FRAMES, st.integers(0, 1 << 60), NAMES))
    | st.lists(st.tuples(FULL_FRAMES, st.integers(0, 1 << 60), st.just("mcu")))
)
def test_can_records_come_back(heard):
    heard *= 60
    plain = can_records(heard)
    assert list(unpack("navtwin.CanBlock", "/can/can1", plain)) == [
        CanMessage("can1", end, frame.identifier, frame.extended, frame.data) for frame, end, _ in heard
    ]
    told = list(unpack("navtwin.CanFrameBlock", "/can/can1", with_senders(plain, heard)))
    assert told == [
        CanMessage("can1", end, frame.identifier, frame.extended, frame.data, one.sender)
        for (frame, end, _), one in zip(heard, told, strict=True)
    ]
    for (_, _, name), one in zip(heard, told, strict=True):
        assert one.sender == name or len(name.encode()) > 255


TRANSFERS = st.builds(
    I2cTransfer,
    st.integers(0, 1 << 60),
    st.integers(0, 1 << 60),
    st.integers(8, 0x77),
    st.binary(max_size=40),
    st.integers(0, 40),
    st.integers(0, 40),
    st.binary(max_size=40),
    st.sampled_from([None, ErrorKind.ADDRESS_NACK, ErrorKind.DATA_NACK, ErrorKind.TIMEOUT, ErrorKind.OTHER]),
)


@given(st.lists(TRANSFERS))
def test_i2c_records_come_back(transfers):
    block = b"".join(map(i2c_record, transfers))
    records = list(unpack("navtwin.I2cBlock", "/i2c/i2c1", block))
    assert records == [I2cTransaction("i2c1", transfer) for transfer in transfers]
