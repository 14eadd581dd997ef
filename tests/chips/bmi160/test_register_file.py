"""The generic register file: access kinds, reserved bits, tags, hooks, reports."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from boards.chips.registers import (
    Access,
    AccessLog,
    NotModelled,
    Register,
    RegisterFile,
    ReportKind,
    UndocumentedAccessError,
)

REGISTERS = (
    Register(0x00, "WHO", Access.READ, 0x5A),
    Register(0x10, "SETUP", Access.READ_WRITE, 0x81, reserved=0x0F),
    Register(0x11, "EXTRA", Access.READ_WRITE, not_modelled=(NotModelled(0x40, "the other mode"),)),
    Register(0x12, "FAR", Access.READ_WRITE, not_modelled=(NotModelled(0xFF, "far side", any_write=True),)),
    Register(0x20, "GO", Access.WRITE),
)


def registers(*, strict: bool = False) -> tuple[RegisterFile, AccessLog]:
    log = AccessLog("PART", strict=strict)
    return RegisterFile(REGISTERS, log), log


@given(value=st.integers(0, 255))
def test_reserved_bits_keep_their_reset_value(value: int) -> None:
    file, log = registers()
    file.write(0x10, value, 0)
    assert file.read(0x10, 0) == value & 0xF0 | 0x01
    assert bool(log.reports) == bool(value & 0x0E)


def test_each_kind_is_reported_once_and_counted() -> None:
    file, log = registers()
    heard = []
    log.listeners.append(heard.append)
    for time in (5, 6, 7):
        file.write(0x00, 1, time)
    file.read(0x20, 8)
    file.read(0x55, 9)
    file.write(0x55, 0, 10)
    assert [(r.kind, r.register, r.first_ns, r.count) for r in log.reports] == [
        (ReportKind.READ_ONLY, "WHO", 5, 3),
        (ReportKind.WRITE_ONLY, "GO", 8, 1),
        (ReportKind.UNDOCUMENTED_ADDRESS, "0x55", 9, 1),
        (ReportKind.UNDOCUMENTED_ADDRESS, "0x55", 10, 1),
    ]
    assert len(heard) == 6


@pytest.mark.parametrize(
    ("address", "value", "touched"), [(0x11, 0xBF, False), (0x11, 0x40, True), (0x12, 0x00, True)]
)
def test_tags(address: int, value: int, touched: bool) -> None:
    file, log = registers()
    file.write(address, value, 0)
    assert file.read(address, 0) == value
    assert [r.kind for r in log.reports] == [ReportKind.NOT_MODELLED] * touched


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (lambda file: file.read(0x55, 3), "PART at 3 ns: undocumented address: 0x55: read"),
        (
            lambda file: file.write(0x00, 1, 4),
            "PART at 4 ns: write to a read-only register: WHO: write ignored",
        ),
        (lambda file: file.write(0x10, 0x0F, 5), "PART at 5 ns: reserved bits set: SETUP: bits 0x0F ignored"),
        (lambda file: file.write(0x11, 0x40, 6), "PART at 6 ns: not modelled: EXTRA: the other mode"),
    ],
)
def test_strict_mode_raises(action, message: str) -> None:  # type: ignore[no-untyped-def]
    file, _ = registers(strict=True)
    with pytest.raises(UndocumentedAccessError) as error:
        action(file)
    assert str(error.value) == message


def test_documented_reaction_is_reported_but_never_raised() -> None:
    log = AccessLog("PART", strict=True)
    log.report(ReportKind.DROPPED, "GO", "0x01 while another runs", 1)
    assert len(log.reports) == 1


def test_hooks_see_old_and_new_and_run_after_the_value_is_in_place() -> None:
    file, _ = registers()
    seen = []
    file.after_write[0x10] = lambda old, new: seen.append((old, new, file.values[0x10]))
    file.after_read[0x00] = lambda: seen.append("read")
    file.write(0x10, 0x35, 0)
    file.write(0x10, 0x35, 0)
    assert file.read(0x00, 0) == 0x5A
    assert seen == [(0x81, 0x31, 0x31), (0x31, 0x31, 0x31), "read"]


def test_reset_loads_all_values() -> None:
    file, _ = registers()
    file.write(0x10, 0, 0)
    file.write(0x11, 9, 0)
    file.reset()
    assert (file.values[0x00], file.values[0x10], file.values[0x11]) == (0x5A, 0x81, 0x00)


def test_plain_spans_are_those_that_reading_does_nothing_to() -> None:
    file, log = registers()
    file.after_read[0x12] = lambda: None
    spans = [(first, end) for first in range(0x22) for end in range(first + 1, 0x23)]
    plain = {span for span in spans if file.plain(*span)}
    assert plain == {(0x00, 0x01), (0x10, 0x11), (0x10, 0x12), (0x11, 0x12)}
    assert log.reports == []
