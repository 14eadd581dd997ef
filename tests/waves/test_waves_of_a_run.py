"""Line levels of a real run: what the firmware did, read back from the file, and what is refused."""

import json
import shutil
import subprocess

import pytest
from vcd_decoders import decode_can, decode_spi, decode_uart, read_vcd
from wave_captures import PORT, bus_table, capture, finish, processor, waves

from hal.emulated.i2c import EmulatedI2cBus
from host.capture.blocks import CanMessage, SpiTransaction, UartChunk
from host.capture.reader import CaptureReader
from host.record.result import RunRequest
from host.run.runner import run

DURATION_S = 3
sigrok = pytest.mark.skipif(shutil.which("sigrok-cli") is None, reason="sigrok-cli is not installed")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    out = tmp_path_factory.mktemp("waves") / "run"
    run(RunRequest("car_mems", "static", "full-rate", 1, (f"duration_s={DURATION_S}",), out_dir=out))
    records = list(CaptureReader(out / "run.mcap"))
    return out, records


@pytest.fixture(scope="module")
def whole(recorded, tmp_path_factory):
    path = tmp_path_factory.mktemp("vcd") / "all.vcd"
    outcome = waves(recorded[0], "-o", path)
    assert outcome.exit_code == 0, outcome.output
    return path, read_vcd(path)


def test_every_transaction_frame_and_byte_of_a_run_is_in_the_lines(recorded, whole):
    _, records = recorded
    _, lines = whole
    spi = [one for one in records if isinstance(one, SpiTransaction)]
    found = decode_spi(*(lines[f"spi1_{name}"] for name in ("sck", "mosi", "miso", "cs_imu")), 3)
    assert [(one.mosi, one.miso) for one in found] == [(one.mosi, one.miso) for one in spi]
    assert [one.start_ns for one in found] == [one.start_ns for one in spi]
    next_starts = [one.start_ns for one in spi[1:]] + [0]
    for one, drawn, next_start in zip(spi, found, next_starts, strict=True):
        gap = 10**9 // 5_250_000 // 4 if next_start == one.end_ns else 0  # so that the next one can be seen
        assert drawn.end_ns == one.end_ns - gap
    frames = [one for one in records if isinstance(one, CanMessage)]
    decoded = decode_can(lines["can1_bus"], 500_000)
    assert [(f.end_ns, f.identifier, f.data) for f in decoded] == [
        (f.end_ns, f.identifier, f.data) for f in frames
    ]
    sent = [one for one in records if isinstance(one, UartChunk) and one.port == "host"]
    got = decode_uart(lines["host_tx"], 230_400)
    assert bytes(value for _, value in got) == b"".join(one.data for one in sent)
    assert len(spi) > 250
    assert len(frames) > 100


def test_the_receiver_port_changes_its_rate_on_the_way(recorded, whole):
    """The firmware speaks 9600 baud until the receiver has been moved to 115200."""
    _, records = recorded
    line = whole[1]["gnss_tx"]
    chunks = [one for one in records if isinstance(one, UartChunk) and one.port == "gnss"]
    split = 1_000_000_000
    early = decode_uart([edge for edge in line if edge[0] < split], 9600)
    late = decode_uart([(0, "1"), *(edge for edge in line if edge[0] >= split)], 115_200)
    for found, some, baud in (
        (early, [c for c in chunks if c.end_ns < split], 9600),
        (late, [c for c in chunks if c.end_ns >= split], 115_200),
    ):
        starts = []
        for chunk in some:
            begin = chunk.end_ns - len(chunk.data) * 10**10 // baud
            starts += [(begin + k * 10**10 // baud, value) for k, value in enumerate(chunk.data)]
        assert found == starts
        assert starts


def test_a_window_is_the_same_stretch_of_the_whole(recorded, whole, tmp_path):
    """Also one that begins in the middle of a transaction."""
    spi = [one for one in recorded[1] if isinstance(one, SpiTransaction)]
    middle = (spi[200].start_ns + spi[200].end_ns) // 2
    outcome = waves(
        recorded[0],
        "-o",
        tmp_path / "w.vcd",
        "--from",
        middle / 1e9,
        "--to",
        2.7,
        "--json",
        tmp_path / "w.json",
    )
    assert outcome.exit_code == 0, outcome.output
    told = json.loads((tmp_path / "w.json").read_text())
    assert [bus["cut_short"] for bus in told["buses"]] == [0, 0, 0, 0]
    assert told["bytes"] == (tmp_path / "w.vcd").stat().st_size
    for name, cut in read_vcd(tmp_path / "w.vcd").items():
        before = [level for t, level in whole[1][name] if t <= middle]
        behind = [(t, level) for t, level in whole[1][name] if middle < t < 2_700_000_000]
        assert cut == [(middle, before[-1]), *behind], name


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["--bus", "spi2"],
            "the capture has no such bus; it has can1 (can), spi1 (spi), gnss (uart), host (uart)",
        ),
        (["--from", "99"], "ends at 3 s"),
        (["--from", "2", "--to", "1"], "must be 0 or more and rise"),
        (["--from", "nan"], "must be 0 or more and rise"),
        (["--to", "inf"], "must be 0 or more and rise"),
        (["--from", "-1"], "must be 0 or more and rise"),
        (["--rate", "spi1"], "must be NAME=HZ"),
        (["--rate", "spi1=fast"], "is no rate"),
        (["--rate", "spi1=" + "9" * 5000], "is no rate"),
        (["--rate", "spi1=1__0"], "at 10 Hz they take"),
        (["--from", "1e300"], "ends at 3 s"),
        (["--rate", "spi1=1000"], "Name the right clock, e.g. --rate spi1="),
    ],
)
def test_what_cannot_be_is_told_in_one_line(recorded, tmp_path, arguments, said):
    outcome = waves(recorded[0], "-o", tmp_path / "x.vcd", *arguments)
    assert outcome.exit_code == 2
    assert said in outcome.output
    assert len(outcome.output.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_figures_do_not_take_the_place_of_the_capture_or_the_lines(recorded, tmp_path):
    before = (recorded[0] / "run.mcap").read_bytes()
    for taken, said in (
        (recorded[0] / "run.mcap", "is the file that is read"),
        (tmp_path / "x.vcd", "of -o"),
    ):
        outcome = waves(recorded[0], "-o", tmp_path / "x.vcd", "--json", taken)
        assert outcome.exit_code == 2
        assert said in outcome.output
    assert (recorded[0] / "run.mcap").read_bytes() == before
    assert not list(tmp_path.iterdir())


def test_files_that_are_there_or_cannot_be(recorded, tmp_path):
    (tmp_path / "x.vcd").write_text("mine")
    assert "exists already" in waves(recorded[0], "-o", tmp_path / "x.vcd").output
    assert (tmp_path / "x.vcd").read_text() == "mine"
    assert waves(recorded[0], "-o", tmp_path / "no" / "x.vcd").exit_code == 2
    assert waves(tmp_path / "none.mcap", "-o", tmp_path / "y.vcd").exit_code == 2
    assert waves(tmp_path / "x.vcd", "-o", tmp_path / "y.vcd").exit_code == 2


def test_a_window_beyond_the_end_stops_there_and_says_so(recorded, tmp_path):
    outcome = waves(recorded[0], "-b", "can1", "--from", 2.9, "--to", 9, "-o", tmp_path / "x.vcd")
    assert outcome.exit_code == 0
    assert "--to 9: the recording ends at 3 s" in outcome.output


def test_a_recording_that_was_killed(recorded, whole, tmp_path):
    """The same lines up to the last mark that is in the file."""
    torn = tmp_path / "run.mcap.part"
    data = (recorded[0] / "run.mcap").read_bytes()
    torn.write_bytes(data[: len(data) // 2])
    outcome = waves(tmp_path / "run.mcap.part", "-o", tmp_path / "x.vcd", "--json", tmp_path / "x.json")
    assert outcome.exit_code == 0, outcome.output
    end = json.loads((tmp_path / "x.json").read_text())["recorded_s"] * 1e9
    assert end > 0.7e9
    for name, line in read_vcd(tmp_path / "x.vcd").items():
        if name.startswith("spi1"):
            assert line == [edge for edge in whole[1][name] if edge[0] < end]


def decoded(path, decoder, kinds, *options):
    command = ["sigrok-cli", "-I", *options, "-i", str(path), "-P", decoder, "-A", kinds]
    done = subprocess.run(
        [*command, "--protocol-decoder-samplenum"], capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout.splitlines()


@sigrok
def test_sigrok_reads_spi(recorded, tmp_path):
    path = tmp_path / "x.vcd"
    waves(recorded[0], "-b", "spi1", "--from", 2.5, "--to", 2.53, "-o", path)
    pins = "clk=spi1_sck:mosi=spi1_mosi:miso=spi1_miso:cs=spi1_cs_imu:cpol=1:cpha=1"
    rows = decoded(path, f"spi:{pins}", "spi=mosi-transfer:miso-transfer", "vcd")
    begin, end = 2_500_000_000, 2_530_000_000
    spi = [r for r in recorded[1] if isinstance(r, SpiTransaction) and begin <= r.start_ns < end]
    assert len(spi) >= 2
    expected = [
        f"{one.start_ns - begin}-{one.end_ns - begin} spi-1: {data.hex(' ').upper()}"
        for one in spi
        for data in (one.miso, one.mosi)
    ]
    assert rows == expected


@sigrok
def test_sigrok_reads_can(recorded, tmp_path):
    path = tmp_path / "x.vcd"
    frames = [one for one in recorded[1] if isinstance(one, CanMessage)][:5]
    begin = frames[0].end_ns - 500_000
    waves(recorded[0], "-b", "can1", "--from", begin / 1e9, "--to", begin / 1e9 + 0.003, "-o", path)
    decoder = "can:can_rx=can1_bus:nominal_bitrate=500000"
    ids = decoded(path, decoder, "can=id", "vcd")
    assert [int(row.split("(")[1].rstrip(")"), 16) for row in ids] == [one.identifier for one in frames]
    data = decoded(path, decoder, "can=data", "vcd")
    assert bytes(int(row.split("0x")[1], 16) for row in data) == b"".join(one.data for one in frames)
    ends = [int(row.split("-")[1].split()[0]) for row in decoded(path, decoder, "can=eof", "vcd")]
    assert ends == [one.end_ns - begin for one in frames]
    assert decoded(path, decoder, "can=warnings", "vcd") == []
    assert all(row.endswith("ACK") for row in decoded(path, decoder, "can=ack-slot", "vcd"))


@sigrok
def test_sigrok_reads_uart(recorded, tmp_path):
    """A message to the receiver and the beginning of its answer."""
    path = tmp_path / "x.vcd"
    waves(recorded[0], "-b", "gnss", "--from", 2.501, "--to", 2.506, "-o", path)
    decoder = "uart:rx=gnss_rx:tx=gnss_tx:baudrate=115200"
    rows = decoded(path, decoder, "uart=tx-data:rx-data:tx-warnings:rx-warnings", "vcd:downsample=100")
    chunks = [r for r in recorded[1] if isinstance(r, UartChunk) and r.port == "gnss"]
    sent = b"".join(one.data for one in chunks if 2.501e9 < one.end_ns < 2.506e9)
    values = bytes(int(row.split()[-1], 16) for row in rows)
    assert sent
    assert values[: len(sent)] == sent
    assert values[len(sent) :].startswith(b"\xb5\x62\x05\x01")


class Thermometer:
    def write(self, data, time_ns):
        return len(data)

    def read(self, length, time_ns):
        return bytes(range(0xA0, 0xA0 + length))


@sigrok
def test_sigrok_reads_i2c(tmp_path):
    cpu = processor()
    bus = EmulatedI2cBus(cpu, 400_000, "i2c9")
    writer = capture(tmp_path / "a.mcap", bus_table("i2c9", "i2c", 400_000) + PORT)
    bus.observer = writer.i2c_recorder("i2c9")
    bus.attach(0x48, Thermometer())
    cpu.time.now = 1_000
    bus.transaction(0x48, b"\x01", 2)
    bus.transaction(0x48, b"\x02\x60")
    waves(finish(writer, cpu.time.now + 10_000), "-b", "i2c9", "-o", tmp_path / "a.vcd")
    rows = decoded(tmp_path / "a.vcd", "i2c:scl=i2c9_scl:sda=i2c9_sda", "i2c=addr-data", "vcd")
    told = [row.split(": ", 1)[1] for row in rows]
    first = "Start|Write|Address write: 48|ACK|Data write: 01|ACK|Start repeat|Read|Address read: 48|ACK|"
    first += "Data read: A0|ACK|Data read: A1|NACK|Stop"
    second = "Start|Write|Address write: 48|ACK|Data write: 02|ACK|Data write: 60|ACK|Stop"
    assert "|".join(told) == f"{first}|{second}"
