"""Taps, activity, inactivity, free-fall, link and auto-sleep: known motions, exact instants."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from adxl345_rig import MS, SECOND, US, G, Motion, Rig, rising

SINGLE, DOUBLE, ACTIVITY, INACTIVITY, FREE_FALL = 0x40, 0x20, 0x10, 0x08, 0x04
TICK_NS = 312_500
"""Undecimated data: 3200 Hz."""


def pulses(*spans: tuple[float, float], axis: str = "fz", level: float = 6.0) -> Motion:
    """Rest with knocks of `level` g between the given milliseconds after 200 ms."""

    def motion(t: Any) -> dict[str, Any]:
        ms = t * 1e3 - 200.0
        on = sum(((ms >= begin) & (ms < end)) * 1.0 for begin, end in spans)
        values = {"fx": 0.0 * t, "fy": 0.0 * t, "fz": G + 0.0 * t}
        values[axis] = values[axis] + level * G * on
        return values

    return motion


class Detector(Rig):
    """Set up by registers; every edge of both pins is kept."""

    def begin(self, registers: dict[int, int], power: int = 0x08, rate: int = 0x0A) -> None:
        for register, value in registers.items():
            self.write(register, value)
        self.origin = self.measure(rate, power=power) + 1_100_000

    def tick_at_or_after(self, time_ns: float) -> int:
        """The instant of the first undecimated sample from a time on."""
        ticks = -(-(round(time_ns) - self.origin) // TICK_NS)
        return self.origin + ticks * TICK_NS

    def sources(self) -> int:
        """The latched bits of INT_SOURCE."""
        return self.byte(0x30) & 0x7C


TAP = {0x1D: 0x30, 0x21: 0x20, 0x2A: 0x07}
"""3 g, 20 ms, all axes."""
TAPS = TAP | {0x22: 0x28, 0x23: 0x50, 0x2E: SINGLE | DOUBLE}
"""Latency 50 ms, window 100 ms."""


# -- single tap ------------------------------------------------------------------------------------


def test_single_tap_comes_when_the_level_falls_back() -> None:
    rig = Detector(pulses((0, 5), level=6.0), listen="INT1")
    rig.begin(TAP | {0x2E: SINGLE})
    rig.until(400 * MS)
    assert rising(rig.edges["INT1"]) == [rig.tick_at_or_after(205 * MS)]
    assert rig.byte(0x2B) == 0x01
    assert rig.sources() == SINGLE
    assert rig.sources() == 0
    assert not rig.nets["INT1"].level
    assert rig.byte(0x2B) == 0x01  # overwritten, never cleared


@pytest.mark.parametrize(
    ("end_ms", "level", "changes", "found"),
    [
        (19, 6.0, {}, True),
        (21, 6.0, {}, False),  # longer than DUR
        (5, 1.9, {}, False),  # 1 g + 1.9 g < 3 g
        (5, 2.1, {}, True),
        (5, -4.2, {}, True),  # the magnitude counts
        (5, 6.0, {0x2A: 0x06}, False),  # Z does not take part
        (5, 6.0, {0x21: 0x00}, False),  # DUR 0
        (5, 6.0, {0x2E: 0x00}, False),
    ],
)
def test_single_tap_conditions(end_ms: float, level: float, changes: dict[int, int], found: bool) -> None:
    rig = Detector(pulses((0, end_ms), level=level))
    rig.begin(TAP | {0x2E: SINGLE} | changes)
    rig.until(400 * MS)
    assert rig.sources() == (SINGLE if found else 0)


@pytest.mark.parametrize(("axis", "bit"), [("fx", 0x04), ("fy", 0x02), ("fz", 0x01)])
def test_tap_source(axis: str, bit: int) -> None:
    rig = Detector(pulses((0, 5), axis=axis))
    rig.begin(TAP | {0x2E: SINGLE})
    rig.until(400 * MS)
    assert rig.byte(0x2B) == bit


def test_taps_are_found_between_slow_output_samples() -> None:
    rig = Detector(pulses((0, 5)))
    rig.begin(TAP | {0x2E: SINGLE}, rate=0x07)
    rig.until(400 * MS)
    assert rig.sources() == SINGLE


# -- double tap ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spans", "changes", "found", "reported_ms"),
    [
        ([(0, 5), (80, 85)], {}, SINGLE | DOUBLE, 85),
        ([(0, 5)], {}, SINGLE, 155),  # the window ends
        ([(0, 5), (160, 165)], {}, SINGLE, 155),  # too late; a tap of its own follows
        ([(0, 5), (30, 35)], {}, SINGLE, 155),  # a spike in the latency, without suppress
        ([(0, 5), (30, 35), (80, 85)], {}, SINGLE | DOUBLE, 85),
        ([(0, 5), (30, 35), (80, 85)], {0x2A: 0x0F}, SINGLE, 30),  # suppress
        ([(0, 5), (50, 65)], {}, SINGLE, 55),  # above as the window opens
        ([(0, 5), (80, 110)], {}, SINGLE, 100),  # the second is longer than DUR
        ([(0, 5), (80, 85)], {0x22: 0x00}, SINGLE, 5),  # LATENT 0: no double tap
        ([(0, 5), (80, 85)], {0x23: 0x00}, SINGLE, 5),  # WINDOW 0
    ],
)
def test_double_tap(
    spans: list[tuple[float, float]], changes: dict[int, int], found: int, reported_ms: float
) -> None:
    rig = Detector(pulses(*spans), listen="INT1")
    rig.begin(TAPS | changes)
    rig.until(200 * MS + round((reported_ms + 4) * MS))
    (when,) = rising(rig.edges["INT1"])
    assert abs(when - (200 + reported_ms) * MS) <= 2 * TICK_NS
    assert rig.sources() == found


def test_double_tap_alone_does_not_show_single_ones() -> None:
    for spans, found in (([(0, 5)], 0), ([(0, 5), (80, 85)], DOUBLE)):
        rig = Detector(pulses(*spans))
        rig.begin(TAPS | {0x2E: DOUBLE})
        rig.until(1 * SECOND)
        assert rig.sources() == found


# -- activity and inactivity -----------------------------------------------------------------------


def test_activity_is_an_or_of_the_axes_at_undecimated_instants() -> None:
    rig = Detector(pulses((3, 600), axis="fy", level=1.2), listen="INT2")
    rig.begin({0x24: 0x10, 0x27: 0x60, 0x2E: ACTIVITY, 0x2F: ACTIVITY})
    rig.until(500 * MS)
    assert rising(rig.edges["INT2"]) == [rig.tick_at_or_after(203 * MS)]
    assert rig.byte(0x2B) == 0x20
    assert rig.sources() == ACTIVITY
    rig.wait(1 * MS)
    assert rig.sources() == ACTIVITY  # still moving
    rig.until(900 * MS)
    assert rig.sources() == ACTIVITY  # until it stopped
    assert rig.sources() == 0


@pytest.mark.parametrize(("control", "found"), [(0x70, ACTIVITY), (0x60, 0), (0x10, ACTIVITY), (0x00, 0)])
def test_only_enabled_axes_count(control: int, found: int) -> None:
    rig = Detector()
    rig.begin({0x24: 0x0E, 0x27: control, 0x2E: ACTIVITY})
    rig.until(500 * MS)
    assert rig.sources() == found


def test_ac_coupled_activity_forgets_gravity() -> None:
    rig = Detector(pulses((0, 5), level=0.5), listen="INT1")
    rig.begin({0x24: 0x06, 0x27: 0xF0, 0x2E: ACTIVITY})
    rig.until(199 * MS)
    assert rig.sources() == 0
    rig.until(300 * MS)
    assert rising(rig.edges["INT1"]) == [rig.tick_at_or_after(200 * MS)]
    assert rig.sources() == ACTIVITY


def test_inactivity_after_the_time_without_a_break() -> None:
    """Knocks on x until 0.5 s after the 200 ms; then 2 s of rest."""
    knocks = [(k * 100.0, k * 100.0 + 20.0) for k in range(6)]
    rig = Detector(pulses(*knocks, axis="fx", level=1.0), listen="INT1")
    rig.begin({0x25: 0x08, 0x26: 0x02, 0x27: 0x06, 0x2E: INACTIVITY})
    rig.until(5 * SECOND)
    (first, *_) = rising(rig.edges["INT1"])
    after = 200 * MS + 520 * MS
    output = rig.origin + -(-(after - rig.origin) // (10 * MS)) * 10 * MS
    assert first == output + 2 * SECOND
    assert rig.sources() == INACTIVITY


def test_inactivity_looks_at_output_samples() -> None:
    """A knock of 1 ms between two output samples of 12.5 Hz; the first from which 1 s has passed tells."""
    rig = Detector(pulses((10, 11), axis="fx", level=2.0))
    rig.begin({0x25: 0x08, 0x26: 0x01, 0x27: 0x06, 0x2E: INACTIVITY}, rate=0x07)
    rig.until(rig.origin + 80 * MS + 13 * 80 * MS - 1)
    assert rig.sources() == 0
    rig.wait(1)
    assert rig.sources() == INACTIVITY


def test_time_inact_zero_fires_with_the_first_sample() -> None:
    rig = Detector(listen="INT1")
    rig.begin({0x25: 0x08, 0x26: 0x00, 0x27: 0x06, 0x2E: INACTIVITY})
    rig.until(100 * MS)
    assert rising(rig.edges["INT1"]) == [rig.origin + 10 * MS]


def test_inactivity_wants_all_axes_below() -> None:
    rig = Detector()
    rig.begin({0x25: 0x08, 0x26: 0x01, 0x27: 0x07, 0x2E: INACTIVITY})
    rig.until(3 * SECOND)
    assert rig.sources() == 0  # gravity on z
    rig.write(0x27, 0x0F)  # ac
    rig.wait(1100 * MS)
    assert rig.sources() == INACTIVITY


def test_ac_coupled_inactivity_follows_a_new_rest() -> None:
    rig = Detector(lambda t: {"fx": G * (t > 1.5)}, listen="INT1")
    rig.begin({0x25: 0x04, 0x26: 0x01, 0x27: 0x0F, 0x2E: INACTIVITY})
    rig.until(1400 * MS)
    assert rig.sources() == INACTIVITY
    rig.until(2400 * MS)
    assert rig.sources() == 0
    rig.until(2600 * MS)
    assert rig.sources() == INACTIVITY


# -- free-fall -------------------------------------------------------------------------------------


def falling(begin_ms: float, end_ms: float) -> Motion:
    return lambda t: {"fz": G * ~((t * 1e3 >= begin_ms) & (t * 1e3 < end_ms))}


def test_free_fall_after_its_time() -> None:
    rig = Detector(falling(200, 400), listen="INT1")
    rig.begin({0x28: 0x07, 0x29: 0x14, 0x2E: FREE_FALL})
    rig.until(700 * MS)
    assert rising(rig.edges["INT1"]) == [rig.tick_at_or_after(200 * MS) + 100 * MS]
    assert rig.sources() == FREE_FALL


@pytest.mark.parametrize(
    ("end_ms", "threshold", "found"), [(295, 7, 0), (305, 7, FREE_FALL), (250, 17, FREE_FALL)]
)
def test_free_fall_conditions(end_ms: float, threshold: int, found: int) -> None:
    rig = Detector(falling(200, end_ms))
    rig.begin({0x28: threshold, 0x29: 0x14, 0x2E: FREE_FALL, 0x27: 0xFF})
    rig.until(700 * MS)
    assert rig.sources() == found


# -- link, auto-sleep ------------------------------------------------------------------------------

PAIR = {0x24: 0x10, 0x25: 0x08, 0x26: 0x01, 0x27: 0x66, 0x2E: ACTIVITY | INACTIVITY}
"""x and y: active above 1 g, inactive after 1 s below 0.5 g."""


def moving(*spans: tuple[float, float]) -> Motion:
    """2 g on x in the given seconds."""
    return lambda t: {"fx": 2.0 * G * sum(((t >= begin) & (t < end)) * 1.0 for begin, end in spans), "fz": G}


def test_linked_functions_take_turns() -> None:
    rig = Detector(moving((0.5, 0.6), (2.5, 2.6)))
    rig.begin(PAIR, power=0x28)
    rig.until(1000 * MS)
    assert rig.sources() == 0  # activity waits for inactivity
    rig.until(1700 * MS)
    assert rig.sources() == INACTIVITY
    rig.until(2400 * MS)
    assert rig.sources() == 0  # no second inactivity
    rig.until(2700 * MS)
    assert rig.sources() == ACTIVITY
    rig.until(3700 * MS)
    assert rig.sources() == INACTIVITY


def test_unlinked_functions_work_side_by_side() -> None:
    rig = Detector(moving((0.5, 0.6), (2.5, 2.6)))
    rig.begin(PAIR)
    rig.until(1000 * MS)
    assert rig.sources() == ACTIVITY
    rig.until(2400 * MS)
    assert rig.sources() == INACTIVITY


def test_auto_sleep_and_waking() -> None:
    rig = Detector(moving((4.03, 5.0)), listen="INT1")
    rig.begin(PAIR | {0x2E: 0x80 | ACTIVITY | INACTIVITY, 0x2F: ACTIVITY | INACTIVITY}, power=0x38)
    rig.until(1000 * MS)
    assert rig.byte(0x2B) & 0x08 == 0
    rig.xyz()
    fell_asleep = rig.origin + 10 * MS + 1 * SECOND
    rig.until(fell_asleep + 1 * MS)
    assert rig.byte(0x2B) & 0x08
    rig.byte(0x30)
    rig.xyz()
    seen = len(rig.edges["INT1"])
    rig.until(3900 * MS)
    assert len(rig.edges["INT1"]) == seen  # no data ready in sleep
    woke = fell_asleep + 125 * MS * -(-(4030 * MS - fell_asleep) // (125 * MS))  # wake-up rate 8 Hz
    rig.until(woke - 1)
    assert rig.byte(0x2B) & 0x08
    rig.until(woke + 10 * US)
    assert rig.byte(0x2B) == 0x40
    assert rig.sources() == ACTIVITY
    rig.until(woke + 50 * MS)
    assert rising(rig.edges["INT1"])[-1] == woke + 1_100_000 + 10 * MS


def test_an_activity_that_nobody_read_blocks_auto_sleep() -> None:
    rig = Detector(moving((1.5, 1.6)))
    rig.begin(PAIR, power=0x38)
    rig.until(3500 * MS)
    assert rig.byte(0x2B) & 0x08 == 0
    assert rig.sources() == ACTIVITY | INACTIVITY
    assert rig.byte(0x2B) & 0x08


def test_auto_sleep_without_link_does_nothing() -> None:
    rig = Detector()
    rig.begin(PAIR, power=0x18)
    rig.until(3 * SECOND)
    assert rig.sources() == INACTIVITY
    assert rig.byte(0x2B) & 0x08 == 0


def test_leaving_auto_sleep_by_power_ctl() -> None:
    rig = Detector()
    rig.begin(PAIR, power=0x38)
    rig.until(2 * SECOND)
    assert rig.byte(0x2B) & 0x08
    rig.write(0x2D, 0x28)
    assert rig.byte(0x2B) & 0x08 == 0
    rig.xyz()
    rig.wait(20 * MS)
    assert rig.byte(0x30) & 0x80


# -- laziness --------------------------------------------------------------------------------------


def test_looking_late_finds_the_same_as_following_a_pin() -> None:
    """Random knocks; one bench follows a pin, one looks at once, one looks often."""
    rng = np.random.default_rng(7)
    begins = np.cumsum(rng.uniform(30.0, 400.0, 40))
    spans = [(float(b), float(b + rng.uniform(1.0, 25.0))) for b in begins]
    motion = pulses(*spans, axis="fx", level=5.0)
    setup = TAPS | {0x24: 0x20, 0x25: 0x08, 0x26: 0x01, 0x27: 0xEE, 0x28: 0x05, 0x29: 0x14, 0x2E: 0x7C}
    followed, late, often = Detector(motion, listen="INT1 INT2"), Detector(motion), Detector(motion)
    for rig in (followed, late, often):
        rig.begin(setup, power=0x38)
    for k in range(120):
        often.until((k + 1) * 100 * MS)
        often.byte(0x2B)
    for rig in (followed, late):
        rig.until(often.time.now)
    assert followed.byte(0x2B) == late.byte(0x2B) == often.byte(0x2B)
    assert followed.byte(0x30) == late.byte(0x30) == often.byte(0x30)


def test_every_edge_of_a_followed_pin_against_a_plain_reference() -> None:
    """Single taps on x by a dozen lines of Python that know nothing of the model."""
    rng = np.random.default_rng(11)
    begins = np.cumsum(rng.uniform(30.0, 200.0, 50))
    spans = [(float(b), float(b + rng.uniform(1.0, 30.0))) for b in begins]
    motion = pulses(*spans, axis="fx", level=5.0)
    rig = Detector(motion, clock_error_ppm=0.0)
    rig.nets["INT1"].listen(lambda level, when: fired.append(when) if level else None)
    fired: list[int] = []
    rig.begin(TAP | {0x2E: SINGLE})
    end = 200 * MS + round((begins[-1] + 100.0) * MS)
    while rig.time.now < end:
        rig.wait(5 * MS)
        if rig.nets["INT1"].level:
            rig.byte(0x30)

    instants = rig.origin + TICK_NS * np.arange(1, (end - rig.origin) // TICK_NS)
    above = np.abs(motion(instants * 1e-9)["fx"]) > 3.0 * G
    expected, begun = [], None
    for when, high in zip(instants.tolist(), above.tolist(), strict=True):
        if high and begun is None:
            begun = when
        if not high and begun is not None:
            if when - begun < 20 * MS:
                expected.append(when)
            begun = None
    assert 10 < len(expected) < 50
    assert fired == expected
