"""The time pulse: edges on the top of the second, only with a fix, configurable."""

import struct

import pytest
from neo_m8n_rig import MILLISECOND, SECOND, START_GPS_NS, BenchWorld, Rig, ubx

HUNDRED_MS = 100 * MILLISECOND


def tp5(
    period: int = 1_000_000,
    length: int = 100_000,
    flags: int = 0xF7,
    delay: int = 0,
    unlocked_length: int = 0,
) -> bytes:
    return ubx(
        6,
        0x31,
        struct.pack("<BBHhhIIIIiI", 0, 1, 0, 50, 0, period, period, unlocked_length, length, delay, flags),
    )


def test_pulses_rise_on_the_top_of_the_second_and_last_100_ms() -> None:
    rig = Rig(listen=True, world=BenchWorld(gps_time_ns=START_GPS_NS + 123_456_789))
    rig.run(6.0)
    rising = [time for time, level in rig.edges if level]
    assert rising == [second * SECOND - 123_456_789 for second in (3, 4, 5, 6)]
    assert [time - rise for rise, (time, _) in zip(rising, rig.edges[1::2], strict=True)] == [HUNDRED_MS] * 4


def test_the_first_pulse_follows_the_first_fix_and_the_last_one_the_last() -> None:
    rig = Rig(start_state="cold", listen=True)
    rig.run(26.5)
    assert rig.edges == []
    rig.run(2.0)
    assert [time for time, level in rig.edges if level] == [27 * SECOND, 28 * SECOND]
    rig.world.set(fix=False)
    rig.run(3.0)
    assert [time for time, level in rig.edges if level][-1] == 29 * SECOND
    assert rig.pulse.level is False


def test_a_pin_that_nobody_listens_to_costs_nothing() -> None:
    silent, heard = Rig(), Rig(listen=True)
    silent.run(20.0)
    heard.run(20.0)
    assert heard.edges
    assert heard.time.events_run - silent.time.events_run == len(heard.edges)


def test_a_listener_that_comes_later_is_served() -> None:
    rig = Rig()
    rig.run(5.5)
    seen: list[int] = []
    rig.pulse.listen(lambda level, time: seen.append(time) if level else None)
    rig.run(3.0)
    assert seen == [7 * SECOND, 8 * SECOND]


@pytest.mark.parametrize(
    ("frame", "rising", "length"),
    [
        (tp5(period=200_000, length=50_000), [4_200, 4_400, 4_600, 4_800, 5_000], 50),
        (tp5(period=5, length=50_000, flags=0xFF), [4_200, 4_400, 4_600, 4_800, 5_000], 50),  # as a frequency
        (tp5(period=1_000_000, length=1 << 31, flags=0xE7), [5_000], 500),  # length as a ratio
        (tp5(delay=2_000_000), [5_002], 100),
        (tp5(period=2_000_000), [6_000], 100),
    ],
)
def test_configured_pulses(frame: bytes, rising: list[int], length: int) -> None:
    rig = Rig(listen=True, world=BenchWorld(gps_time_ns=START_GPS_NS - START_GPS_NS % (2 * SECOND)))
    rig.run(3.5)
    rig.say(frame)
    rig.run_to(4 * SECOND + 150 * MILLISECOND)
    rig.edges.clear()
    rig.run_to(6 * SECOND + 150 * MILLISECOND if rising == [6_000] else 5 * SECOND + 600 * MILLISECOND)
    ups = [time for time, level in rig.edges if level][: len(rising)]
    assert ups == [time * MILLISECOND for time in rising]
    assert rig.edges[1][0] - rig.edges[0][0] == length * MILLISECOND


def test_falling_edge_at_the_top_of_the_second() -> None:
    rig = Rig(listen=True)
    rig.run(2.5)
    rig.say(tp5(flags=0xB7))
    rig.run(2.7)
    assert rig.edges[-2:] == [(5 * SECOND, False), (5 * SECOND + HUNDRED_MS, True)]


def test_switched_off() -> None:
    rig = Rig(listen=True)
    rig.run(2.5)
    rig.say(tp5(flags=0xF6))
    rig.edges.clear()
    rig.run(4.0)
    assert rig.edges == []


def test_pulses_without_a_fix_when_they_are_wanted() -> None:
    rig = Rig(listen=True, world=BenchWorld(fix=False))
    rig.run(1.5)
    rig.say(tp5(unlocked_length=20_000))
    rig.run(3.0)
    assert [time for time, level in rig.edges if level] == [3 * SECOND, 4 * SECOND]
    assert rig.edges[1][0] - rig.edges[0][0] == 20 * MILLISECOND


def test_pulses_move_with_the_time_that_the_receiver_believes() -> None:
    rig = Rig(listen=True)
    rig.run(4.5)
    rig.world.set(gps_time_ns=START_GPS_NS + 250 * MILLISECOND)
    rig.run(3.0)
    assert [time % SECOND for time, level in rig.edges if level][-2:] == [750 * MILLISECOND] * 2


def test_the_pin_goes_low_with_the_supply() -> None:
    rig = Rig(listen=True)
    rig.run_to(4 * SECOND + 50 * MILLISECOND)
    assert rig.pulse.level is True
    rig.chip.power(False)
    assert rig.pulse.level is False
    rig.edges.clear()
    rig.run(3.0)
    assert rig.edges == []
