"""The command table of the fact sheet, one by one: response, delay, what comes of breaking it."""

from __future__ import annotations

import pytest
from hmc6343_rig import ADDRESS, MS, US, BenchWorld, G, Rig

from boards.chips.hmc6343 import Hmc6343
from boards.chips.registers import ReportKind, UndocumentedAccessError
from hal.emulated.virtual_time import VirtualTime
from hal.errors import BusError, ErrorKind

TABLE = """
| 0x40 | - | 6 bytes | 1 ms |
| 0x45 | - | 6 bytes | 1 ms |
| 0x50 | - | 6 bytes | 1 ms |
| 0x55 | - | 6 bytes | 1 ms |
| 0x65 | - | 1 byte | 1 ms |
| 0x71 | - | - | 0.3 ms |
| 0x72 | - | - | 0.3 ms |
| 0x73 | - | - | 0.3 ms |
| 0x74 | - | - | 0.3 ms |
| 0x75 | - | - | 0.3 ms |
| 0x76 | - | - | 0.3 ms |
| 0x83 | - | - | 1 ms |
| 0xE1 | 00 | 1 byte | 10 ms |
| 0xF1 | 14 03 | - | 10 ms |
"""
"""Section 3: command, arguments, response, delay."""
_ROWS = [[cell.strip() for cell in line.split("|")[1:5]] for line in TABLE.split("\n") if line]
COMMANDS = [
    (
        bytes.fromhex(command[2:] + ("" if arguments == "-" else arguments)),
        0 if response == "-" else int(response.split()[0]),
        round(float(delay.split()[0]) * MS),
    )
    for command, arguments, response, delay in _ROWS
]
RESPONDING = [row for row in COMMANDS if row[1]]


@pytest.mark.parametrize(("command", "length", "delay_ns"), COMMANDS)
def test_the_next_command_may_come_after_the_delay(command: bytes, length: int, delay_ns: int) -> None:
    rig = Rig()
    rig.start()
    rig.bus.transaction(ADDRESS, command)
    rig.wait(delay_ns - 190 * US)  # address and command take 190 µs
    rig.bus.transaction(ADDRESS, b"\x84")
    assert rig.details == []


@pytest.mark.parametrize(("command", "length", "delay_ns"), COMMANDS)
def test_a_command_within_the_delay_is_lost(command: bytes, length: int, delay_ns: int) -> None:
    rig = Rig()
    rig.start()
    rig.bus.transaction(ADDRESS, command)
    rig.wait(delay_ns - 220 * US)
    rig.bus.transaction(ADDRESS, b"\x82")
    assert rig.details == ["command within the delay of the last one: lost"]
    rig.bus.transaction(ADDRESS)  # still there: it was not reset


@pytest.mark.parametrize(("command", "length", "delay_ns"), RESPONDING)
def test_response_length(command: bytes, length: int, delay_ns: int) -> None:
    rig = Rig()
    rig.start()
    answer = rig.ask(*command, length=length, delay_ns=delay_ns)
    assert len(answer) == length
    assert rig.details == []
    assert rig.bus.transaction(ADDRESS, b"", length + 2) == answer + b"\xff\xff"
    assert rig.details == ["read of more than the response: undefined"]


@pytest.mark.parametrize(("command", "length", "delay_ns"), RESPONDING)
def test_reading_early_shows_the_response_before(command: bytes, length: int, delay_ns: int) -> None:
    rig = Rig()
    rig.start()
    before = rig.ask(0x40)
    rig.bus.transaction(ADDRESS, command)
    rig.wait(delay_ns - 150 * US)
    assert rig.bus.transaction(ADDRESS, b"", length) == before[:length]
    assert rig.details == ["read within the delay of the command: undefined"]


def test_reading_early_as_a_fault_gives_an_idle_bus() -> None:
    rig = Rig(early="nack")
    rig.start()
    rig.bus.transaction(ADDRESS, b"\x50")
    assert rig.bus.transaction(ADDRESS, b"", 2) == b"\xff\xff"
    with pytest.raises(BusError) as caught:
        rig.bus.transaction(ADDRESS, b"\x40")
    assert caught.value.kind is ErrorKind.DATA_NACK


def test_no_answer_for_500_ms_after_power_up_and_reset() -> None:
    rig = Rig()
    for begin_ns in (0, None):
        if begin_ns is None:
            rig.bus.transaction(ADDRESS, b"\x82")
            begin_ns = rig.time.now - 10 * US  # the stop behind the last byte
        rig.until(begin_ns + 500 * MS - 105 * US)
        with pytest.raises(BusError) as caught:
            rig.bus.transaction(ADDRESS)
        assert caught.value.kind is ErrorKind.ADDRESS_NACK
        rig.until(begin_ns + 500 * MS)
        rig.bus.transaction(ADDRESS)


def test_unknown_commands_are_ignored() -> None:
    rig = Rig()
    rig.start()
    known = {row[0][0] for row in COMMANDS} | {0x70, 0x7E, 0x7F, 0x82, 0x84}
    unknown = sorted(set(range(256)) - known)
    for command in unknown:
        rig.command(command)
        assert rig.bus.transaction(ADDRESS, b"", 1) == b"\xff"
    told = [detail for detail in rig.details if detail.startswith("unknown")]
    assert told == [f"unknown command 0x{command:02X}: ignored" for command in unknown]
    assert rig.words(0x50)[0] == 300


@pytest.mark.parametrize(
    "data", [b"\xe1", b"\xf1", b"\xf1\x14", b"\xe1\x14\x00", b"\x50\x00", b"\xf1\x14\x00\x00"]
)
def test_wrong_number_of_arguments(data: bytes) -> None:
    rig = Rig()
    rig.start()
    rig.bus.transaction(ADDRESS, data)
    assert len(rig.details) == 1
    assert "arguments instead of" in rig.details[0]
    assert rig.peek(0x14) == 0


def test_another_address_is_not_acknowledged() -> None:
    rig = Rig()
    rig.start()
    with pytest.raises(BusError) as caught:
        rig.bus.transaction(0x32 >> 2, b"\x50")
    assert caught.value.kind is ErrorKind.ADDRESS_NACK


@pytest.mark.parametrize(("frequency_hz", "reported"), [(50_000, False), (100_000, False), (400_000, True)])
def test_clock_limit(frequency_hz: int, reported: bool) -> None:
    rig = Rig(frequency_hz=frequency_hz)
    rig.start()
    assert rig.words(0x50)[0] == 300
    assert bool(rig.details) is reported


def test_full_cycle_takes_what_the_sheet_says() -> None:
    """0.2 ms, 1 ms of waiting, 0.65 ms."""
    rig = Rig()
    rig.start()
    begin = rig.time.now
    rig.ask(0x50)
    assert 1.8 * MS < rig.time.now - begin < 2.0 * MS


def test_repeated_start_reads_at_once_and_too_early() -> None:
    rig = Rig()
    rig.start()
    rig.ask(0x50)
    assert len(rig.bus.transaction(ADDRESS, b"\x40", 6)) == 6
    assert rig.chip.reports[0].kind is ReportKind.TIMING


def test_without_supply() -> None:
    rig = Rig()
    rig.start()
    rig.chip.power(False)
    with pytest.raises(BusError):
        rig.bus.transaction(ADDRESS, b"\x50")
    rig.chip.power(True)
    rig.wait(501 * MS)
    assert rig.words(0x50)[0] == 300


def test_strict_mode_and_parameters() -> None:
    rig = Rig(strict=True)
    rig.start()
    with pytest.raises(UndocumentedAccessError, match="unknown command 0x00"):
        rig.bus.transaction(ADDRESS, b"\x00")
    world = BenchWorld(lambda t: (0, 0, 0))
    for options in ({"early": "late"}, {"serial_number": 70_000}):
        with pytest.raises(ValueError, match=next(iter(options))):
            Hmc6343(VirtualTime(), world, **options)  # type: ignore[arg-type]


def test_accelerometer_and_temperature_words() -> None:
    rig = Rig()
    rig.world.temperature = -12.34
    rig.start()
    assert rig.words(0x40) == [0, 0, 1024]
    assert rig.words(0x55) == [0, 0, -123]
    assert pytest.approx(9.80665) == G
