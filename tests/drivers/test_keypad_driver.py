"""The keypad driver on contacts that bounce."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from boards.chips.ssd1325 import Keypad as KeypadModel
from firmware.drivers.keypad import KEYS, WAITING_LIMIT, Keypad
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.pins import EmulatedInputPin, Net
from hal.emulated.virtual_time import VirtualTime

MS = 1_000_000
LOOK_NS = 5 * MS


class Board:
    """Keys, their nets, and a driver that looks 200 times a second."""

    def __init__(self, held_at_first: tuple[str, ...] = (), bounces: int = 3) -> None:
        self.time = VirtualTime()
        cpu = EmulatedCpu(self.time, "fpga", 70_000_000)
        self.keys = KeypadModel(self.time, bounces=bounces)
        nets = {key: Net(self.time, key) for key in KEYS}
        self.keys.pins |= nets
        self.keys.wired()
        for key in held_at_first:
            self.keys.press(key)
        self.pad = Keypad({key: EmulatedInputPin(cpu, net) for key, net in nets.items()}, 200)
        self.cpu = cpu
        self.heard: list[str] = []

    def wait(self, ms: float, listen: bool = True) -> None:
        end = self.time.now + round(ms * MS)
        while self.time.now < end:
            self.cpu.wait_until(min(end, self.time.now + LOOK_NS))
            self.pad.scan()
            while listen and (key := self.pad.take()) is not None:
                self.heard.append(key)

    def press(self, key: str, held_ms: float) -> None:
        self.keys.press(key)
        self.wait(held_ms)
        self.keys.release(key)


@settings(deadline=None)
@given(
    some.lists(
        some.tuples(some.sampled_from(KEYS), some.integers(25, 400), some.integers(25, 80)), max_size=8
    )
)
def test_each_press_is_one_word_however_the_contacts_bounce(presses: list[tuple[str, int, int]]) -> None:
    board = Board()
    for key, held_ms, pause_ms in presses:
        board.press(key, held_ms)
        board.wait(pause_ms)
    assert board.heard == [key for key, _, _ in presses]


@pytest.mark.parametrize(("key", "words"), [("UP", 1 + 10), ("DOWN", 1 + 10), ("OK", 1), ("LEFT", 1)])
def test_arrows_repeat_while_they_are_held(key: str, words: int) -> None:
    """First after 0.6 s, then every 0.1 s: ten times by 1.55 s."""
    board = Board()
    board.press(key, 1550)
    board.wait(50)
    assert board.heard == [key] * words


def test_a_glimpse_is_no_press() -> None:
    board = Board(bounces=0)
    for _ in range(20):
        board.press("OK", 4)
        board.wait(16)
    assert board.heard == []


def test_a_key_that_is_held_for_ever_is_stuck_until_it_is_let_go() -> None:
    board = Board()
    board.keys.press("BACK")
    board.wait(14_000)
    assert board.pad.stuck == ()
    board.wait(1_100)
    assert board.pad.stuck == ("BACK",)
    board.press("OK", 100)
    board.wait(100)
    board.keys.release("BACK")
    board.wait(100)
    assert board.pad.stuck == ()
    board.press("BACK", 100)
    assert board.heard == ["BACK", "OK", "BACK"]


def test_a_key_that_is_low_at_power_up_says_nothing() -> None:
    board = Board(held_at_first=("UP",))
    board.wait(3_000)
    assert board.heard == []
    assert board.pad.stuck == ("UP",)
    board.press("DOWN", 100)
    board.wait(50)
    board.keys.release("UP")
    board.wait(50)
    board.press("UP", 100)
    assert board.heard == ["DOWN", "UP"]


def test_words_that_nobody_takes_are_counted() -> None:
    board = Board()
    for _ in range(WAITING_LIMIT + 3):
        board.keys.press("OK")
        board.wait(30, listen=False)
        board.keys.release("OK")
        board.wait(30, listen=False)
    assert board.pad.dropped == 3
    board.wait(5)
    assert board.heard == ["OK"] * WAITING_LIMIT
