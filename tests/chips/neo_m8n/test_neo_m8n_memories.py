"""What is saved, where, and what a start finds of it."""

import struct

import pytest
from neo_m8n_rig import Rig, lines, rate_of, ubx, ubx_messages

PRT_115200 = "B5 62 06 00 14 00 01 00 00 00 D0 08 00 00 00 C2 01 00 07 00 03 00 00 00 00 00 C0 7E"
RATE_1_HZ = "B5 62 06 08 06 00 E8 03 01 00 01 00 01 39"
RATE_5_HZ = "B5 62 06 08 06 00 C8 00 01 00 01 00 DE 6A"
PVT_ON = "B5 62 06 01 03 00 01 07 01 13 51"
GLL_OFF = "B5 62 06 01 03 00 F0 01 00 FB 11"
RST, RATE, CFG = 4, 8, 9


def test_save_load_and_reset_restore(rig: Rig) -> None:
    """Saved in both memories, changed, reset: the saved settings are back."""
    rig.say(RATE_5_HZ)
    rig.say(PVT_ON)
    rig.say(ubx(6, CFG, struct.pack("<III", 0, 0xFFFF, 0)))
    rig.say(RATE_1_HZ)
    rig.run(0.9)
    rig.say(ubx(6, RST, bytes((0, 0, 1, 0))))
    rig.run(1.9)
    assert rate_of(rig) == 200
    assert any(message.identity == "NAV-PVT" for message in ubx_messages(rig.run(1.0)))


def test_unsaved_settings_are_lost_by_reset_and_by_power() -> None:
    for action in ("reset", "power"):
        rig = Rig()
        rig.run(2.9)
        rig.say(GLL_OFF)
        rig.run(0.9)
        assert b"GLL" not in rig.run(1.0)
        if action == "reset":
            rig.say(ubx(6, RST, bytes((0, 0, 0, 0))))
        else:
            rig.chip.power(False)
            rig.chip.power(True)
        rig.run(1.9)
        assert b"GLL" in rig.run(1.0)


@pytest.mark.parametrize(
    ("devices", "backup", "kept"), [(1, True, True), (1, False, False), (2, False, True)]
)
def test_battery_backed_memory_and_flash(devices: int, backup: bool, kept: bool) -> None:
    rig = Rig(backup_supply=backup)
    rig.run(2.9)
    rig.say(GLL_OFF)
    rig.say(ubx(6, CFG, struct.pack("<IIIB", 0, 0x0002, 0, devices)))
    rig.run(0.9)
    rig.chip.power(False)
    rig.run(5.0)
    rig.chip.power(True)
    rig.run(1.9)
    assert (b"GLL" not in rig.run(1.0)) is kept


def test_clear_and_load_go_back_to_defaults(rig: Rig) -> None:
    rig.say(RATE_5_HZ)
    rig.say(ubx(6, CFG, struct.pack("<IIIB", 0, 0xFFFF, 0, 3)))
    rig.say(ubx(6, CFG, struct.pack("<III", 0xFFFF, 0, 0)))
    assert rate_of(rig) == 200  # the current settings stay
    rig.say(ubx(6, CFG, struct.pack("<III", 0, 0, 0xFFFF)))
    rig.run(0.9)
    assert rate_of(rig) == 1000
    assert b"GLL" in rig.run(1.0)


def test_sections_are_saved_one_by_one(rig: Rig) -> None:
    rig.say(ubx(6, RATE, bytes.fromhex("d007 0100 0100")))
    rig.say(PVT_ON)
    rig.say(ubx(6, CFG, struct.pack("<III", 0, 0x0008, 0)))  # navigation only
    rig.say(ubx(6, RST, bytes((0, 0, 1, 0))))
    rig.run(2.9)
    assert rate_of(rig) == 2000
    assert not any(m.identity == "NAV-PVT" for m in ubx_messages(rig.run(2.0)))


def test_saved_baud_rate_is_the_one_of_the_next_start() -> None:
    rig = Rig()
    rig.run(0.9)
    rig.say(PRT_115200)
    rig.run(0.1)
    rig.say(ubx(6, CFG, struct.pack("<III", 0, 1, 0)))
    rig.chip.power(False)
    rig.chip.power(True)
    data = rig.run(0.5)
    assert rig.chip.baud == rig.wire.baud == 115_200
    assert lines(data[data.index(b"$GNTXT") :])[0].startswith("$GNTXT,01,01,02,u-blox")
