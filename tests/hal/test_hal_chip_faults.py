"""Chips with each other's wires, chips whose answers no longer change, sensors that sit turned."""

from __future__ import annotations

import numpy as np
import pytest
from emulated_benches import processor

from boards.sense import Sense, Turned
from hal.emulated.faults import SpiFrozenAnswers, SpiMissingChip, SpiSwappedChips
from hal.emulated.spi import EmulatedSpiBus, EmulatedSpiDevice, SpiTiming

US = 1_000


class Counting:
    """Counts its transactions and says so behind its own letter."""

    def __init__(self, letter: bytes) -> None:
        self.letter = letter
        self.count = 0

    def transaction(self, mosi: bytes | bytearray, start_ns: int, end_ns: int) -> bytes:
        self.count += 1
        return self.letter + bytes((self.count,))


def pair() -> tuple[EmulatedSpiDevice, EmulatedSpiDevice]:
    """Each transaction of two bytes takes 16 µs."""
    bus = EmulatedSpiBus(processor(), SpiTiming(1_000_000))
    return bus.device(Counting(b"a"), "a"), bus.device(Counting(b"b"), "b")


def ask(device: EmulatedSpiDevice, request: bytes = b"\0\0") -> bytes:
    buffer = bytearray(request)
    device.transaction(buffer)
    return bytes(buffer)


def test_two_chips_have_each_others_wires_for_a_while() -> None:
    a, b = pair()
    one, other = (SpiSwappedChips(30 * US, 90 * US) for _ in range(2))
    one.install_with(a, b, other)
    heard = [ask(device) for _ in range(4) for device in (a, b)]
    assert heard == [b"a\1", b"b\1", b"b\2", b"a\2", b"b\3", b"a\3", b"a\4", b"b\4"]
    assert one.fired == other.fired == 2


def test_a_fault_before_the_exchanged_wires_stays_at_its_end() -> None:
    a, b = pair()
    one, other = (SpiSwappedChips(0) for _ in range(2))
    one.install_with(a, b, other)
    SpiMissingChip(0).install(a)
    assert [ask(a), ask(b), ask(b)] == [b"\xff\xff", b"a\1", b"a\2"]


def test_a_chip_is_not_exchanged_with_itself() -> None:
    a, _b = pair()
    with pytest.raises(ValueError, match="itself"):
        SpiSwappedChips(0).install_with(a, a, SpiSwappedChips(0))


def test_each_request_gets_its_first_answer_again() -> None:
    a, _b = pair()
    frozen = SpiFrozenAnswers(10 * US, 90 * US)
    frozen.install(a)
    heard = [ask(a, request) for request in (b"x\0", b"x\0", b"y\0", b"x\0", b"y\0", b"z\0", b"x\0")]
    assert heard == [b"a\1", b"a\2", b"a\3", b"a\2", b"a\3", b"a\6", b"a\7"]
    assert frozen.fired == 2


@pytest.mark.parametrize(("axis", "signs"), [("x", (1, -1, -1)), ("y", (-1, 1, -1)), ("z", (-1, -1, 1))])
def test_a_turned_sensor_shows_the_opposite_on_the_other_two_axes(axis: str, signs: tuple[int, ...]) -> None:
    class World:
        def sample(self, times_ns: np.ndarray, bandwidth_hz: float) -> np.ndarray:
            return np.tile(np.arange(1.0, 8.0), (len(times_ns), 1))

    sense = Sense(World())
    sense.defects.append(Turned(10, 20, ("accel", "gyro", "temperature"), axis))
    before, within, after = sense.sample(np.array([9, 10, 20]), 1.0)
    assert before.tolist() == after.tolist() == [1, 2, 3, 4, 5, 6, 7]
    assert within.tolist() == [*np.multiply(signs, (1, 2, 3)), *np.multiply(signs, (4, 5, 6)), 7]
    with pytest.raises(ValueError, match="'x', 'y' or 'z'"):
        Turned(10, 20, ("accel",))
