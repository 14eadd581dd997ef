"""The live processor: threads that pend, order of handlers, resets, catching up."""

from __future__ import annotations

import time
from threading import Thread, get_ident

import pytest

from hal.live.cpu import LiveCpu
from hal.live.timers import LiveTimer
from hal.live.watchdog import LiveWatchdog

MS = 1_000_000


def test_handlers_run_in_the_firmwares_thread_whoever_pends() -> None:
    cpu = LiveCpu({"rx": 1})
    threads: list[int] = []
    line = cpu.attach("rx", lambda: threads.append(get_ident()))
    reader = Thread(target=line.pend)
    reader.start()
    reader.join()
    assert threads == []
    cpu.wait_for_interrupt()
    assert threads == [get_ident()]


def test_a_sleeping_processor_wakes_at_once() -> None:
    cpu = LiveCpu({"rx": 1})
    line = cpu.attach("rx", lambda: None)
    pended: list[float] = []

    def later() -> None:
        time.sleep(0.05)
        pended.append(time.monotonic())
        line.pend()

    Thread(target=later).start()
    cpu.wait_for_interrupt()
    assert time.monotonic() - pended[0] < 0.05


def test_the_most_urgent_of_many_goes_first_and_equals_do_not_nest() -> None:
    cpu = LiveCpu({"a": 1, "b": 2, "b2": 2, "c": 3})
    order: list[str] = []
    lines = {}

    def b() -> None:
        order.append("b begins")
        lines["b2"].pend()
        lines["a"].pend()
        order.append("b ends")

    for name in ("c", "b2", "a"):
        lines[name] = cpu.attach(name, lambda name=name: order.append(name))  # type: ignore[misc]
    lines["b"] = cpu.attach("b", b)

    def pend_all() -> None:
        for name in ("c", "b"):
            lines[name].pend()

    thread = Thread(target=pend_all)
    thread.start()
    thread.join()
    cpu.spend(1)
    assert order == ["b begins", "a", "b ends", "b2", "c"]


def test_requests_to_a_pending_line_are_overruns() -> None:
    cpu = LiveCpu({"rx": 1})
    line = cpu.attach("rx", lambda: None)
    line.disable()
    for _ in range(3):
        line.pend()
    assert line.overruns == 2


def test_many_threads_pend_without_losing_a_wake_up() -> None:
    cpu = LiveCpu({f"line{n}": n for n in range(4)})
    runs = [0] * 4
    lines = []
    for n in range(4):

        def handler(n: int = n) -> None:
            runs[n] += 1

        lines.append(cpu.attach(f"line{n}", handler))

    def hammer(n: int) -> None:
        for _ in range(500):
            lines[n].pend()
            if _ % 50 == 0:
                time.sleep(0.001)

    threads = [Thread(target=hammer, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        cpu.delay(MS)
    cpu.spend(1)
    for n, line in enumerate(lines):
        assert runs[n] + line.overruns == 500
        assert not line.pending


def test_a_late_timer_makes_up_for_every_expiry() -> None:
    cpu = LiveCpu({"tick": 1})
    ticks: list[int] = []
    timer = LiveTimer(cpu)
    timer.start(1000, cpu.attach("tick", lambda: ticks.append(1)))
    time.sleep(0.05)  # firmware that computes without touching hal
    cpu.spend(1)
    assert len(ticks) >= 49
    assert cpu.worst_lateness_ns > 40 * MS
    timer.stop()


def test_work_has_its_cost_from_the_table_and_takes_no_time() -> None:
    cpu = LiveCpu(costs={"parse_byte": 120})
    assert cpu.cost("parse_byte") == 120
    with pytest.raises(KeyError, match="parse_byte"):
        cpu.cost("unknown")
    begin = time.monotonic()
    cpu.spend(10**12)
    assert time.monotonic() - begin < 1.0
    assert LiveCpu().cost("anything") == 0


def test_figures_tell_what_lines_did() -> None:
    cpu = LiveCpu({"slow": 2, "fast": 1}, deadlines_ns={"slow": 5 * MS, "fast": 1000 * MS})
    fast = cpu.attach("fast", lambda: time.sleep(0.01))

    def slow() -> None:
        time.sleep(0.01)
        fast.pend()

    cpu.attach("slow", slow).pend()
    figures = {one.name: one for one in cpu.figures()}
    assert figures["slow"].activations == figures["fast"].activations == 1
    assert figures["slow"].deadlines_missed == 1
    assert figures["fast"].deadlines_missed == 0
    assert figures["slow"].worst_response_ns >= 20 * MS > figures["slow"].busy_ns >= 10 * MS


def test_the_watchdog_sends_a_program_back_to_its_reset_vector() -> None:
    cpu = LiveCpu({"tick": 1})
    watchdog = LiveWatchdog(cpu)
    timer = LiveTimer(cpu)
    boots: list[int] = []

    def program() -> None:
        boots.append(cpu.now_ns())
        assert not cpu.lines["tick"].enabled  # as after power-on
        timer.start(100, cpu.attach("tick", lambda: None))
        watchdog.start(50 * MS)
        if len(boots) == 3:
            cpu.power_off()
        while True:
            cpu.wait_for_interrupt()  # forgets to kick

    cpu.run(program)
    assert len(boots) == 3
    assert all(at < 50 * MS for at in boots)  # the clock starts anew
    assert [cause for _, cause in cpu.resets] == ["watchdog", "watchdog"]
    assert watchdog.bites == 2


def test_power_off_from_another_thread_ends_a_sleeping_program() -> None:
    cpu = LiveCpu()
    Thread(target=lambda: (time.sleep(0.05), cpu.power_off())).start()
    begin = time.monotonic()
    cpu.run(lambda: None)
    assert time.monotonic() - begin < 2.0


def test_polling_firmware_does_not_starve_the_threads_it_waits_for() -> None:
    cpu = LiveCpu({"rx": 1})
    arrived: list[int] = []
    line = cpu.attach("rx", lambda: arrived.append(1))

    def reader() -> None:
        for _ in range(20):
            time.sleep(0.001)
            line.pend()

    thread = Thread(target=reader)
    thread.start()
    begin = time.monotonic()
    while len(arrived) + line.overruns < 20 and time.monotonic() - begin < 5.0:
        cpu.now_ns()
    thread.join()
    assert time.monotonic() - begin < 1.0
