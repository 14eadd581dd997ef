"""Parts of the board: the ring of output between the processors, the receiver's new sentence and pulse, the
description of what joins processors, profiles."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from boards.chips.dual_antenna import DualAntennaReceiver
from boards.chips.world import BaselineSolution, GnssEpoch
from boards.description import load_board
from boards.validation import DescriptionError
from firmware.apps.dual_antenna import memory_map as at
from firmware.apps.dual_antenna.host_line import HostLine
from firmware.apps.dual_antenna.host_port import HostPort
from firmware.apps.dual_antenna.navigation import nav_config
from firmware.apps.dual_antenna.settings import Settings
from hal.emulated.pins import Net
from hal.emulated.virtual_time import SECOND, VirtualTime


class Memory:
    """Both sides of a memory without time; a ring is heard at once."""

    def __init__(self) -> None:
        self.bytes = bytearray(4 * 4096)
        self.mailbox = 0
        self.hear = lambda: None

    def read(self, address: int, count: int) -> bytes:
        return bytes(self.bytes[4 * address : 4 * (address + count)])

    def write(self, address: int, data: bytes) -> None:
        assert len(data) % 4 == 0
        assert address >= at.OUTPUT_AT or address == at.TAKEN_AT
        assert address + len(data) // 4 <= at.OUTPUT_AT + at.OUTPUT_WORDS
        self.bytes[4 * address : 4 * address + len(data)] = data

    def ring(self, value: int) -> None:
        self.mailbox = value
        self.hear()

    def rung(self) -> int:
        return self.mailbox

    def interrupt_on_ring(self, line: Any) -> None:
        self.hear = line.pend


class Port:
    def __init__(self) -> None:
        self.sent = bytearray()
        self.room = 0

    def tx_free(self) -> int:
        return self.room

    def write(self, data: bytes) -> int:
        assert len(data) <= self.room
        self.room -= len(data)
        self.sent += data
        return len(data)


def pair() -> tuple[Memory, Port, HostLine]:
    memory, port = Memory(), Port()

    def attach(_name: str, handler: Any) -> Any:
        return SimpleNamespace(pend=handler)

    io = SimpleNamespace(
        memories={"exchange": memory},
        uart={"host": port},
        cpu=SimpleNamespace(cost=lambda _work: 1, spend=lambda _cycles: None),
        interrupts=SimpleNamespace(attach=attach),
    )
    return memory, port, HostLine(io)  # type: ignore[arg-type]


@given(st.lists(st.tuples(st.binary(min_size=0, max_size=3000), st.integers(0, 4000)), max_size=60))
def test_pieces_arrive_whole_and_in_order(pieces: list[tuple[bytes, int]]) -> None:
    memory, port, line = pair()
    line.begin()
    writer = HostPort(memory)  # type: ignore[arg-type]
    writer.begin()
    expected = bytearray()
    for data, room in pieces:
        port.room += room
        line.drain()
        free = writer.tx_free()
        taken = writer.write(data)
        assert taken == (len(data) if 0 < len(data) <= free else 0)
        expected += data[:taken]
    port.room = 1 << 20
    line.drain()
    assert port.sent == expected


def test_after_a_reset_of_the_writer_nothing_old_is_said() -> None:
    memory, port, line = pair()
    line.begin()
    writer = HostPort(memory)  # type: ignore[arg-type]
    writer.begin()
    writer.write(b"before")
    again = HostPort(memory)  # type: ignore[arg-type]
    again.begin()
    port.room = 100
    line.drain()
    again.write(b"after")
    assert port.sent == b"after"


def test_after_a_reset_of_the_reader_it_goes_on_with_what_is_new() -> None:
    memory, port, line = pair()
    line.begin()
    writer = HostPort(memory)  # type: ignore[arg-type]
    writer.begin()
    for _ in range(40):
        writer.write(bytes(100))
    port.room = 1 << 20
    other = HostLine(line_io(memory, port))
    other.begin()
    assert writer.tx_free() == at.LONGEST_PIECE
    writer.write(b"new")
    assert port.sent == b"new"


def line_io(memory: Memory, port: Port) -> Any:
    return SimpleNamespace(
        memories={"exchange": memory},
        uart={"host": port},
        cpu=SimpleNamespace(cost=lambda _work: 1, spend=lambda _cycles: None),
        interrupts=SimpleNamespace(attach=lambda _name, handler: SimpleNamespace(pend=handler)),
    )


def epoch_at(time_ns: int, fix: bool) -> GnssEpoch:
    baseline = BaselineSolution("FIXED", 2.0, 0.1, 2.004, 0.001, 0.002, 0.005)
    gps_ns = 1_400_000_000 * SECOND + 18 * SECOND + time_ns - 250_000_000
    return GnssEpoch(
        fix, True, gps_ns, 18, 0.5, 2.0, 40.0, -10.0, (1.0, 2.0, 0.0), 1.5, 2.0, 0.1,
        2.0, 1.0, 1.5, 1.0, (), 80_000_000, baseline,
    )  # fmt: skip


class Line:
    """A transmit line that keeps what is sent."""

    def __init__(self) -> None:
        self.sent = bytearray()
        self.queued = 0

    def set_baud(self, baud: int) -> None:
        pass

    def send(self, data: bytes) -> int:
        self.sent += data
        return len(data)

    def abort(self) -> None:
        pass


class World:
    """Fixed from the first second on, none between 6 and 8 s."""

    def epoch(self, time_ns: int) -> GnssEpoch:
        return epoch_at(time_ns, not 6 * SECOND <= time_ns < 8 * SECOND)


def receiver_run(seconds: int) -> tuple[bytes, list[int]]:
    time, line = VirtualTime(), Line()
    receiver = DualAntennaReceiver(time, World(), line, sentences=["PTNL,AVR"], baud=115_200)  # type: ignore[arg-type]
    net = Net(time, "PPS")
    rises: list[int] = []
    net.listen(lambda level, time_ns: rises.append(time_ns) if level else None)
    receiver.pins["PPS"] = net
    while time.heap[0][0] < seconds * SECOND:
        time.run_next()
    return bytes(line.sent), rises


def test_the_pulse_marks_the_top_of_the_second_while_there_is_a_fix() -> None:
    _, rises = receiver_run(12)
    tops = [k * SECOND + 250_000_000 for k in range(12)]
    expected = [t for t in tops if 2 * SECOND < t < 12 * SECOND and not 6.3 * SECOND < t < 8.3 * SECOND]
    assert [t for t in rises if t > 2.5 * SECOND] == [t for t in expected if t > 2.5 * SECOND]


def test_avr_tells_heading_tilt_and_length() -> None:
    from pynmeagps import NMEAReader

    sent, _ = receiver_run(20)
    sentences = [part for part in sent.split(b"\r\n") if part.startswith(b"$PTNL,AVR")]
    fields = sentences[-1].split(b"*")[0].split(b",")
    assert fields[3:8] == [b"+114.5916", b"Yaw", b"+5.7296", b"Tilt", b""]
    assert fields[9:11] == [b"2.004", b"3"]
    assert sentences[0].split(b",")[10] == b"0", "no ambiguities yet"
    for one in sentences:
        NMEAReader.parse(one + b"\r\n", validate=1, msgmode=0)


def broken(edit: dict[str, Any]) -> str:
    def change(data: dict[str, Any]) -> dict[str, Any]:
        data["interconnects"]["exchange"].update(edit)
        return data

    with pytest.raises(DescriptionError) as told:
        load_board("dual_antenna", change)
    return str(told.value)


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        ({"kind": "spi"}, "dual-port"),
        ({"words": 0}, "words"),
        ({"word_bits": 24}, "word_bits"),
        ({"ends": {"dsp": {"access_ns": 20}}}, "joins two"),
        ({"ends": {"dsp": {"access_ns": 20}, "mcu": {"access_ns": 20}}}, "mcu"),
        ({"ends": {"dsp": {"access_ns": 0}, "fpga": {"access_ns": 20}}}, "access_ns"),
        ({"speed": 5}, "speed"),
    ],
)
def test_wrong_interconnects_are_told(edit: dict[str, Any], words: str) -> None:
    message = broken(edit)
    assert re.search(words, message), message
    assert "board.toml" in message


@pytest.mark.parametrize(
    ("second", "words"),
    [
        (None, "one antenna"),
        ([-0.9, 0.0, -3.2], "lies above or below"),
        ([-0.85, 0.05, -1.2], "above or below"),
    ],
)
def test_antennas_that_make_no_baseline_are_told(second: list[float] | None, words: str) -> None:
    receiver = {"lever_arm_m": [-0.9, 0.0, -1.2]} | ({} if second is None else {"second_antenna_m": second})
    imu = {"lever_arm_m": [0.0, 0.0, 0.0], "C_b_s": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    with pytest.raises(ValueError, match=words):
        nav_config(Settings(), {"imu": imu, "gnss": receiver})


@pytest.mark.parametrize(
    ("profile", "words"),
    [
        ({"precision": "fixed"}, "precision"),
        ({"gyro_compass_s": 10.0}, "60"),
        ({"gyro_compass_s": True}, "gyro_compass_s"),
        ({"antenna": 1}, "unknown"),
        ({"output_rate_hz": 3}, "output_rate_hz"),
    ],
)
def test_impossible_profiles_are_told(profile: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Settings.of(profile)
