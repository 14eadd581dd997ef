"""Words on the wire: the pipeline, bursts, chip select held or toggled, broken transactions, times."""

from __future__ import annotations

from typing import Any

import pytest
from adis16407_rig import MS, START_UP, US, G, Rig, instant
from hypothesis import given, settings
from hypothesis import strategies as some

from boards.chips.registers import ReportKind, UndocumentedAccessError

WORKED = {  # section 4
    "wx": 300.0, "wy": -0.05, "fx": G, "fy": -G, "temperature": 35.0, "pressure": 1000.0,
}  # fmt: skip


def test_worked_values_of_the_sheet() -> None:
    rig = Rig(lambda t: WORKED)
    burst = [word & 0x3FFF for word in rig.burst()]
    assert burst[:6] == [0x814, 0x1770, 0x3FFF, 0, 0x012C, 0x3ED4]
    assert burst[10:13] == [0x30D4, 0x00, 0x04A]


def test_identity_loop_of_the_maker() -> None:
    """DIN 0x5600 repeatedly; from the second word on 0x4017."""
    rig = Rig()
    assert [rig.word(0x5600) for _ in range(4)][1:] == [0x4017] * 3


def test_answers_come_with_the_next_word() -> None:
    rig = Rig()
    answers = [rig.word(address << 8) for address in (0x56, 0x30, 0x38, 0x3A, 0x3C, 0x00)]
    assert answers[1:] == [0x4017, 0x0800, 0x0006, 0x0001, 0x0402]


def test_a_write_answers_nothing_new() -> None:
    rig = Rig()
    rig.word(0x5600)
    assert rig.word(0x9E34) == 0x4017  # the answer to the read before
    assert rig.word(0x1E00) == 0x4017  # undefined: repeated
    assert rig.word(0x0000) == 0x0034


def words_of(data: bytes) -> list[int]:
    return [int.from_bytes(data[k : k + 2], "big") for k in range(0, len(data), 2)]


COMMANDS = some.lists(
    some.sampled_from([0x5600, 0x3800, 0x3C00, 0x1E00, 0x1F00, 0x9E12, 0x9F01, 0xB012, 0x3000, 0x0000]),
    min_size=1,
    max_size=12,
)


@settings(max_examples=60, deadline=None)
@given(COMMANDS, some.lists(some.integers(1, 4), min_size=12, max_size=12))
def test_chip_select_may_be_held_over_any_words(commands: list[int], lengths: list[int]) -> None:
    toggled, held = Rig(), Rig()
    one_by_one = [toggled.word(command) for command in commands]
    together: list[int] = []
    rest = list(commands)
    for length in lengths:
        part, rest = rest[:length], rest[length:]
        if part:
            mosi = b"".join(command.to_bytes(2, "big") for command in part)
            together += words_of(held.spi(mosi, len(part) * 16 * US + (len(part) - 1) * 9 * US))
    assert together == one_by_one[: len(together)]
    assert held.chip.reports == toggled.chip.reports == []


def test_burst_within_a_longer_low_period() -> None:
    rig = Rig()
    mosi = bytes.fromhex("5600 4200") + bytes(28) + bytes.fromhex("3800 0000")
    words = words_of(rig.spi(mosi, 400 * US))
    assert words[1] == 0x4017
    assert [word & 0x3FFF for word in words[2:16]] == [word & 0x3FFF for word in rig.burst()]
    assert words[16] == words[15]  # repeated
    assert words[17] == 0x0006
    assert rig.chip.reports == []


def test_new_data_is_told_once_a_sample_and_register() -> None:
    rig = Rig()
    assert rig.read(0x04) >> 15 == 1
    assert rig.read(0x04) >> 15 == 0
    assert [word >> 15 for word in rig.burst()] == [1, 0] + [1] * 12
    assert not any(word >> 15 for word in rig.burst())
    rig.until(instant(1) - 1)
    assert not any(word >> 15 for word in rig.burst())
    rig.until(instant(2))
    assert all(word >> 15 for word in rig.burst())


def test_a_request_sees_the_register_when_it_is_made() -> None:
    rig = Rig(lambda t: {"temperature": 25.0 + 0.136 * (t >= instant(3) * 1e-9 - 1e-9)})
    rig.until(instant(3) - 100 * US)
    rig.word(0x1A00)
    rig.until(instant(3) + 10 * US)
    assert rig.word(0x1A00) & 0xFFF == 0
    assert rig.word(0x1A00) & 0xFFF == 1


@pytest.mark.parametrize("bytes_sent", [1, 3, 29, 31])
def test_half_words_are_an_spi_error(bytes_sent: int) -> None:
    rig = Rig()
    rig.spi((b"\x42" + bytes(40))[:bytes_sent], 300 * US)
    assert rig.read(0x56) == 0x4017
    assert rig.read(0x04) & 0x4000  # EA
    assert rig.read(0x40) == 0x0008
    assert rig.read(0x40) == 0  # cleared by the read
    assert "no multiple of 16" in str(rig.chip.reports)


@pytest.mark.parametrize("outputs", range(1, 14))
def test_a_burst_cut_short(outputs: int) -> None:
    rig = Rig()
    miso = rig.spi(b"\x42" + bytes(1 + 2 * outputs), 300 * US)
    assert words_of(miso)[1] == 0x8814
    assert [r.detail for r in rig.chip.reports] == [f"burst ended after {outputs} outputs"]
    rest = [word >> 15 for word in rig.burst()]
    assert rest == [0] * outputs + [1] * (14 - outputs)


def test_a_burst_command_alone() -> None:
    rig = Rig()
    rig.word(0x4200)
    assert rig.word(0x0000) == 0
    assert [r.kind for r in rig.chip.reports] == [ReportKind.WRITE_ONLY]


@settings(max_examples=150, deadline=None)
@given(some.lists(some.tuples(some.binary(max_size=40), some.integers(0, 3_000_000)), max_size=20))
def test_nothing_raises_and_lengths_agree(transfers: list[tuple[bytes, int]]) -> None:
    rig = Rig(listen="DIO1 DIO2 DIO3")
    for mosi, pause in transfers:
        rig.spi(mosi)
        rig.wait(pause)
    rig.wait(300 * MS)


def test_nothing_is_answered_before_start_up_is_over() -> None:
    rig = Rig(started=False)
    rig.until(START_UP - 100 * US)
    rig.word(0x9E12)
    assert rig.word(0x5600) == 0
    assert [r.kind for r in rig.chip.reports] == [ReportKind.TIMING]
    rig.until(START_UP)
    rig.word(0x1E00)
    assert rig.word(0x5600) == 0


# -- limits of clock and pauses ------------------------------------------------------------------------


def complaints(mosi: bytes, duration_ns: int, clock_hz: int = 0, period: int = 1) -> set[str]:
    rig = Rig()
    rig.word(0xBA00 | period)
    rig.wait(100 * US)
    if clock_hz:
        rig.chip.clocked_at(clock_hz)
    rig.spi(mosi, duration_ns)
    return {r.detail.split(":")[0] for r in rig.chip.reports}


BURST = b"\x42" + bytes(29)
PAUSE, FAST, FAST_BURST = (
    {"pause between words too short"}, {"clock faster than 2000 kHz"}, {"clock faster than 1000 kHz"},
)  # fmt: skip


@pytest.mark.parametrize(
    ("mosi", "duration_ns", "clock_hz", "expected"),
    [
        (b"\x56\0", 8_000, 2_000_000, set()),
        (b"\x56\0", 7_998, 2_000_100, FAST),
        (b"\x56\0", 8_000, 0, set()),
        (b"\x56\0", 7_900, 0, FAST),
        (b"\x56\0\x56\0", 25_000, 2_000_000, set()),
        (b"\x56\0\x56\0", 24_000, 2_000_000, PAUSE),
        (b"\x56\0\x56\0", 41_000, 1_000_000, set()),
        (b"\x56\0\x56\0", 40_000, 800_000, PAUSE),
        (b"\x56\0\x56\0", 24_000, 0, PAUSE),
        (BURST, 254_000, 1_000_000, set()),
        (BURST, 253_000, 1_000_000, PAUSE),
        (BURST, 254_000, 1_100_000, FAST_BURST),
        (BURST, 254_000, 0, set()),
        (BURST, 253_000, 0, PAUSE),
        (BURST, 239_000, 0, FAST_BURST),
    ],
)
def test_limits(mosi: bytes, duration_ns: int, clock_hz: int, expected: Any) -> None:
    assert complaints(mosi, duration_ns, clock_hz) == expected


@pytest.mark.parametrize(("period", "expected"), [(9, set()), (10, {"clock faster than 300 kHz"})])
@pytest.mark.parametrize("slow_base", [0x00, 0x80])
def test_slow_sampling_wants_a_slow_clock(period: int, expected: set[str], slow_base: int) -> None:
    code = period | slow_base
    wanted = {"clock faster than 300 kHz"} if slow_base else expected
    assert complaints(b"\x56\0", 16_000, 1_000_000, code) == wanted


def test_pause_between_transactions() -> None:
    for pause, reports in ((9_000, 0), (8_999, 1)):
        rig = Rig()
        now = rig.time.now
        rig.chip.transaction(b"\x56\0", now, now + 8_000)
        rig.chip.transaction(b"\x56\0", now + 8_000 + pause, now + 16_000 + pause)
        assert len(rig.chip.reports) == reports
    strict = Rig(strict=True).chip
    strict.transaction(b"\x56\0", START_UP, START_UP + 8_000)
    with pytest.raises(UndocumentedAccessError, match="pause between words"):
        strict.transaction(b"\x56\0", START_UP + 10_000, START_UP + 18_000)
