"""Sets of frames on an idle bus take a short way; nobody on the bus may be able to tell."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.can import CanFrame, CanSet
from hal.emulated.can import CanNode, EmulatedCanBus
from hal.emulated.can_bursts import HeardSets
from hal.emulated.can_frame import LONGEST_FRAME_BITS, ends_of_sets, frame_bits
from hal.emulated.virtual_time import SECOND, VirtualTime
from host.capture.blocks import can_records

MS = 1_000_000
BITRATE = 250_000

FRAMES = st.one_of(
    st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8)),
    st.builds(CanFrame, st.integers(0, 0x1FFF_FFFF), st.binary(max_size=8), st.just(True)),
    st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(min_size=8, max_size=8)),
)
STEPS = st.lists(
    st.tuples(
        st.integers(0, 30 * MS),
        st.sampled_from(["send", "send", "send", "send other", "ask", "disturb", "withdraw"]),
        st.lists(FRAMES, min_size=1, max_size=5).map(tuple),
    ),
    max_size=12,
)


@settings(deadline=None)
@given(
    st.lists(st.integers(0, 0x7FF), min_size=1, max_size=6).map(tuple),
    st.lists(st.binary(min_size=8, max_size=8), min_size=6, max_size=30),
)
def test_ends_of_sets_are_those_of_their_frames(identifiers: tuple[int, ...], data: list[bytes]) -> None:
    sets = len(data) // len(identifiers)
    data = data[: sets * len(identifiers)]
    begins = np.arange(sets) * 10**9
    ends, bits = ends_of_sets(begins, identifiers, b"".join(data), 1000)
    frames = list(map(CanFrame, identifiers * sets, data))
    expected = []
    for first, begin in zip(range(0, len(frames), len(identifiers)), begins.tolist(), strict=True):
        sent = 0
        for frame in frames[first : first + len(identifiers)]:
            expected.append(begin + (sent + frame_bits(frame)) * 10**6)
            sent += frame_bits(frame) + 3
    assert ends.tolist() == expected
    assert bits == sum(frame_bits(frame) + 3 for frame in frames)


def test_longest_frame_is_reached() -> None:
    """Every run of five, then of four equal bits: identifier and data of alternating groups."""
    longest = max(
        frame_bits(CanFrame(identifier, bytes((byte,)) * 8, True))
        for identifier in (0, 0x0783_C3C3, 0x1FFF_FFFF)
        for byte in (0x00, 0x0F, 0x1E, 0x3C, 0x78, 0xF0, 0xE1, 0xC3, 0x87, 0xFF)
    )
    assert longest <= LONGEST_FRAME_BITS
    assert longest > LONGEST_FRAME_BITS - 12


class Bench:
    """Two nodes and a listener, `prompt` (told by events) or late; what it heard and what counters say."""

    def __init__(self, prompt: bool) -> None:
        self.time = VirtualTime()
        self.bus = EmulatedCanBus(self.time, BITRATE)
        self.node = CanNode(self.bus, "node", depth=16)
        self.other = CanNode(self.bus, "other", depth=16)
        self.heard: list[tuple[CanFrame, int]] = []
        self.counters: list[tuple[int, int, int, str]] = []
        self.taken: list[int] = []
        self.late = None if prompt else self.bus.listen_late()
        if prompt:
            self.bus.listen(lambda frame, end: self.heard.append((frame, end)))

    def play(self, steps: list[tuple[int, str, tuple[CanFrame, ...]]]) -> None:
        now = 0
        for wait, what, frames in steps:
            now += wait
            self.time.at(now, lambda what=what, frames=frames: self._do(what, frames))  # type: ignore[misc]
        self.time.at(now + 2 * SECOND, lambda: None)
        while self.time.next_due <= now + 2 * SECOND:
            self.time.run_next()
        self._do("ask", ())

    def run(self, duration_ns: int) -> None:
        """Let time pass."""
        end = self.time.now + duration_ns
        self.time.at(end, lambda: None)
        while self.time.next_due <= end:
            self.time.run_next()

    def _do(self, what: str, frames: tuple[CanFrame, ...]) -> None:
        bus = self.bus
        if what == "send":
            self.taken.append(self.node.send(frames))
        elif what == "send other":
            self.taken.append(self.other.send(frames))
        elif what == "withdraw":
            bus.withdraw(self.node)
        elif what == "disturb":
            bus.begin_disturbance(_nothing)
            self.time.at(self.time.now + MS, lambda: bus.end_disturbance(_nothing))
        else:
            self.counters.append((bus.frames, bus.busy_ns, bus.error_frames, self.node.state))
            if self.late is not None:
                self.heard += [(frame, end) for frame, end, _sender in self.late.take()]


def _nothing() -> None:
    pass


@settings(max_examples=150, deadline=None)
@given(STEPS)
def test_late_listener_hears_what_a_prompt_one_hears(
    steps: list[tuple[int, str, tuple[CanFrame, ...]]],
) -> None:
    prompt, late = Bench(prompt=True), Bench(prompt=False)
    prompt.play(steps)
    late.play(steps)
    assert late.heard == prompt.heard
    assert late.counters == prompt.counters
    assert late.taken == prompt.taken


def test_sets_on_an_idle_bus_cost_no_event() -> None:
    bench = Bench(prompt=False)
    frames = tuple(CanFrame(0x100 + n, bytes(8)) for n in range(5))
    for _ in range(3000):
        assert bench.node.send(frames) == 5
        bench.time.now += 100 * MS
    assert bench.time.events_run == 0
    bench._do("ask", ())
    assert len(bench.heard) == 15_000
    assert bench.bus.frames == 15_000


def test_receiver_that_polls_gets_frames_of_a_kept_set() -> None:
    time = VirtualTime()
    bus = EmulatedCanBus(time, BITRATE)
    sender = CanNode(bus, "sender")
    received: list[tuple[CanFrame, int]] = []

    class Receiver(CanNode):
        def deliver(self, frame: CanFrame, end_ns: int) -> None:
            received.append((frame, end_ns))

    Receiver(bus, "receiver")
    bus.listen_late()
    first, second = CanFrame(1, b"\x55"), CanFrame(2, b"\xaa")
    sender.send((first, second))
    end = frame_bits(first) * SECOND // BITRATE
    time.now = end
    bus.catch_up()
    assert received == [(first, end)]


SETS = st.lists(
    st.tuples(st.integers(0, 40 * MS), st.integers(1, 20), st.binary(min_size=1, max_size=8)), max_size=8
)


@settings(max_examples=40, deadline=None)
@given(SETS)
def test_sets_get_through_like_their_frames(sets: list[tuple[int, int, bytes]]) -> None:
    """Also those that find the bus busy or the queue full."""
    outcomes = []
    for as_set in (True, False):
        bench = Bench(prompt=False)
        for wait, count, pattern in sets:
            whole = CanSet(tuple(range(0x100, 0x100 + count)), (pattern * 160)[: 8 * count])
            frames: Sequence[CanFrame] = whole if as_set else tuple(whole)
            bench.run(wait)
            bench.taken.append(bench.node.send(frames))
        bench.run(SECOND)
        assert bench.late is not None
        outcomes.append((bench.late.take(), bench.taken))
    assert outcomes[0] == outcomes[1]


def test_a_set_needs_eight_bytes_for_each_frame_and_identifiers_of_eleven_bits() -> None:
    with pytest.raises(ValueError, match="a set of 2 CAN frames has 15 data bytes; it needs 8 for each"):
        CanSet((1, 2), bytes(15))
    bench = Bench(prompt=False)
    with pytest.raises(ValueError, match="0x800: a 11-bit one is at most 0x7FF"):
        bench.node.send(CanSet((0x7FF, 0x800), bytes(16)))


@pytest.mark.parametrize("data_seed", [1, 2])
def test_many_sets_worked_out_in_columns_are_their_frames(data_seed: int) -> None:
    identifiers = (0x310, 0x311, 0x7FF, 0x000, 0x555)
    numbers = np.random.default_rng(data_seed)
    outcomes = []
    data = numbers.choice([0x00, 0xFF, 0x5A], (60, 40)).astype(np.uint8)
    sets = [CanSet(identifiers, row.tobytes()) for row in data]
    for as_set in (True, False):
        time = VirtualTime()
        bus = EmulatedCanBus(time, 500_000)
        node, late = CanNode(bus, "board"), bus.listen_late()
        for one in sets:
            time.at(time.now + 100 * MS, lambda: None)
            time.run_next()
            assert node.send(one if as_set else tuple(one)) == 5
        time.at(time.now + 100 * MS, lambda: None)
        time.run_next()
        parts = late.take_parts()
        assert any(isinstance(part, HeardSets) for part in parts) == as_set
        records = b"".join(can_records(part) for part in parts)
        outcomes.append(([frame for part in parts for frame in part], records, bus.frames, bus.busy_ns))
    assert outcomes[0] == outcomes[1]
    assert outcomes[0][0][5][0] == next(iter(sets[1]))
