"""Dual-port memory between two processors: exact access times, words met under way, interrupts, resets."""

from __future__ import annotations

from collections.abc import Callable
from io import StringIO

import pytest
from hypothesis import given
from hypothesis import strategies as st

from boards.machine import Machine
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.dual_port import EmulatedDualPort
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.virtual_time import VirtualTime
from hal.scripted import ScriptedCpu, ScriptedDualPort, Transcript
from hal.scripted.recording import Recording

US = 1_000
FPGA_NS, DSP_NS = 20, 30
ENTRY_NS = 120
WORDS = 32


class Pair:
    """An FPGA (works the queue off) and a DSP at 100 MHz with a memory of 32-bit words between them."""

    def __init__(self) -> None:
        self.time = VirtualTime()
        self.machine = Machine(self.time)
        lines = (LineSpec("ring", 1), LineSpec("task", 2))
        self.fpga = EmulatedCpu(self.time, "fpga", 100_000_000, lines)
        self.dsp = EmulatedCpu(self.time, "dsp", 100_000_000, lines)
        self.memory = EmulatedDualPort("emif", WORDS)
        self.at_fpga = self.memory.side(self.fpga, FPGA_NS)
        self.at_dsp = self.memory.side(self.dsp, DSP_NS)

    def run(self, fpga: Callable[[], None], dsp: Callable[[], None], until: int = 100 * US) -> None:
        self.machine.add(self.fpga, fpga)
        self.machine.add(self.dsp, dsp)
        self.machine.run_until(until)
        self.machine.power_off()


def words(*values: int) -> bytes:
    return b"".join(value.to_bytes(4, "little") for value in values)


def test_accesses_take_their_side_s_time() -> None:
    pair = Pair()
    seen: dict[str, int] = {}

    def fpga() -> None:
        pair.at_fpga.write(0, words(*range(7)))
        seen["written"] = pair.time.now
        pair.at_fpga.ring(5)
        seen["rung"] = pair.time.now

    def dsp() -> None:
        pair.dsp.spend(1000)
        begin = pair.time.now
        pair.at_dsp.read(0, 7)
        seen["read"] = pair.time.now - begin

    pair.run(fpga, dsp)
    assert seen == {"written": 7 * FPGA_NS, "rung": 8 * FPGA_NS, "read": 7 * DSP_NS}
    assert (pair.at_fpga.transactions, pair.at_fpga.accesses, pair.at_fpga.busy_ns) == (2, 8, 8 * FPGA_NS)
    assert pair.at_dsp.busy_ns == 7 * DSP_NS


def test_a_ring_interrupts_the_other_processor_at_once() -> None:
    """Whichever works the queue off; each way 12 cycles of interrupt entry and one access to the mailbox."""
    for ringer in ("fpga", "dsp"):
        pair = Pair()
        near, far = (pair.at_fpga, pair.at_dsp) if ringer == "fpga" else (pair.at_dsp, pair.at_fpga)
        cpus = {"fpga": pair.fpga, "dsp": pair.dsp}
        other = next(cpu for name, cpu in cpus.items() if name != ringer)
        heard: list[tuple[int, int]] = []

        def ring(near=near, cpu=cpus[ringer]) -> None:  # type: ignore[no-untyped-def]
            cpu.delay(10 * US)
            near.ring(9)

        def hear(pair=pair, far=far, other=other, heard=heard) -> None:  # type: ignore[no-untyped-def]
            line = other.attach("ring", lambda: heard.append((pair.time.now, far.rung())))
            far.interrupt_on_ring(line)
            while True:
                other.wait_for_interrupt()

        pair.run(*((ring, hear) if ringer == "fpga" else (hear, ring)))
        access = FPGA_NS if ringer == "fpga" else DSP_NS
        assert heard == [(10 * US + access + ENTRY_NS, 9)], ringer


@given(
    st.lists(st.tuples(st.integers(0, 600), st.integers(0, 20), st.integers(1, 10)), min_size=1, max_size=5),
    st.lists(st.tuples(st.integers(0, 600), st.integers(0, 20), st.integers(1, 10)), min_size=1, max_size=5),
)
def test_words_met_under_way(writes: list[tuple[int, int, int]], reads: list[tuple[int, int, int]]) -> None:
    """Against a list of (end of access, word, value): a word read is the latest whose write had ended."""
    pair = Pair()
    changes: list[tuple[int, int, int]] = []
    found: list[tuple[int, int, bytes]] = []

    def fpga() -> None:
        for number, (pause, address, count) in enumerate(writes, 1):
            pair.fpga.delay(pause)
            start = pair.time.now
            values = [100 * number + k for k in range(count)]
            changes.extend((start + (k + 1) * FPGA_NS, address + k, values[k]) for k in range(count))
            pair.at_fpga.write(address, words(*values))

    def dsp() -> None:
        for pause, address, count in reads:
            pair.dsp.delay(pause)
            start = pair.time.now
            data = pair.at_dsp.read(address, count)
            found.append((start, address, data))

    pair.run(fpga, dsp)
    assert len(found) == len(reads)
    for start, address, data in found:
        for k in range(len(data) // 4):
            at = start + (k + 1) * DSP_NS
            before = [value for end, word, value in changes if word == address + k and end <= at]
            expected = before[-1] if before else 0
            assert int.from_bytes(data[4 * k : 4 * k + 4], "little") == expected, (start, address, k)
    assert not pair.memory.under_way


def test_a_handler_waits_for_the_access_it_came_into() -> None:
    pair = Pair()
    seen: list[tuple[str, int]] = []

    def dsp() -> None:
        def on_ring() -> None:
            pair.at_dsp.read(0, 1)
            seen.append(("handler", pair.time.now))

        pair.at_dsp.interrupt_on_ring(pair.dsp.attach("ring", on_ring))
        pair.dsp.delay(US - pair.time.now)
        pair.at_dsp.read(0, 10)
        seen.append(("thread", pair.time.now))

    def fpga() -> None:
        pair.fpga.delay(US + 50)
        pair.at_fpga.ring(1)

    pair.run(fpga, dsp)
    assert seen == [("handler", US + 11 * DSP_NS), ("thread", US + 11 * DSP_NS)]


def test_a_reset_breaks_a_write_off() -> None:
    pair = Pair()
    boots: list[int] = []

    def fpga() -> None:
        boots.append(pair.time.now)
        if len(boots) == 1:
            pair.fpga.delay(US)
            pair.at_fpga.write(0, words(*range(1, 21)))

    pair.time.at(US + 2 * FPGA_NS + 5, lambda: pair.fpga.reset("test"))
    pair.run(fpga, pair.dsp.wait_for_interrupt)
    assert boots == [0, US + 2 * FPGA_NS + 5 + ENTRY_NS], "a reset takes an interrupt's entry"
    assert pair.memory.get(0, 20) == words(*range(1, 9), *(0,) * 12)


def test_a_processor_that_was_reset_is_not_interrupted() -> None:
    pair = Pair()
    rings: list[int] = []
    boots: list[int] = []
    mailbox: list[int] = []

    def dsp() -> None:
        boots.append(pair.time.now)
        line = pair.dsp.attach("ring", lambda: rings.append(pair.time.now))
        if len(boots) == 1:
            pair.at_dsp.interrupt_on_ring(line)
        pair.dsp.delay(50 * US)
        mailbox.append(pair.at_dsp.rung())

    def fpga() -> None:
        for _ in range(3):
            pair.fpga.delay(10 * US)
            pair.at_fpga.ring(int(pair.time.now > 25 * US))

    pair.time.at(15 * US, lambda: pair.dsp.reset("test"))
    pair.run(fpga, dsp)
    assert len(boots) == 2
    assert len(rings) == 1
    assert mailbox == [1], "the mailbox works on"


def test_a_recording_is_a_transcript() -> None:
    pair = Pair()
    file = StringIO()
    side = Recording(file).memory("emif", pair.at_dsp)

    def driver(side, fpga_rings: Callable[[], None]) -> list[object]:  # type: ignore[no-untyped-def]
        side.write(3, words(7, 8))
        fpga_rings()
        heard = side.rung()
        side.ring(2)
        return [heard, side.read(3, 2)]

    told = driver(side, lambda: pair.at_fpga.ring(12))
    with Transcript(file.getvalue()) as transcript:
        scripted = ScriptedDualPort(transcript, "emif", WORDS)
        scripted.interrupt_on_ring(ScriptedCpu(transcript).attach("ring", lambda: None))
        assert driver(scripted, lambda: None) == told == [12, words(7, 8)]


def test_wrong_transcripts_are_told() -> None:
    with pytest.raises(ValueError, match="answers 3 bytes to 1 words"):
        ScriptedDualPort(Transcript("memory m read 0 1 -> 01 02 03"), "m", 4).read(0, 1)
    with pytest.raises(ValueError, match="for example '<- memory emif ring 5'"):
        ScriptedDualPort(Transcript("<- memory m ring five"), "m", 4).rung()


@pytest.mark.parametrize(("words_", "width"), [(0, 4), (8, 3), (-1, 2)])
def test_impossible_memories(words_: int, width: int) -> None:
    with pytest.raises(ValueError, match="words have 2 or 4"):
        EmulatedDualPort("m", words_, width)


def test_two_sides_only() -> None:
    pair = Pair()
    with pytest.raises(ValueError, match="two sides already"):
        pair.memory.side(pair.dsp, 10)
