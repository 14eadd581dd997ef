"""UART reception by DMA, transmission, and lines whose ends disagree about the rate."""

from fractions import Fraction
from itertools import pairwise

import pytest
from emulated_benches import Collector, processor
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.uart import EmulatedUart, UartWire
from hal.emulated.uart_bytes import SentBytes, rates_agree, sample
from hal.emulated.virtual_time import SECOND, VirtualTime
from hal.endings import ProcessorReset

ENTRY_NS = 72
"""12 cycles at 168 MHz, rounded up."""


class Port:
    """A port at 9600 baud with a ring of 64 bytes; `seen` holds (instant, count) of every interrupt."""

    def __init__(self, ring: int = 64, baud: int = 9600) -> None:
        self.cpu: EmulatedCpu = processor("rx")
        self.time: VirtualTime = self.cpu.time
        self.tx = UartWire(self.time, baud, "tx", capacity=256)
        self.rx = UartWire(self.time, baud, "rx")
        self.uart = EmulatedUart(self.cpu, self.tx, self.rx)
        self.ring = bytearray(ring)
        self.seen: list[tuple[int, int]] = []
        self.line = self.cpu.attach("rx", self._interrupt)

    def start(self) -> None:
        self.uart.start_receive(self.ring, self.line)

    def _interrupt(self) -> None:
        at = self.time.now - ENTRY_NS
        self.seen.append((at, self.uart.received()))


def ends(count: int, baud: int = 9600) -> int:
    return count * 10 * SECOND // baud


def test_interrupts_come_at_half_full_and_idle() -> None:
    port = Port()
    port.start()
    port.rx.send(bytes(range(100)))
    port.cpu.delay(200_000_000)
    idle = ends(100) + ends(1)
    assert port.seen == [(ends(32), 32), (ends(64), 64), (ends(96), 96), (idle, 100)]
    assert port.ring == bytes(range(64, 100)) + bytes(range(36, 64))


def test_idle_comes_once_after_each_burst_and_not_within_one() -> None:
    """A gap below one frame is no idle line; one of a frame or more is."""
    port = Port()
    port.start()
    port.rx.send(b"abc")
    short = ends(3) + ends(1) - 1
    port.time.at(short, lambda: port.rx.send(b"def") and None)
    second = short + ends(3)
    long = second + 2 * ends(1)
    port.time.at(long, lambda: port.rx.send(b"g") and None)
    port.cpu.delay(100_000_000)
    assert port.seen == [(second + ends(1), 6), (long + 2 * ends(1), 7)]


def test_burst_costs_few_events() -> None:
    """A burst of six sentences: half, full, idle and the ends of lines that moved."""
    port = Port(ring=512, baud=115_200)
    port.start()
    before = port.time.events_run
    for _ in range(6):
        port.rx.send(bytes(75))
    port.cpu.delay(100_000_000)
    assert port.uart.received() == 450
    assert len(port.seen) == 2
    assert port.time.events_run - before <= 4


@settings(max_examples=60, deadline=None)
@given(
    st.integers(1, 40),
    st.lists(st.tuples(st.integers(0, 30_000_000), st.binary(min_size=1, max_size=50)), max_size=8),
    st.lists(st.integers(0, 60_000_000), max_size=20),
)
def test_count_and_ring_are_exact_at_every_poll(
    size: int, sends: list[tuple[int, bytes]], polls: list[int]
) -> None:
    """Against a list of bytes one by one; interrupts at every half and end of the ring and idle line."""
    port = Port(ring=size)
    port.start()
    expected: list[tuple[int, int, int]] = []
    start, frames = 0, 0
    for at, data in sorted(sends, key=lambda entry: entry[0]):
        port.time.at(at, lambda data=data: port.rx.send(data) and None)  # type: ignore[misc]
        if at >= start + ends(frames):
            start, frames = at, 0
        for byte in data:
            expected.append((start + ends(frames), start + ends(frames + 1), byte))
            frames += 1
    for poll in sorted(polls):
        if poll > port.time.now:
            port.cpu.wait_until(poll)
            count = port.uart.received()
            assert count == sum(end <= port.time.now for _, end, _ in expected)
            held = {n % size: expected[n][2] for n in range(max(0, count - size), count)}
            assert all(port.ring[at] == byte for at, byte in held.items())
    port.cpu.wait_until(2 * SECOND)
    marks = {end for n, (_, end, _) in enumerate(expected, 1) if n % size in (0, size // 2)}
    begins = [begin for begin, _, _ in expected[1:]] + [3 * SECOND]
    quiet = {
        end + ends(1)
        for (_, end, _), begin in zip(expected, begins[: len(expected)], strict=True)
        if begin - end >= ends(1)
    }
    assert [at for at, _ in port.seen] == sorted(marks | quiet)


def test_reception_before_there_is_a_ring_is_one_overrun() -> None:
    port = Port()
    port.rx.send(b"lost in the void")
    port.cpu.delay(30_000_000)
    port.start()
    assert port.uart.received() == 0
    assert port.uart.take_errors() == 1
    assert port.uart.take_errors() == 0


def test_transmission_takes_what_fits_and_frees_it_byte_by_byte() -> None:
    port = Port()
    far_end = Collector()
    port.tx.connect(far_end)
    data = bytes(n % 256 for n in range(300))
    assert port.uart.write(data) == 256
    assert port.uart.tx_free() == 0
    port.cpu.wait_until(ends(10))
    assert port.uart.tx_free() == 10
    assert port.uart.write(data[256:]) == 10
    port.cpu.delay(SECOND)
    assert far_end.data == data[:266]
    assert port.uart.tx_free() == 256


def test_reset_stops_transmission_and_reception() -> None:
    port = Port()
    far_end = Collector()
    port.tx.connect(far_end)
    port.start()
    port.uart.write(bytes(100))
    port.rx.send(bytes(10))
    port.time.at(ends(5) + 1, lambda: port.cpu.reset("test"))
    with pytest.raises(ProcessorReset):
        port.cpu.delay(SECOND)
    port.cpu.delay(SECOND)
    assert far_end.data == bytes(5)
    assert port.uart.received() == 5
    assert port.seen == []


def test_rate_of_queued_bytes_stays() -> None:
    """A receiver acknowledges at the old rate and goes on at the new one."""
    time = VirtualTime()
    wire = UartWire(time, 9600)
    far_end = Collector()
    wire.connect(far_end)
    wire.send(b"ack")
    wire.set_baud(115_200)
    wire.send(b"data")
    while time.next_due < SECOND:
        time.run_next()
    assert far_end.chunks == [(ends(3), b"ack"), (ends(3) + ends(4, 115_200), b"data")]


def test_line_knows_how_long_it_was_busy() -> None:
    time = VirtualTime()
    wire = UartWire(time, 9600)
    wire.connect(Collector())
    wire.send(bytes(6))
    wire.set_baud(115_200)
    wire.send(bytes(100))
    assert wire.busy_ns == 0
    time.at(ends(3), lambda: None)
    time.run_next()
    assert wire.busy_ns == ends(3)
    while time.next_due < SECOND:
        time.run_next()
    assert wire.busy_ns == ends(6) + ends(100, 115_200)


def test_wrong_rates_are_refused() -> None:
    with pytest.raises(ValueError, match="baud rate 0 of 'gnss'; it must be positive"):
        UartWire(VirtualTime(), 0, "gnss")
    port = Port()
    with pytest.raises(ValueError, match="baud rate -1 of 'tx'"):
        port.uart.set_baud(-1)


# -- sampling at the wrong rate ----------------------------------------------------------------------


def sampled(data: bytes, sent_baud: int, sampled_baud: int) -> list[tuple[int, bool]]:
    line = [SentBytes(data, 1000, 0, sent_baud)]
    return [(one.data[0], bool(one.errors)) for one in sample(line, sampled_baud, 0)]


def test_sampling_worked_out_by_hand() -> None:
    """0x55 at twice its rate: every bit is seen twice, the fifth low one at the place of the stop bit;
    the second frame starts at the falling edge into d5. 0x00 at four times: nine low bits, one byte with a
    framing error, then nothing but high. 0xFF at four times: start and three low bits."""
    assert sampled(b"\x55", 9600, 19_200) == [(0x66, True), (0xE6, False)]
    assert sampled(b"\x00", 9600, 38_400) == [(0x00, True)]
    assert sampled(b"\xff", 9600, 38_400) == [(0xF8, False)]
    assert sampled(b"\xff", 38_400, 9600) == []


@settings(deadline=None)
@given(st.binary(min_size=1, max_size=30), st.integers(1200, 921_600), st.integers(-40, 40))
def test_small_rate_errors_do_no_harm(data: bytes, baud: int, permille: int) -> None:
    """±4 % are within the tolerance of the start-stop principle."""
    assert sampled(data, baud, baud + baud * permille // 1000) == [(byte, False) for byte in data]


def independent_uart(data: bytes, sent: int, received: int) -> list[tuple[int, bool]]:
    """The same receiver on exact rational times, one bit at a time."""
    bits = [1] + [level for byte in data for level in (0, *((byte >> k) & 1 for k in range(8)), 1)]
    bit_time, sample_time = Fraction(1, sent), Fraction(1, received)

    def level(at: Fraction) -> int:
        index = at // bit_time + 1
        return bits[index] if 0 <= index < len(bits) else 1

    edges = [k * bit_time for k in range(len(bits) - 1) if bits[k] and not bits[k + 1]]
    found = []
    ready = Fraction(0)
    for edge in edges:
        if edge < ready or level(edge + sample_time / 2):
            continue
        levels = [level(edge + (k + Fraction(1, 2)) * sample_time) for k in range(10)]
        found.append((sum(bit << k for k, bit in enumerate(levels[1:9])), not levels[9]))
        ready = edge + Fraction(19, 2) * sample_time
    return found


@settings(deadline=None)
@given(
    st.binary(min_size=1, max_size=12),
    st.sampled_from([4800, 9600, 14_400, 19_200, 57_600]),
    st.sampled_from([4799, 7001, 9601, 12_007, 33_013, 57_601, 100_003]),
)
def test_sampling_agrees_with_an_independent_receiver(data: bytes, sent: int, received: int) -> None:
    """Odd receiver rates keep the samples off the edges, where ns and rational times would disagree."""
    assert sampled(data, sent, received) == independent_uart(data, sent, received)


@given(st.integers(1000, 1_000_000), st.integers(1000, 1_000_000))
def test_agreement_is_what_sampling_says(sent: int, received: int) -> None:
    """Rates that agree read every byte; the two most sensitive bytes fail otherwise."""
    patterns = (b"\x00", b"\xff", b"\x55", b"\x00\xff\x00", b"\xff\x00\x55\xaa" * 3)
    clean = all(
        sampled(pattern, sent, received) == [(byte, False) for byte in pattern] for pattern in patterns
    )
    if rates_agree(sent, received):
        assert clean
    elif not 0.94 < sent / received < 1.06:
        assert not clean


def test_receiver_at_the_wrong_rate_sees_garbage_and_framing_errors() -> None:
    port = Port(baud=9600)
    port.uart.set_baud(38_400)
    port.start()
    sentence = b"$GNGGA,,,,,,0,00,99.99,,,,,,*56\r\n"
    port.rx.send(sentence)
    port.cpu.delay(100_000_000)
    expected = sampled(sentence, 9600, 38_400)
    assert port.uart.received() == len(expected)
    assert port.ring == bytes(byte for byte, _ in expected).ljust(64, b"\0")[:64] or len(expected) > 64
    assert port.uart.take_errors() == sum(error for _, error in expected)
    assert port.uart.take_errors() == 0


def test_receiver_that_finds_the_rate_is_in_step_after_the_next_gap() -> None:
    """Changed in the middle of a burst: garbage until then, whole sentences afterwards."""
    port = Port(ring=256)
    port.uart.set_baud(115_200)
    port.start()
    port.rx.send(b"UUUU$GNRMC,first*00\r\n")
    port.time.at(ends(6) + 300_000, lambda: port.uart.set_baud(9600))
    port.time.at(100_000_000, lambda: port.rx.send(b"$GNRMC,second*00\r\n") and None)
    port.cpu.delay(200_000_000)
    received = bytes(port.ring[: port.uart.received()])
    assert received.endswith(b"$GNRMC,second*00\r\n")
    assert not received.startswith(b"UUUU")


def test_chip_whose_port_has_another_rate_hears_garbage() -> None:
    """Both directions of a chip's port have the rate of the line that the chip drives."""
    time = VirtualTime()
    to_chip, from_chip = UartWire(time, 115_200, "to chip"), UartWire(time, 9600, "from chip")
    chip, tap = Collector(), Collector()
    to_chip.connect(chip, rate_of=from_chip)
    to_chip.connect(tap)
    to_chip.send(b"hello")
    while time.next_due < SECOND:
        time.run_next()
    assert chip.data != b"hello"
    assert tap.data == b"hello"
    from_chip.set_baud(115_200)
    to_chip.send(b"hello")
    while time.next_due < SECOND:
        time.run_next()
    assert chip.data.endswith(b"hello")


def test_a_line_that_never_rests_is_sampled_once() -> None:
    """More traffic than the rate carries, at rates that disagree: each piece behind a backlog costs what the
    piece has to sample, not what the backlog has."""
    steps = []
    for pieces in (50, 200):
        port = Port(ring=64)
        port.uart.set_baud(115_200)
        port.start()
        seen = 0
        real = SentBytes.level_at

        def counted(self: SentBytes, time_ns: int) -> bool:
            nonlocal seen
            seen += 1
            return real(self, time_ns)  # noqa: B023

        SentBytes.level_at = counted  # type: ignore[method-assign]
        try:
            for _ in range(pieces):
                port.rx.send(b"backlog of a line that never rests")
        finally:
            SentBytes.level_at = real  # type: ignore[method-assign]
        steps.append(seen)
    assert steps[1] < 5 * steps[0]


@pytest.mark.parametrize("baud", [38_400, 14_400, 115_200])
def test_a_backlog_is_heard_as_one_piece_would_be(baud: int) -> None:
    data = bytes(range(256)) * 2
    heard = []
    for cuts in ([0, 512], [0, 1, 2, 100, 101, 300, 512]):
        port = Port(ring=8192)
        port.uart.set_baud(baud)
        port.start()
        for begin, end in pairwise(cuts):
            port.rx.send(data[begin:end])
        port.cpu.delay(SECOND)
        heard.append((bytes(port.ring[: port.uart.received()]), port.uart.take_errors()))
    assert heard[0] == heard[1]
    assert heard[0][1] > 0
