"""What the emulated flash adds: its times, and what a power cut leaves."""

import pytest

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.flash import EmulatedFlash
from hal.emulated.virtual_time import VirtualTime
from hal.endings import PowerOff


def flash_of(cpu: EmulatedCpu) -> EmulatedFlash:
    return EmulatedFlash(cpu, "settings", 2, 1056)


def cut_at(time: VirtualTime, at_ns: int) -> None:
    def cut() -> None:
        raise PowerOff

    time.at(at_ns, cut)


def test_pages_and_blocks_take_their_time() -> None:
    cpu = EmulatedCpu(VirtualTime(), "mcu", 100_000_000)
    flash = flash_of(cpu)
    flash.program(260, bytes(10))
    assert cpu.time.now == 8_000_000, "ten bytes across the end of a page are two pages"
    flash.erase(0)
    assert cpu.time.now == 21_000_000
    assert (flash.programs, flash.erasures) == (2, 1)


def test_a_power_cut_leaves_half_a_page() -> None:
    cpu = EmulatedCpu(VirtualTime(), "mcu", 100_000_000)
    flash = flash_of(cpu)
    cut_at(cpu.time, 7_000_000)
    with pytest.raises(PowerOff):
        flash.program(0, bytes(528))
    assert flash.content[:264] == bytes(264)
    assert flash.content[264:396] == bytes(132)
    assert flash.content[396:] == b"\xff" * 1716


def test_a_power_cut_leaves_half_a_block() -> None:
    cpu = EmulatedCpu(VirtualTime(), "mcu", 100_000_000)
    flash = flash_of(cpu)
    flash.load(bytes(2112))
    cut_at(cpu.time, 9_000_000)
    with pytest.raises(PowerOff):
        flash.erase(1)
    assert flash.content == bytes(1056) + b"\xff" * 528 + bytes(528)


def test_a_memory_that_is_worn_out_says_so_and_changes_nothing() -> None:
    flash = flash_of(EmulatedCpu(VirtualTime(), "mcu", 100_000_000))
    flash.failed = True
    assert not flash.program(0, b"\x00")
    assert not flash.erase(0)
    assert flash.content == b"\xff" * 2112


def test_content_of_another_size_is_refused() -> None:
    with pytest.raises(ValueError, match="3 bytes; flash 'settings' has 2112"):
        flash_of(EmulatedCpu(VirtualTime(), "mcu", 100_000_000)).load(b"abc")
