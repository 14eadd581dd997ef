"""Starts, dropouts, epochs and their timing, supply."""

import re
from dataclasses import replace

import pytest
from neo_m8n_rig import (
    LEAP_SECONDS,
    MILLISECOND,
    SKY,
    START_GPS_NS,
    BenchWorld,
    Rig,
    line,
    lines,
    nmea,
    quiet_rig,
    ubx,
    ubx_messages,
)

from boards.chips.neo_m8n import NeoM8n
from hal.emulated.virtual_time import SECOND


def statuses(data: bytes) -> list[tuple[str, str]]:
    """(time, status) of every RMC."""
    return [
        (time.decode(), status.decode()) for time, status in re.findall(rb"\$G.RMC,([\d.]*),([AV]),", data)
    ]


def test_cold_start_prints_no_fix_sets_for_26_s_and_knows_the_time_before_the_position() -> None:
    rig = Rig(start_state="cold")
    seen = statuses(rig.run(29.9))
    assert len(seen) == 29
    assert seen[0] == ("", "V")
    assert [status for _, status in seen].index("A") == 25  # the epoch at 26 s is the 26th
    first_time = next(index for index, (time, _) in enumerate(seen) if time)
    assert 0 < first_time < 25
    assert seen[25] == ("092751.00", "A")


@pytest.mark.parametrize(("state", "seconds"), [("warm", 5), ("hot", 1)])
def test_warm_and_hot_starts_know_the_time_at_once(state: str, seconds: int) -> None:
    seen = statuses(Rig(start_state=state).run(8.9))
    assert seen[0][0] == "092726.00"
    assert [status for _, status in seen].index("A") == seconds - 1


def test_start_up_texts_come_first_with_an_idle_line_before() -> None:
    rig = Rig()
    texts = lines(rig.run(0.95))
    assert texts[0] == "$GNTXT,01,01,02,u-blox AG - www.u-blox.com*4E"
    assert "$GNTXT,01,01,02,HW UBX-M8030 00080000*60" in texts
    assert "$GNTXT,01,01,02,PROTVER=18.00*11" in texts
    assert all(text.startswith("$GNTXT,01,01,02,") for text in texts)
    assert rig.run(0.1) == b""


def test_no_time_of_its_own_leaks_before_the_time_is_known() -> None:
    rig = Rig(start_state="cold")
    rig.run(1.5)
    (pvt,) = rig.ask("B5 62 01 07 00 00 08 19")
    assert (pvt.validDate, pvt.validTime, pvt.fixType) == (0, 0, 0)
    assert pvt.year == 2015
    assert pvt.tAcc == 0xFFFFFFFF


def test_dropout_switches_to_no_fix_forms_and_keeps_time() -> None:
    rig = Rig()
    rig.run(3.9)
    rig.world.set(fix=False, satellites=tuple(replace(sat, cn0_dbhz=0.0, used=False) for sat in SKY))
    data = rig.run(1.7)
    assert line(data, "RMC").startswith("$GNRMC,092730.00,V,,,,,,,150324,,,N*")
    assert line(data, "GGA").startswith("$GNGGA,092730.00,,,,,0,00,99.99,,,,,,*")
    assert line(data, "GSV").startswith("$GLGSV,1,1,02,67,62,349,,84,01,353,*")
    pvt = rig.ask("B5 62 01 07 00 00 08 19", 0.3)[0]
    assert (pvt.fixType, pvt.gnssFixOk, pvt.hAcc) == (0, 0, 0xFFFFFFFF)
    assert pvt.lat == pytest.approx(50.502057, abs=1e-6)  # the last position, marked as useless
    rig.world.set(fix=True, satellites=SKY)
    assert statuses(rig.run(1.0)) == [("092731.00", "A")]


def test_time_is_lost_when_the_clock_does_not_hold() -> None:
    rig = Rig()
    rig.run(3.9)
    rig.world.set(fix=False, time_known=False)
    assert line(rig.run(1.0), "RMC") == "$GNRMC,,V,,,,,,,,,,N*4D"


def test_leap_seconds_are_the_default_until_glonass_tells() -> None:
    rig = Rig(start_state="cold", default_leap_seconds=17)
    seen = statuses(rig.run(24.9))
    assert seen[-1][0] == "092750.00"  # one second ahead of UTC: 17 instead of 18 leap seconds
    rig.say(nmea("PUBX,04"))
    assert ",17D," in line(rig.run(0.2), "PUBX,04")
    assert statuses(rig.run(1.8))[-1] == ("092751.00", "A")
    rig.say(nmea("PUBX,04"))
    assert f",{LEAP_SECONDS}," in line(rig.run(0.2), "PUBX,04")


def test_leap_seconds_take_the_almanac_cycle_without_glonass() -> None:
    gps_only = tuple(satellite for satellite in SKY if satellite.system == "GPS")
    world = BenchWorld(satellites=gps_only)
    rig = Rig(start_state="cold", world=world, default_leap_seconds=17)
    rig.run(0.3)
    rig.say(ubx(6, 0, bytes.fromhex("01000000d0080000802500000700010000000000")))  # UBX out only
    rig.run(700.0)
    assert rig.ask("B5 62 01 07 00 00 08 19", 0.2)[0].fullyResolved == 0
    rig.run(80.0)
    pvt = rig.ask("B5 62 01 07 00 00 08 19", 0.2)[0]
    assert pvt.fullyResolved == 1


def test_output_starts_a_latency_after_the_instant_of_validity() -> None:
    rig = quiet_rig()
    rig.say("B5 62 06 01 03 00 F0 00 01 FB 10")
    rig.run(0.5)
    before = rig.time.now
    rig.run_to(before + 2 * SECOND)
    arrivals = [time for time, data in rig.host.chunks if data.startswith(b"$GNGGA")]
    size = len(rig.host.chunks[-1][1])
    expected = size * 10 * SECOND // 9600
    assert {time % SECOND for time in arrivals} == {80 * MILLISECOND + expected}
    assert len(arrivals) >= 2
    assert rig.world.asked[-1] % SECOND == 0


def test_epochs_lie_on_the_grid_of_gps_time_also_when_the_run_starts_anywhere() -> None:
    rig = Rig(world=BenchWorld(gps_time_ns=START_GPS_NS + 123_456_789))
    times = [time for time, _ in statuses(rig.run(4.9))]
    assert times == ["092726.00", "092727.00", "092728.00", "092729.00"]
    assert {time % SECOND for time in rig.world.asked[1:]} == {SECOND - 123_456_789}


def test_rate_of_5_hz_and_the_limits_of_the_receiver() -> None:
    rig = quiet_rig()
    rig.say("B5 62 06 01 03 00 01 07 01 13 51")  # NAV-PVT on
    rig.say("B5 62 06 08 06 00 C8 00 01 00 01 00 DE 6A")  # 5 Hz
    pvts = [m for m in ubx_messages(rig.run(2.0)) if m.identity == "NAV-PVT"]
    assert len(pvts) in (9, 10)
    assert {pvt.iTOW % 1000 for pvt in pvts} == {0, 200, 400, 600, 800}
    rig.say(ubx(6, 8, bytes.fromhex("32000100 0100")))  # 20 Hz is accepted but too fast
    asked = len(rig.world.asked)
    assert any(m.identity == "ACK-ACK" for m in ubx_messages(rig.run(1.0)))
    assert len(rig.world.asked) - asked in (5, 6)
    rig.say(ubx(6, 0x3E, bytes.fromhex("00202001 06080e0000000101")))  # GPS only: 10 Hz
    asked = len(rig.world.asked)
    rig.run(1.0)
    assert len(rig.world.asked) - asked in (10, 11)


def test_navigation_cycles_and_slow_rates() -> None:
    rig = quiet_rig()
    rig.say(ubx(6, 8, bytes.fromhex("e803 0500 0100")))
    asked = len(rig.world.asked)
    rig.run(10.0)
    assert len(rig.world.asked) - asked == 2


def test_a_message_rate_of_three_prints_every_third_epoch() -> None:
    rig = quiet_rig()
    rig.say(ubx(6, 1, bytes((0xF0, 0x04, 3))))
    assert len(statuses(rig.run(9.0)[10:])) == 3


def test_time_jump_moves_the_grid_without_a_double_epoch() -> None:
    rig = Rig()
    rig.run(3.9)
    rig.world.set(gps_time_ns=rig.world.now.gps_time_ns + 300 * MILLISECOND)
    times = [time for time, _ in statuses(rig.run(3.9))]
    # The epoch planned before the jump tells of it; the next one is back on the grid.
    assert times == ["092729.30", "092730.00", "092731.00", "092732.00"]
    assert [time % SECOND for time in rig.world.asked[-5:]] == [0, *[700 * MILLISECOND] * 4]


def test_supply_off_is_silence_and_on_is_a_start() -> None:
    rig = Rig()
    rig.run(5.2)  # amid the output of an epoch
    rig.chip.power(False)
    cut = rig.run(0.0)
    assert rig.run(3.0) == b""
    assert cut.startswith(b"$GNRMC")
    assert not cut.endswith(b"\n")
    rig.say("B5 62 0A 04 00 00 0E 34")
    rig.chip.power(True)
    data = rig.run(2.9)
    assert lines(data)[0].startswith("$GNTXT")
    assert statuses(data)[-1][1] == "A"  # hot again: the backup supply kept what it knew


def test_without_backup_supply_a_start_is_cold() -> None:
    rig = Rig(backup_supply=False)
    rig.run(5.0)
    rig.chip.power(False)
    rig.run(1.0)
    rig.chip.power(True)
    seen = statuses(rig.run(29.0))
    assert [status for _, status in seen].index("A") == 25


def test_the_first_start_is_the_given_one_whoever_switches_the_supply() -> None:
    rig = Rig(start_state="hot", backup_supply=False)
    rig.chip.power(False)  # a board whose supply switch is off at first
    rig.run(3.0)
    rig.chip.power(True)
    assert statuses(rig.run(2.9))[-1][1] == "A"


def test_a_receiver_that_was_off_for_hours_starts_warm() -> None:
    rig = Rig()
    rig.run(5.0)
    rig.chip.power(False)
    rig.run(3 * 3600.0)
    rig.chip.power(True)
    seen = statuses(rig.run(8.0))
    assert seen[0][0] != ""
    assert [status for _, status in seen].index("A") == 4


def test_unpowered_from_the_beginning() -> None:
    rig = Rig(powered=False)
    assert rig.run(2.0) == b""
    assert rig.time.events_run == 0
    rig.chip.power(True)
    rig.chip.power(True)
    assert sum("u-blox AG" in text for text in lines(rig.run(0.9))) == 1


def test_unknown_start_state_is_refused_with_an_example() -> None:
    rig = Rig()
    with pytest.raises(ValueError, match=r"start_state = 'tepid'; possible: 'cold', 'warm', 'hot'"):
        NeoM8n(rig.time, rig.world, rig.wire, start_state="tepid")  # type: ignore[arg-type]


def test_gnss_stop_and_start() -> None:
    rig = Rig()
    rig.run(4.0)
    rig.say(ubx(6, 4, bytes((0, 0, 8, 0))))
    rig.run(0.6)
    assert statuses(rig.run(1.0))[-1][1] == "V"
    rig.say(ubx(6, 4, bytes((0, 0, 9, 0))))
    assert statuses(rig.run(2.5))[-1][1] == "A"


@pytest.mark.parametrize(("mask", "first_fix"), [("0000", 2), ("0100", 6), ("ffff", 27)])
def test_software_reset_hot_warm_cold(mask: str, first_fix: int) -> None:
    rig = Rig()
    rig.run(4.9)
    rig.say(ubx(6, 4, bytes.fromhex(mask) + bytes((1, 0))))
    data = rig.run(29.0)
    texts = data[data.index(b"$GNTXT") :]
    assert texts.startswith(b"$GNTXT,01,01,02,u-blox AG")
    assert [m.identity for m in ubx_messages(data)] == ["ACK-ACK"]
    assert [status for _, status in statuses(texts)].index("A") in (first_fix - 2, first_fix - 1)


def test_gnss_only_reset_keeps_port_and_settings() -> None:
    rig = Rig()
    rig.run(3.9)
    rig.say(ubx(6, 1, bytes((0xF0, 0x01, 0))))
    rig.say(ubx(6, 4, bytes((0xFF, 0xFF, 2, 0))))
    data = rig.run(3.5)
    sentences = data[data.index(b"$GNRMC") :]
    assert b"TXT" not in data
    assert b"GLL" not in sentences
    assert statuses(sentences)[-1] == ("", "V")
