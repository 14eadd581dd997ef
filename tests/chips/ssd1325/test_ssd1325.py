"""The display as drivers use it: initialisation, windows, pictures, mirroring; and keys that bounce."""

import numpy as np
import pytest

from boards.chips.registers import ReportKind
from boards.chips.ssd1325 import Keypad, Ssd1325
from hal.emulated.pins import Net
from hal.emulated.virtual_time import VirtualTime

SETTING_UP = bytes(
    (0xAE, 0xB3, 0x91, 0xA8, 0x3F, 0xA2, 0x4C, 0xA1, 0x00, 0xAD, 0x02, 0xA0, 0x50, 0x86,
     0xB8, 0x01, 0x11, 0x22, 0x32, 0x43, 0x54, 0x65, 0x76, 0x81, 0x7F, 0xB2, 0x51, 0xB1, 0x55, 0xB4, 0x02,
     0xB0, 0x28, 0xBC, 0x1C, 0xBE, 0x0F, 0xBF, 0x02, 0xA4, 0xAF)
)  # fmt: skip
"""As an Arduino library sets a 128 × 64 panel up."""


UPRIGHT = 0x50
"""Re-map with which libraries have the picture upright, together with the offset 0x4C; left pixel low."""


class Rig:
    def __init__(self) -> None:
        self.time = VirtualTime()
        self.display = Ssd1325(self.time)
        self.dc = Net(self.time, "DC")
        self.display.pins["DC"] = self.dc

    def command(self, *values: int) -> None:
        self.dc.set(False)
        self.display.transaction(bytes(values), 0, len(values) * 800)

    def data(self, values: bytes) -> None:
        self.dc.set(True)
        self.display.transaction(values, 0, len(values) * 800)


@pytest.fixture
def rig() -> Rig:
    made = Rig()
    made.command(0xA8, 63, 0xA0, UPRIGHT, 0xA2, 0x4C, 0xAF)
    return made


def test_a_libraries_setting_up_is_understood() -> None:
    made = Rig()
    made.command(*SETTING_UP)
    assert made.display.reports == []
    assert made.display.contrast == 0x7F
    made.command(0xA5)
    assert np.all(made.display.picture() == 15)


def test_a_picture_is_seen_as_it_was_written(rig: Rig) -> None:
    wanted = np.random.default_rng(1).integers(0, 16, (64, 128), np.uint8)
    packed = wanted[:, 0::2] | wanted[:, 1::2] << 4
    rig.command(0x15, 0, 63, 0x75, 0, 63)
    rig.data(packed.tobytes())
    assert np.array_equal(rig.display.picture(), wanted)
    rig.command(0xA0, UPRIGHT | 0x02)
    assert np.array_equal(rig.display.picture()[:, 0::2], wanted[:, 1::2])
    rig.command(0xA0, UPRIGHT | 0x03)
    assert np.array_equal(rig.display.picture(), wanted[:, ::-1])
    rig.command(0xA0, UPRIGHT, 0xA7)
    assert np.array_equal(rig.display.picture(), 15 - wanted)
    rig.command(0xA4, 0xA1, 5)
    assert np.array_equal(rig.display.picture()[:59], wanted[5:])
    rig.command(0xAE)
    assert not rig.display.picture().any()


@pytest.mark.parametrize(
    ("first_common", "upright", "turned", "rows_down"),
    [(75, (0x52, 0x4C), (0x41, 0x4C), 8), (63, (0x52, 0x40), (0x41, 0x50), 0)],
)
def test_two_panels_are_turned_by_half_as_a_library_turns_them(
    first_common: int, upright: tuple[int, int], turned: tuple[int, int], rows_down: int
) -> None:
    """Re-map and offset of two glasses as u8g2 sets them; turned, it draws `rows_down` further down."""
    made = Rig()
    made.display = Ssd1325(made.time, first_common=first_common)
    made.display.pins["DC"] = made.dc
    wanted = np.random.default_rng(2).integers(0, 16, (64, 128), np.uint8)
    packed = (wanted[:, 0::2] << 4 | wanted[:, 1::2]).tobytes()
    made.command(0xA8, 63, 0xA0, upright[0], 0xA2, upright[1], 0xAF, 0x15, 0, 63, 0x75, 0, 63)
    made.data(packed)
    assert np.array_equal(made.display.picture(), wanted)
    made.command(0xA0, turned[0], 0xA2, turned[1], 0x75, rows_down, rows_down + 63)
    made.data(packed)
    assert np.array_equal(made.display.picture(), wanted[::-1, ::-1])


def test_a_window_is_filled_row_by_row_and_begins_again(rig: Rig) -> None:
    rig.command(0x15, 10, 11, 0x75, 20, 21)
    rig.data(bytes((0x11, 0x22, 0x33, 0x44, 0x55)))
    picture = rig.display.picture()
    assert picture[20, 20:24].tolist() == [5, 5, 2, 2]
    assert picture[21, 20:24].tolist() == [3, 3, 4, 4]
    assert np.count_nonzero(picture) == 8
    rig.command(0xA0, UPRIGHT | 0x04, 0x15, 0, 1, 0x75, 0, 1)
    rig.data(bytes((0x01, 0x02, 0x03)))
    assert rig.display.picture()[0:2, [0, 2]].tolist() == [[1, 3], [2, 0]]


def test_rectangles_and_text(rig: Rig) -> None:
    rig.command(0x23, 1, 0x24, 1, 2, 3, 4, 0xFF)
    lines = rig.display.as_text().splitlines()
    assert len(lines) == 64
    assert lines[2] == ".." + "#" * 6 + "." * 120
    assert lines[5] == "." * 128
    rig.command(0x23, 0, 0x24, 10, 10, 20, 20, 0x88)
    assert rig.display.picture()[15, 30] == 0
    assert rig.display.picture()[10, 30] == 8


def test_arguments_may_come_in_another_transfer(rig: Rig) -> None:
    rig.command(0x15)
    rig.command(5)
    rig.command(6)
    rig.data(b"\xff")
    assert rig.display.picture()[0, 10:12].tolist() == [15, 15]


@pytest.mark.parametrize(
    ("bytes_", "kind"),
    [
        ((0x01,), ReportKind.UNDOCUMENTED_ADDRESS),
        ((0x15, 9, 3), ReportKind.RESERVED_VALUE),
        ((0x75, 0, 80), ReportKind.RESERVED_VALUE),
        ((0x25, 0, 0, 1, 1, 2, 2), ReportKind.NOT_MODELLED),
    ],
)
def test_what_is_not_in_the_table_is_told(rig: Rig, bytes_: tuple[int, ...], kind: ReportKind) -> None:
    rig.command(*bytes_)
    assert [one.kind for one in rig.display.reports] == [kind]


def test_a_clock_that_is_too_fast_is_told(rig: Rig) -> None:
    rig.display.transaction(b"\xe3" * 4, 0, 4 * 400)
    assert [one.kind for one in rig.display.reports] == [ReportKind.TIMING]


def test_reset_and_supply_clear_all(rig: Rig) -> None:
    rig.command(0xA5)
    reset = Net(rig.time, "RES", level=False)
    rig.display.pins["RES"] = reset
    rig.command(0xE3)
    assert not rig.display.picture().any()
    reset.set(True)
    rig.command(0xAF, 0xA5)
    assert rig.display.picture().all()
    rig.display.power(False)
    rig.command(0xAF, 0xA5)
    rig.display.power(True)
    assert not rig.display.picture().any()


def test_keys_bounce_and_settle() -> None:
    time = VirtualTime()
    pad = Keypad(time)
    net = Net(time, "OK")
    pad.pins["OK"] = net
    pad.wired()
    assert net.level
    changes: list[bool] = []
    net.listen(lambda level, _time_ns: changes.append(level))
    pad.press("OK")
    for _ in range(6):
        time.run_next()
    assert changes == [False, True, False, True, False, True, False]
    assert pad.held == {"OK"}
    pad.release("OK")
    for _ in range(6):
        time.run_next()
    assert net.level
    with pytest.raises(ValueError, match="there is no key 'ENTER'"):
        pad.press("ENTER")
