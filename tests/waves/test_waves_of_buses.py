"""Line levels of emulated buses, read back by decoders that know nothing of how they were drawn."""

import contextlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vcd_decoders import Frame, Probe, decode_can, decode_i2c, decode_spi, decode_uart, read_vcd
from wave_captures import PORT, bus_table, capture, finish, processor, waves

from hal.can import CanFrame
from hal.emulated.can import CanNode, EmulatedCanBus
from hal.emulated.can_frame import frame_bits
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.virtual_time import VirtualTime
from hal.errors import BusError
from host.capture.blocks import can_records
from host.waves.can_lines import frame_levels

MESSAGES = [b"\x8c" + bytes(15), b"\xff", bytes(range(7)), b"\x55\xaa" * 4]
SPI_CHIPS = """
[chips.U1]
part = "X"
model = "a:b"
bus = "spi9"
name = "words"
world = "imu"
spi = { clock_hz = 1_000_000, bits_per_word = 16, stall_ns = 9_000 }
"""


class Inverting:
    """Answers every byte with its complement."""

    def transaction(self, mosi, start_ns, end_ns):
        return bytes(byte ^ 0xFF for byte in mosi)


@pytest.mark.parametrize("mode", [0, 1, 2, 3])
def test_spi_in_every_mode_with_two_chips(tmp_path, mode):
    """Some transactions follow one another without a pause: they are told apart all the same."""
    cpu = processor()
    bus = EmulatedSpiBus(cpu, SpiTiming(5_250_000), "spi9")
    writer = capture(tmp_path / "a.mcap", bus_table("spi9", "spi", 5_250_000, mode) + SPI_CHIPS)
    words = SpiTiming(1_000_000, bits_per_word=16, stall_ns=9_000)
    devices = [bus.device(Inverting(), "plain"), bus.device(Inverting(), "words", words)]
    for device in devices:
        device.observer = writer.spi_recorder(f"spi9.{device.name}")
    told = ([], [])
    for message in MESSAGES:
        for device, sent, pause in zip(devices, told, (0, 3_000), strict=True):
            data = message + bytes(len(message) % 2) if device.name == "words" else message
            start = cpu.time.now
            device.transaction(bytearray(data))
            sent.append((start, cpu.time.now, data))
            cpu.time.now += pause
    outcome = waves(finish(writer, cpu.time.now + 1), "-o", tmp_path / "a.vcd")
    assert outcome.exit_code == 0, outcome.output
    lines = read_vcd(tmp_path / "a.vcd")
    assert list(lines) == ["spi9_sck", "spi9_mosi", "spi9_miso", "spi9_cs_plain", "spi9_cs_words"]
    for device, sent in zip(devices, told, strict=True):
        wires = [lines[f"spi9_{name}"] for name in ("sck", "mosi", "miso", f"cs_{device.name}")]
        found = decode_spi(*wires, mode)
        assert [(one.start_ns, one.mosi) for one in found] == [(start, data) for start, _, data in sent]
        assert [one.miso for one in found] == [bytes(b ^ 0xFF for b in data) for *_, data in sent]
        for one, (_, end, _) in zip(found, sent, strict=True):
            assert end - 48 <= one.end_ns <= end  # a quarter of a clock for the next one to be seen
        if device.name == "words":
            assert [one.end_ns for one in found] == [end for _, end, _ in sent]


def test_spi_words_of_the_adis16407_stand_apart(tmp_path):
    """Three words of 16 bits at 1 MHz with 9 µs between: 16 clocks, silence, 16 clocks."""
    cpu = processor()
    bus = EmulatedSpiBus(cpu, SpiTiming(1_000_000), "spi9")
    writer = capture(tmp_path / "a.mcap", bus_table("spi9", "spi", 1_000_000, 3) + SPI_CHIPS)
    device = bus.device(Inverting(), "words", SpiTiming(1_000_000, bits_per_word=16, stall_ns=9_000))
    device.observer = writer.spi_recorder("spi9.words")
    device.transaction(bytearray(b"\x42\x00\x00\x00\x12\x34"))
    waves(finish(writer, cpu.time.now), "-o", tmp_path / "a.vcd")
    falls = [t for t, level in read_vcd(tmp_path / "a.vcd")["spi9_sck"] if level == "0"]
    assert falls == [25_000 * word + 1_000 * bit for word in range(3) for bit in range(16)]


class Memory:
    """I²C slave that acknowledges so many bytes and counts up."""

    def __init__(self, takes=100, stretch_ns=0):
        self.takes, self.stretch_ns = takes, stretch_ns

    def write(self, data, time_ns):
        return min(self.takes, len(data))

    def read(self, length, time_ns):
        return bytes(range(1, length + 1))


CALLS = [
    (0x68, b"\x0c", 6, [[(0xD0, True), (0x0C, True)], [(0xD1, True)] + [(k, k < 6) for k in range(1, 7)]]),
    (0x68, b"\x7e\xb6", 0, [[(0xD0, True), (0x7E, True), (0xB6, True)]]),
    (0x68, b"", 2, [[(0xD1, True), (1, True), (2, False)]]),
    (0x68, b"", 0, [[(0xD0, True)]]),
    (0x50, b"\x01", 2, [[(0xA0, False)]]),
    (0x50, b"", 1, [[(0xA1, False)]]),
    (0x1E, b"\x01\x02\x03", 1, [[(0x3C, True), (1, True), (2, False), (3, False)]]),
    (0x19, b"\x55", 1, [[(0x32, True), (0x55, True)], [(0x33, True), (1, False)]]),
]


@pytest.mark.parametrize("clock_hz", [100_000, 400_000, 1_000_000])
def test_i2c_with_refusals_and_a_slave_that_holds_the_clock(tmp_path, clock_hz):
    cpu = processor()
    bus = EmulatedI2cBus(cpu, clock_hz, "i2c9")
    writer = capture(tmp_path / "a.mcap", bus_table("i2c9", "i2c", clock_hz))
    bus.observer = writer.i2c_recorder("i2c9")
    for address, slave in ((0x68, Memory()), (0x1E, Memory(takes=1)), (0x19, Memory(stretch_ns=70_000))):
        bus.attach(address, slave)
    cpu.time.now = 1_000
    times = []
    for number, (address, write, length, _) in enumerate(CALLS):
        start = cpu.time.now
        with contextlib.suppress(BusError):
            bus.transaction(address, write, length)
        times.append((start, cpu.time.now))
        cpu.time.now += 5_000 * (number % 2)
    waves(finish(writer, cpu.time.now + 1), "-b", "i2c9", "-o", tmp_path / "a.vcd")
    lines = read_vcd(tmp_path / "a.vcd")
    found = decode_i2c(lines["i2c9_scl"], lines["i2c9_sda"])
    assert [one.parts for one in found] == [parts for *_, parts in CALLS]
    assert [one.start_ns for one in found] == [start for start, _ in times]
    for number, (one, (_, end)) in enumerate(zip(found, times, strict=True)):
        pause = number % 2 or number == len(CALLS) - 1
        assert one.end_ns == (end if pause else end - 10**9 // (5 * clock_hz))
    half = 6 * 10**8 // clock_hz
    assert [one.longest_low_ns > 2 * half for one in found] == [False] * 7 + [True]
    assert 70_000 <= found[-1].longest_low_ns <= 70_000 + half + 1


def test_i2c_that_was_held_too_long_ends_without_a_stop(tmp_path):
    cpu = processor()
    bus = EmulatedI2cBus(cpu, 400_000, "i2c9", stretch_limit_ns=1_000_000)
    writer = capture(tmp_path / "a.mcap", bus_table("i2c9", "i2c", 400_000))
    bus.observer = writer.i2c_recorder("i2c9")
    bus.attach(0x19, Memory(stretch_ns=2_000_000))
    cpu.time.now = 1_000
    with pytest.raises(BusError):
        bus.transaction(0x19, b"\x01", 1)
    end = cpu.time.now
    waves(finish(writer, end + 1), "-o", tmp_path / "a.vcd")
    lines = read_vcd(tmp_path / "a.vcd")
    (one,) = decode_i2c(lines["i2c9_scl"], lines["i2c9_sda"])
    assert (one.parts, one.end_ns, one.longest_low_ns) == ([[(0x32, True)]], None, 1_000_000)
    assert lines["i2c9_scl"][-1] == (end, "1")


def test_uart_rates_runs_and_what_was_taken_back(tmp_path):
    """A 9600 baud line into the board that changes to 115200, bytes taken back; runs of pieces out of it."""
    writer = capture(tmp_path / "a.mcap", PORT)
    told, sent = writer.line_recorder("p"), writer.uart_recorder("p", "tx")
    told(1_000, 1_000, 0, 9600, b"hello, world")
    told(2_000_000, 3_000_000, 0, 0, b"")  # bytes that begin at 3 ms or later do not come: 3 have begun
    told(20_000_000, 20_000_000, 0, 115_200, bytes(range(256)))
    out = [(30_000_000, b"\x00\xff\x55"), (30_000_000, b"back to back"), (32_000_000, b"U")]
    frame = 10 * 10**9
    starts, run, count = [], None, 0
    for begin, data in out:
        run, count = (run, count) if run == begin else (begin, 0)
        starts += [(begin + (count + k) * frame // 115_200, byte) for k, byte in enumerate(data)]
        count += len(data)
        sent(begin + count * frame // 115_200, data)
        run = begin
    outcome = waves(finish(writer, 60_000_000), "-o", tmp_path / "a.vcd")
    assert outcome.exit_code == 0, outcome.output
    lines = read_vcd(tmp_path / "a.vcd")
    early = [change for change in lines["p_rx"] if change[0] < 20_000_000]
    assert decode_uart(early, 9600) == [(1_000 + k * frame // 9600, c) for k, c in enumerate(b"hel")]
    late = [(0, "1"), *(change for change in lines["p_rx"] if change[0] >= 20_000_000)]
    expected = [(20_000_000 + k * frame // 115_200, k) for k in range(256)]
    assert decode_uart(late, 115_200) == expected
    assert decode_uart(lines["p_tx"], 115_200) == starts


def test_uart_bytes_with_faults_look_like_it(tmp_path):
    """Low stop bits, and a parity bit that makes frames of eleven bits."""
    writer = capture(tmp_path / "a.mcap", PORT)
    told = writer.line_recorder("p")
    bit = 10**9 / 9600
    told(0, 1_000_000, 0, 9600, b"A", 1)
    told(0, 10_000_000, 0, 9600, b"AC", 2)
    waves(finish(writer, 60_000_000), "-o", tmp_path / "a.vcd")
    probe = Probe(read_vcd(tmp_path / "a.vcd")["p_rx"])

    def bits(start_ns, count):
        return "".join(probe.at(int(start_ns + (k + 0.5) * bit)) for k in range(count))

    assert bits(1_000_000, 11) == "0" + "10000010" + "0" + "1"
    assert bits(10_000_000, 23) == "0" + "10000010" + "01" + "0" + "11000010" + "11" + "1"


def test_uart_out_at_a_rate_that_nothing_tells(tmp_path):
    """Before anything came in it is the board's; a piece that does not fit there was sent faster; --rate."""
    writer = capture(tmp_path / "a.mcap", PORT)
    sent = writer.uart_recorder("p", "tx")
    frame = 10 * 10**9
    sent(50_000_000, b"slow")
    sent(50_000_000 + 2 * frame // 38_400, b"qu")
    path = finish(writer, 60_000_000)
    waves(path, "-o", tmp_path / "a.vcd", "-q")
    line = read_vcd(tmp_path / "a.vcd")["p_tx"]
    begin = 50_000_000 - 4 * frame // 9600
    slow = [change for change in line if change[0] < 50_000_000]
    assert decode_uart(slow, 9600) == [(begin + k * frame // 9600, c) for k, c in enumerate(b"slow")]
    quick = [(0, "1"), *(change for change in line if change[0] >= 50_000_000)]
    assert [c for _, c in decode_uart(quick, 38_400)] == list(b"qu")
    waves(path, "-o", tmp_path / "b.vcd", "--rate", "p=115200")
    line = read_vcd(tmp_path / "b.vcd")["p_tx"]
    assert bytes(c for _, c in decode_uart(line, 115_200)) == b"slowqu"
    refused = waves(path, "-o", tmp_path / "c.vcd", "--rate", "p=9600")
    assert refused.exit_code == 2
    assert not list(tmp_path.glob("c.vcd*"))


def frames():
    base = st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8), st.just(False))
    long = st.tuples(st.integers(0, 0x1FFF_FFFF), st.binary(max_size=8), st.just(True))
    return st.builds(lambda told: CanFrame(*told), base | long)


@given(frames())
@settings(max_examples=300, deadline=None)
def test_can_frames_are_as_long_as_the_bus_takes_them(frame):
    assert len(frame_levels(frame.identifier, frame.extended, frame.data)) == frame_bits(frame)


@pytest.mark.parametrize("bitrate", [125_000, 500_000, 1_000_000])
def test_can_with_stuffing_and_two_senders(tmp_path, bitrate):
    time = VirtualTime()
    bus = EmulatedCanBus(time, bitrate, "can9")
    nodes = [CanNode(bus, "mcu"), CanNode(bus, "gateway")]
    listener = bus.listen_late()
    sent = [
        CanFrame(0x000, b"\x00" * 8, False),
        CanFrame(0x7FF, b"\xff" * 8, False),
        CanFrame(0x310, b"", False),
        CanFrame(0x1FFF_FFFF, b"\x0f\x83" * 4, True),
        CanFrame(0x0012_3456, b"\x55", True),
    ]
    time.now = 1_000
    for number, frame in enumerate(sent):
        nodes[number % 2].send([frame])
    time.now = 50_000_000
    heard = listener.take()
    writer = capture(tmp_path / "a.mcap", f'[can.can9]\nprocessor = "mcu"\nbitrate = {bitrate}\n')
    writer.can_recorder("can9")(can_records(heard), heard)
    waves(finish(writer, 60_000_000), "-o", tmp_path / "a.vcd")
    lines = read_vcd(tmp_path / "a.vcd")
    expected = [Frame(end, f.identifier, f.extended, f.data, True) for f, end, _ in heard]
    assert len(heard) == len(sent)
    assert decode_can(lines["can9_bus"], bitrate) == expected
    for node in ("mcu", "gateway"):
        own = [Frame(end, f.identifier, f.extended, f.data, False) for f, end, n in heard if n == node]
        assert decode_can(lines[f"can9_tx_{node}"], bitrate) == own
