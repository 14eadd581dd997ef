import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.emulated.alarm import Alarm
from hal.emulated.virtual_time import FAR, SECOND, VirtualTime, instant


def run_all(time: VirtualTime) -> None:
    while time.next_due < FAR:
        time.run_next()


def test_events_run_by_time_then_priority_then_creation() -> None:
    time = VirtualTime()
    ran: list[str] = []
    for name, at, priority in [
        ("late", 20, 0),
        ("second", 10, 1),
        ("third", 10, 1),
        ("first", 10, 0),
        ("last", 20, 5),
    ]:
        time.at(at, lambda name=name: ran.append(name), priority)  # type: ignore[misc]
    run_all(time)
    assert ran == ["first", "second", "third", "late", "last"]
    assert time.now == 20


def test_event_for_the_present_instant_runs_in_it_and_after_older_ones() -> None:
    time = VirtualTime()
    ran: list[tuple[str, int]] = []

    def first() -> None:
        ran.append(("first", time.now))
        time.at(time.now, lambda: ran.append(("added", time.now)))
        time.at(time.now, lambda: ran.append(("more urgent", time.now)), priority=-1)

    time.at(5, first)
    time.at(5, lambda: ran.append(("second", time.now)))
    run_all(time)
    assert ran == [("first", 5), ("more urgent", 5), ("second", 5), ("added", 5)]


def test_cancelled_event_does_not_run_and_does_not_move_time() -> None:
    time = VirtualTime()
    ran: list[str] = []
    time.at(10, lambda: ran.append("kept"))
    event = time.at(30, lambda: ran.append("cancelled"))
    event.cancel()
    run_all(time)
    assert ran == ["kept"]
    assert time.now == 10


def test_event_may_cancel_another_of_the_same_instant_and_itself() -> None:
    time = VirtualTime()
    ran: list[str] = []

    def repeat() -> int:
        ran.append("repeat")
        if len(ran) == 3:
            itself.cancel()
        return time.now + 10

    itself = time.at(10, repeat)
    victim = time.at(10, lambda: ran.append("victim"))
    time.at(10, victim.cancel, priority=-1)
    run_all(time)
    assert ran == ["repeat"] * 3
    assert time.now == 30


def test_repeating_event_takes_its_place_behind_events_created_meanwhile() -> None:
    time = VirtualTime()
    ran: list[str] = []

    def tick() -> int | None:
        ran.append(f"tick {time.now}")
        if time.now == 10:
            time.at(20, lambda: ran.append("between"))
        return time.now + 10 if time.now < 30 else None

    time.at(10, tick)
    run_all(time)
    assert ran == ["tick 10", "between", "tick 20", "tick 30"]


def test_time_does_not_go_backwards() -> None:
    time = VirtualTime()
    time.at(100, lambda: None)
    time.run_next()
    message = r"event at 99 ns lies before now \(100 ns\); schedule at now or later"
    with pytest.raises(ValueError, match=message):
        time.at(99, lambda: None)


def test_repetition_does_not_go_backwards() -> None:
    time = VirtualTime()
    time.at(100, lambda: 99)
    with pytest.raises(ValueError, match=r"event repeats at 99 ns, before now \(100 ns\)"):
        time.run_next()


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(-2, 2)), max_size=60))
def test_order_is_that_of_a_stable_sort(wanted: list[tuple[int, int]]) -> None:
    time = VirtualTime()
    ran: list[int] = []
    for number, (at, priority) in enumerate(wanted):
        time.at(at, lambda number=number: ran.append(number), priority)  # type: ignore[misc]
    run_all(time)
    assert ran == sorted(range(len(wanted)), key=lambda number: wanted[number])


@pytest.mark.parametrize("rate_hz", [3, 819, 25_600, 168_000_000])
def test_clock_that_does_not_divide_a_second_never_drifts(rate_hz: int) -> None:
    start = 123
    for seconds in (1, 7, 86_400):
        assert instant(seconds * rate_hz, rate_hz, start) == start + seconds * SECOND
    steps = {instant(n + 1, rate_hz) - instant(n, rate_hz) for n in range(1000)}
    assert steps <= {SECOND // rate_hz, SECOND // rate_hz + 1}


def test_alarm_moves_both_ways() -> None:
    time = VirtualTime()
    rung: list[int] = []
    wanted = 50

    def ring() -> int:
        if time.now < wanted:
            return wanted
        rung.append(time.now)
        return FAR

    alarm = Alarm(time, ring)
    alarm.by(30)
    wanted = 20
    alarm.by(20)
    run_all(time)
    assert rung == [20]
    wanted = 70
    alarm.by(40)
    run_all(time)
    assert rung == [20, 70]
