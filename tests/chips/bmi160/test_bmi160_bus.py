"""Both bus faces: protocol choice, addressing, bursts (fact sheet section 1)."""

from __future__ import annotations

import pytest
from bmi160_rig import BYTE_NS, MS, Rig

from boards.chips.registers import ReportKind, UndocumentedAccessError


def kinds(rig: Rig) -> list[ReportKind]:
    return [report.kind for report in rig.chip.reports]


def powered(**options: object) -> Rig:
    rig = Rig(**options)  # type: ignore[arg-type]
    rig.until(10 * MS)
    return rig


def test_first_spi_access_after_power_up_is_lost() -> None:
    rig = powered()
    assert rig.read(0x00) == b"\x00"
    assert rig.read(0x00) == b"\xd1"


def test_write_before_the_first_rising_edge_is_lost() -> None:
    rig = powered()
    rig.write(0x40, 0x26)
    assert rig.read(0x40) == b"\x28"


def test_soft_reset_returns_to_protocol_detection() -> None:
    rig = powered()
    rig.read(0x7F)
    assert rig.chip.i2c.write(b"\x00", rig.time.now) == 0
    rig.write(0x7E, 0xB6, gap_ns=1 * MS)
    assert rig.chip.i2c.write(b"\x00", rig.time.now) == 1
    assert rig.chip.i2c.read(1, rig.time.now) == b"\xd1"
    assert rig.read(0x00) == b"\x00"
    assert rig.read(0x00) == b"\xd1"


def test_soft_reset_takes_one_millisecond() -> None:
    rig = powered()
    rig.read(0x7F)
    rig.write(0x7E, 0xB6, gap_ns=0)
    done = rig.time.now + 1 * MS
    rig.until(done - 2 * BYTE_NS - 1)
    assert rig.read(0x7F) == b"\xff"
    assert rig.chip.i2c.write(b"\x00", done - 1) == 0
    assert set(kinds(rig)) == {ReportKind.TIMING}
    rig.until(done)
    assert rig.chip.i2c.write(b"\x00", done) == 1


def test_access_right_after_power_on_is_answered_but_reported() -> None:
    rig = Rig()
    rig.read(0x7F)
    assert rig.read(0x00) == b"\xd1"
    assert kinds(rig) == [ReportKind.TIMING]
    strict = Rig(strict=True)
    strict.read(0x7F)
    with pytest.raises(UndocumentedAccessError, match="10000000 ns after power-on"):
        strict.read(0x00)


def test_spi_address_counts_up() -> None:
    rig = powered()
    rig.read(0x7F)
    assert rig.read(0x40, 8) == bytes.fromhex("28 03 28 00 0b 88 80 10")


def test_spi_burst_write_counts_up_in_normal_mode() -> None:
    rig = powered()
    rig.start(gyro=False)
    rig.write(0x40, 0x29, 0x05, 0x2A, 0x02)
    assert rig.read(0x40, 4) == bytes((0x29, 0x05, 0x2A, 0x02))
    assert rig.chip.reports == []


def test_burst_write_in_suspend_takes_the_first_byte_only() -> None:
    rig = powered()
    rig.read(0x7F)
    rig.write(0x40, 0x29, 0x05)
    assert rig.read(0x40, 2) == bytes((0x29, 0x03))
    assert kinds(rig) == [ReportKind.PROTOCOL]


@pytest.mark.parametrize(("normal", "gap"), [(True, 2_000), (False, 450_000)])
def test_write_spacing_is_reported_when_too_short(normal: bool, gap: int) -> None:
    rig = powered()
    rig.start(accel=normal, gyro=False)
    rig.write(0x55, 0x01, gap_ns=gap)
    rig.write(0x55, 0x02, gap_ns=gap - 1)
    assert kinds(rig) == []
    rig.write(0x55, 0x03, gap_ns=gap)
    assert kinds(rig) == [ReportKind.TIMING]
    assert rig.read(0x55) == b"\x03"


def test_reads_need_no_spacing() -> None:
    rig = powered()
    rig.read(0x7F)
    rig.write(0x55, 0x01, gap_ns=0)
    assert rig.read(0x55) == b"\x01"
    assert kinds(rig) == []


def test_burst_stays_at_fifo_data() -> None:
    rig = powered()
    rig.read(0x7F)
    assert rig.read(0x22, 6) == b"\x00\x00" + b"\x80" * 4
    assert kinds(rig) == []


def test_three_wire_board_writes_first_and_reads_after_switching() -> None:
    rig = powered(spi_wires=3)
    rig.read(0x7F)
    assert rig.read(0x00) == b"\x00"
    rig.write(0x6B, 0x01)
    assert rig.read(0x00) == b"\xd1"


def test_four_wire_board_loses_the_data_line_in_three_wire_mode() -> None:
    rig = powered()
    rig.read(0x7F)
    rig.write(0x6B, 0x01)
    assert rig.read(0x00) == b"\x00"
    rig.write(0x6B, 0x00)
    assert rig.read(0x00) == b"\xd1"


def test_reply_is_as_long_as_the_request() -> None:
    rig = powered()
    rig.read(0x7F)
    for length in (1, 2, 7, 200):
        assert len(rig.spi(bytes((0x80,)) + bytes(length - 1))) == length
    assert rig.spi(b"") == b""


def test_a_select_without_clocks_disturbs_no_burst() -> None:
    rig = Rig()
    rig.start()
    rig.wait(300 * MS)
    samples = []
    for _ in range(3):
        samples.append(rig.sample())
        rig.read(0x0C, 15)
        assert rig.spi(b"") == b""
        rig.wait(1 * MS)
        assert rig.spi(b"") == b""
    assert len(set(samples)) == 1
    assert rig.chip.reports == []


# -- I²C -----------------------------------------------------------------------------------------------


def test_i2c_addresses() -> None:
    assert Rig().chip.i2c.address == 0x68
    assert Rig(sdo_high=True).chip.i2c.address == 0x69


def test_i2c_pointer_read_and_write() -> None:
    rig = powered()
    i2c = rig.chip.i2c
    assert i2c.write(b"\x40\x29", rig.time.now) == 2
    assert i2c.write(b"\x40", rig.time.now) == 1
    assert i2c.read(3, rig.time.now) == bytes((0x29, 0x03, 0x28))
    assert i2c.read(1, rig.time.now) == b"\x00"  # goes on at 0x43
    assert i2c.read(1, rig.time.now) == b"\x0b"


def test_i2c_burst_write_in_normal_mode() -> None:
    rig = powered()
    i2c = rig.chip.i2c
    i2c.write(b"\x7e\x11", rig.time.now)
    rig.wait(4 * MS)
    i2c.write(bytes((0x55, 0xFF, 0xF0)), rig.time.now)
    i2c.write(b"\x55", rig.time.now)
    assert i2c.read(2, rig.time.now) == b"\xff\xf0"
    assert rig.chip.reports == []


def test_i2c_pointer_stays_at_fifo_data() -> None:
    rig = powered()
    i2c = rig.chip.i2c
    i2c.write(b"\x24", rig.time.now)
    assert i2c.read(3, rig.time.now) == b"\x80\x80\x80"
    assert i2c.read(2, rig.time.now) == b"\x80\x80"
    i2c.write(b"\x23", rig.time.now)
    assert i2c.read(2, rig.time.now) == b"\x00\x80"
    assert i2c.read(1, rig.time.now) == b"\x80"


def test_i2c_is_deaf_once_spi_is_chosen() -> None:
    rig = powered()
    rig.read(0x7F)
    assert rig.chip.i2c.write(b"\x00\x01\x02", rig.time.now) == 0
    assert rig.chip.i2c.read(2, rig.time.now) == b"\xff\xff"


# -- power -----------------------------------------------------------------------------------------------


def test_without_power_nothing_answers() -> None:
    rig = powered()
    rig.start(gyro=False)
    rig.chip.power(False)
    assert rig.read(0x00, 2) == b"\xff\xff"
    assert rig.chip.i2c.write(b"\x00", rig.time.now) == 0
    rig.chip.power(True)
    rig.wait(10 * MS)
    rig.read(0x7F)
    assert rig.read(0x00, 4) == bytes((0xD1, 0x00, 0x00, 0x00))


def test_supply_that_comes_up_later() -> None:
    rig = Rig(start_ns=5 * MS)
    assert rig.read(0x00) == b"\xff"
    rig.until(15 * MS)
    rig.read(0x7F)
    assert rig.read(0x00) == b"\xd1"


def test_brownout_loses_registers_and_restarts() -> None:
    rig = powered()
    rig.start()
    rig.write(0x40, 0x2A)
    rig.wait(100 * MS)
    rig.chip.brownout()
    rig.wait(10 * MS)
    rig.read(0x7F)
    assert rig.read(0x03) == b"\x00"
    assert rig.read(0x40) == b"\x28"
    assert rig.sample() == (0, 0, 0, 0, 0, 0)
    assert rig.sensor_time() == pytest.approx(10e-3 * 25600, abs=5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"spi_wires": 2}, "spi_wires = 2; the part has 3-wire and 4-wire SPI"),
        ({"phase_ns": -1}, "phase_ns = -1; it must not be negative"),
        ({"clock_error_ppm": 2e5}, "clock error of 200000000 ppb"),
    ],
)
def test_constructor_rejects(options: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Rig(**options)  # type: ignore[arg-type]


@pytest.mark.parametrize(("byte_ns", "reported"), [(800, False), (700, True)])
def test_spi_clock_limit(byte_ns: int, reported: bool) -> None:
    rig = Rig()
    rig.start(accel=False, gyro=False)
    now = rig.time.now
    assert rig.chip.transaction(b"\x80\x00", now, now + 2 * byte_ns) == b"\x00\xd1"
    details = [report.detail for report in rig.chip.reports]
    assert details == ["SPI clock faster than 10 MHz: undefined, served as if it were slower"] * reported
