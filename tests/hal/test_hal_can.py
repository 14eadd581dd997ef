"""CAN: frame lengths against the specification bit by bit, arbitration, bursts and errors."""

import pytest
from emulated_benches import processor
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.can import CanFrame
from hal.emulated.can import CanNode, EmulatedCanBus, EmulatedCanController
from hal.emulated.can_frame import frame_bits
from hal.emulated.virtual_time import SECOND, VirtualTime
from hal.endings import ProcessorReset

MS = 1_000_000

FRAMES = st.builds(
    lambda extended, identifier, data: CanFrame(
        identifier if extended else identifier & 0x7FF, data, extended
    ),
    st.booleans(),
    st.integers(0, 0x1FFF_FFFF) | st.sampled_from([0, 0x1FFF_FFFF]),
    st.binary(max_size=8) | st.lists(st.sampled_from([0, 0xFF, 0x0F, 0xC3]), max_size=8).map(bytes),
)

FACT_SHEET = [
    # data bytes, base: no stuff, worst; extended: no stuff, worst (interframe space included)
    (0, 47, 55, 67, 80),
    (1, 55, 65, 75, 90),
    (2, 63, 75, 83, 100),
    (3, 71, 85, 91, 110),
    (4, 79, 95, 99, 120),
    (5, 87, 105, 107, 130),
    (6, 95, 115, 115, 140),
    (7, 103, 125, 123, 150),
    (8, 111, 135, 131, 160),
]


def field(value: int, width: int) -> list[int]:
    return [value >> k & 1 for k in reversed(range(width))]


def header(frame: CanFrame) -> list[int]:
    """From start of frame to the reserved bits."""
    if frame.extended:
        return [0, *field(frame.identifier >> 18, 11), 1, 1, *field(frame.identifier & 0x3FFFF, 18), 0, 0, 0]
    return [0, *field(frame.identifier, 11), 0, 0, 0]


def bits_on_the_wire(frame: CanFrame) -> tuple[list[int], int]:
    """The frame from start of frame to CRC with its stuff bits, and how many of those there are."""
    bits = header(frame) + field(len(frame.data), 4) + [bit for byte in frame.data for bit in field(byte, 8)]
    crc = 0
    for bit in bits:
        crc = (crc << 1 ^ (0x4599 if bit ^ crc >> 14 else 0)) & 0x7FFF
    bits += field(crc, 15)
    wire: list[int] = []
    for bit in bits:
        wire.append(bit)
        if len(wire) >= 5 and len(set(wire[-5:])) == 1:
            wire.append(1 - bit)
    return wire, len(wire) - len(bits)


@given(FRAMES)
def test_length_is_that_of_the_stuffed_bits(frame: CanFrame) -> None:
    assert frame_bits(frame) == len(bits_on_the_wire(frame)[0]) + 1 + 2 + 7


@given(FRAMES)
def test_length_lies_within_the_fact_sheet(frame: CanFrame) -> None:
    _, base, base_worst, extended, extended_worst = FACT_SHEET[len(frame.data)]
    least, most = (extended, extended_worst) if frame.extended else (base, base_worst)
    stuffed = bits_on_the_wire(frame)[1]
    assert frame_bits(frame) + 3 == least + stuffed
    assert frame_bits(frame) + 3 <= most


def test_crc_check_value() -> None:
    """CRC-15/CAN of "123456789" is 0x059E: as data of frames it would stand behind a header, so the
    independent generator above is checked here with the check value of the public catalogue."""
    crc = 0
    for byte in b"123456789":
        for k in reversed(range(8)):
            bit = byte >> k & 1
            crc = (crc << 1 ^ (0x4599 if bit ^ crc >> 14 else 0)) & 0x7FFF
    assert crc == 0x059E


def test_heaviest_stuffing_of_a_real_frame() -> None:
    """Eight zero bytes: 108 bits without and 130 with stuffing, counted on the bit string of the frame."""
    frame = CanFrame(0x000, bytes(8))
    stuffed = bits_on_the_wire(frame)[1]
    assert stuffed >= 15
    assert frame_bits(frame) == 108 + stuffed


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (CanFrame(0x800, b""), "CAN identifier 0x800: a 11-bit one is at most 0x7FF"),
        (CanFrame(-1, b"", True), "CAN identifier 0x-1: a 29-bit one"),
        (CanFrame(1, bytes(9)), "CAN frame 0x1 with 9 data bytes; 8 at most"),
    ],
)
def test_impossible_frames_are_refused(frame: CanFrame, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        frame_bits(frame)


class Bus:
    """A controller "mcu" at 500 kbit/s, a node "ecu" and a listener that logs (instant, identifier)."""

    def __init__(self, bitrate: int = 500_000, with_ecu: bool = True) -> None:
        self.cpu = processor("rx")
        self.time: VirtualTime = self.cpu.time
        self.bus = EmulatedCanBus(self.time, bitrate)
        self.mcu = EmulatedCanController(self.cpu, self.bus, "mcu", depth=16)
        self.log: list[tuple[int, int]] = []
        self.bus.listen(lambda frame, end: self.log.append((end, frame.identifier)), acknowledges=False)
        self.ecu = CanNode(self.bus, "ecu") if with_ecu else None

    def ns(self, bits: int) -> int:
        return bits * SECOND // self.bus.bitrate


def frame(identifier: int, length: int = 8) -> CanFrame:
    """Without a stuff bit in front of the data, so that lengths differ by content only."""
    return CanFrame(identifier, bytes((0x55,)) * length)


def test_frames_queued_together_follow_each_other_and_cost_one_event() -> None:
    bench = Bus()
    frames = tuple(frame(0x100 + n, n) for n in range(5))
    before = bench.time.events_run
    assert bench.mcu.send(frames) == 5
    bench.cpu.delay(10 * MS)
    ends, bits = [], 0
    for one in frames:
        ends.append((bench.ns(bits + frame_bits(one)), one.identifier))
        bits += frame_bits(one) + 3
    assert bench.log == ends
    assert bench.time.events_run - before == 1
    assert bench.bus.busy_ns == bench.ns(bits)
    assert bench.bus.frames == 5


def test_receiver_with_an_interrupt_hears_of_each_frame_at_its_end() -> None:
    bench = Bus()
    served: list[int] = []
    bench.mcu.pend_on_receive(bench.cpu.attach("rx", lambda: served.append(bench.time.now - 72)))
    assert bench.ecu is not None
    bench.ecu.send((frame(1), frame(2)))
    bench.cpu.delay(10 * MS)
    assert served == [end for end, _ in bench.log]
    assert bench.mcu.receive() == frame(1)


def test_polled_receiver_sees_a_frame_as_soon_as_it_has_ended() -> None:
    bench = Bus()
    assert bench.ecu is not None
    bench.ecu.send((frame(1), frame(2)))
    end = bench.ns(frame_bits(frame(1)))
    bench.cpu.wait_until(end - 100)
    assert bench.mcu.receive() is None
    bench.cpu.wait_until(end)
    assert bench.mcu.receive() == frame(1)
    assert bench.mcu.receive() is None


def test_lower_identifier_wins_and_base_beats_extended() -> None:
    bench = Bus()
    third = CanNode(bench.bus, "third")
    assert bench.ecu is not None
    bench.ecu.send((CanFrame(0x123 << 18, b"", True), frame(0x010)))
    third.send((frame(0x200), frame(0x001)))
    bench.mcu.send((frame(0x123), frame(0x7FF)))
    bench.cpu.delay(10 * MS)
    # All begin in the same instant; a queue is worked off in its own order.
    assert [identifier for _, identifier in bench.log] == [0x123, 0x123 << 18, 0x010, 0x200, 0x001, 0x7FF]


def test_urgent_frame_of_another_node_cuts_into_a_burst_but_not_into_a_frame() -> None:
    bench = Bus()
    assert bench.ecu is not None
    bench.mcu.send((frame(0x300), frame(0x301), frame(0x302)))
    in_second = bench.ns(frame_bits(frame(0x300)) + 3 + 20)
    bench.time.at(in_second, lambda: bench.ecu.send((frame(0x010),)) and None)  # type: ignore[union-attr]
    bench.cpu.delay(10 * MS)
    assert [identifier for _, identifier in bench.log] == [0x300, 0x301, 0x010, 0x302]
    ends = [end for end, _ in bench.log]
    bits = 0
    for end, identifier in zip(ends, [0x300, 0x301, 0x010, 0x302], strict=True):
        bits += frame_bits(frame(identifier))
        assert end == bench.ns(bits)
        bits += 3


def test_queue_takes_what_it_has_room_for() -> None:
    bench = Bus()
    frames = tuple(frame(n) for n in range(20))
    assert bench.mcu.send(frames) == 16
    assert bench.mcu.send(frames) == 0
    bench.cpu.wait_until(bench.ns(frame_bits(frame(0)) + 3))
    assert bench.mcu.send(frames) == 1


def test_receive_queue_overruns() -> None:
    bench = Bus()
    assert bench.ecu is not None
    bench.ecu.send(tuple(frame(n) for n in range(40)))
    bench.cpu.delay(100 * MS)
    received = []
    while (one := bench.mcu.receive()) is not None:
        received.append(one.identifier)
    assert received == list(range(32))
    assert bench.mcu.overruns == 8


def test_node_alone_on_its_bus_tries_for_ever_and_stays_error_passive() -> None:
    """Sixteen attempts to error-passive, then with eight suspend bits more; never bus-off; no events."""
    bench = Bus(with_ecu=False)
    before = bench.time.events_run
    bench.mcu.send((frame(0x100),))
    bench.cpu.delay(10 * SECOND)
    assert bench.time.events_run == before
    assert bench.mcu.state == "error-passive"
    assert bench.mcu.error_count == 128
    attempt = frame_bits(frame(0x100)) - 8 + 6 + 8 + 3
    expected = 16 + (10 * 500_000 - 16 * attempt) / (attempt + 8)
    assert bench.bus.error_frames == pytest.approx(expected, abs=1.01)
    assert bench.log == []


def test_frame_goes_out_when_somebody_comes_to_acknowledge() -> None:
    bench = Bus(with_ecu=False)
    bench.mcu.send((frame(0x100),))
    attempt = bench.ns(frame_bits(frame(0x100)) - 8 + 6 + 8 + 3)
    bench.cpu.delay(5 * attempt + attempt // 2)
    CanNode(bench.bus, "late")
    bench.cpu.delay(10 * MS)
    sixth = 6 * (frame_bits(frame(0x100)) - 8 + 6 + 8 + 3)
    assert bench.log == [(bench.ns(sixth + frame_bits(frame(0x100))), 0x100)]
    assert bench.bus.error_frames == 6
    assert bench.mcu.error_count == 6 * 8 - 1
    assert bench.mcu.state == "error-active"


def test_disturbed_bus_leads_to_bus_off_and_back() -> None:
    bench = Bus()
    struck: list[int] = []

    def strike() -> None:
        struck.append(bench.time.now)

    bench.bus.begin_disturbance(strike)
    bench.mcu.send((frame(0x100), frame(0x101)))
    bench.cpu.delay(50 * MS)
    assert bench.mcu.state == "bus-off"
    assert len(struck) == 32
    bench.bus.end_disturbance(strike)
    back = bench.time.now + bench.ns(128 * 11)
    bench.cpu.delay(50 * MS)
    first = back + bench.ns(frame_bits(frame(0x100)))
    second = back + bench.ns(2 * frame_bits(frame(0x100)) + 3)
    assert bench.log == [(first, 0x100), (second, 0x101)]
    assert bench.mcu.state == "error-active"


def test_frame_under_way_breaks_when_a_disturbance_begins() -> None:
    bench = Bus()
    bench.mcu.send((frame(0x100),))
    bench.cpu.delay(100_000)
    struck: list[int] = []

    def strike() -> None:
        struck.append(bench.time.now)

    bench.bus.begin_disturbance(strike)
    bench.cpu.delay(1000)
    assert struck == [100_000]
    assert bench.bus.error_frames == 1
    bench.bus.end_disturbance(strike)
    bench.cpu.delay(10 * MS)
    assert [identifier for _, identifier in bench.log] == [0x100]


def test_reset_of_the_processor_empties_its_queue() -> None:
    bench = Bus()
    bench.mcu.send(tuple(frame(n) for n in range(10)))
    bench.time.at(bench.ns(2 * (frame_bits(frame(0)) + 3) + 50), lambda: bench.cpu.reset("test"))
    with pytest.raises(ProcessorReset):
        bench.cpu.delay(SECOND)
    bench.cpu.delay(SECOND)
    assert [identifier for _, identifier in bench.log] == [0, 1]
    assert bench.mcu.send((frame(0x55),)) == 1
    bench.cpu.delay(SECOND)
    assert bench.log[-1][1] == 0x55


def test_bit_rate_is_checked() -> None:
    with pytest.raises(ValueError, match="CAN bit rate 2000000 of 'can'; classic CAN has at most 1_000_000"):
        EmulatedCanBus(VirtualTime(), 2_000_000)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 4 * MS), st.integers(0, 2), FRAMES), max_size=25))
def test_bus_agrees_with_a_simulation_frame_by_frame(sends: list[tuple[int, int, CanFrame]]) -> None:
    """Every frame starts when the bus is free; the node with the lowest arbitration bits wins."""
    time = VirtualTime()
    bus = EmulatedCanBus(time, 250_000)
    nodes = [CanNode(bus, name, depth=100) for name in "abc"]
    heard: list[tuple[int, CanFrame]] = []
    bus.listen(lambda frame, end: heard.append((end, frame)))
    sends = sorted(sends, key=lambda entry: entry[0])
    for at, node, one in sends:
        time.at(at, lambda node=node, one=one: nodes[node].send((one,)) and None)  # type: ignore[misc]
    while time.next_due < SECOND:
        time.run_next()

    waiting: list[list[CanFrame]] = [[], [], []]
    expected: list[tuple[int, CanFrame]] = []
    queue = list(sends)
    start, bits = 0, 0
    while queue or any(waiting):
        free = start + bits * SECOND // 250_000
        if not any(waiting) and queue[0][0] >= free:
            start, bits = queue[0][0], 0
            free = start
        while queue and queue[0][0] <= free:
            waiting[queue[0][1]].append(queue.pop(0)[2])
        ready = [n for n in range(3) if waiting[n]]
        winner = min(ready, key=lambda n: header(waiting[n][0]))
        one = waiting[winner].pop(0)
        length = len(bits_on_the_wire(one)[0]) + 10
        expected.append((start + (bits + length) * SECOND // 250_000, one))
        bits += length + 3
    assert heard == expected
