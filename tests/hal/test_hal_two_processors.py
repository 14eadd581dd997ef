"""Two processors side by side: one works the event queue off, the other is a parked greenlet."""

from collections.abc import Callable

import pytest

from boards.machine import Machine
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.pins import EmulatedInputPin, EmulatedOutputPin, Net
from hal.emulated.timers import EmulatedPeriodicTimer
from hal.emulated.virtual_time import VirtualTime
from hal.pins import Edge

MS = 1_000_000


class Pair:
    """Processors "fpga" (first) and "dsp" at 100 MHz, with a wire each way between them."""

    def __init__(self) -> None:
        self.time = VirtualTime()
        self.machine = Machine(self.time)
        lines = (LineSpec("peer", 1), LineSpec("tick", 2))
        self.fpga = EmulatedCpu(self.time, "fpga", 100_000_000, lines)
        self.dsp = EmulatedCpu(self.time, "dsp", 100_000_000, lines)
        self.nets = {name: Net(self.time, name) for name in ("to_dsp", "to_fpga")}
        self.log: list[tuple[str, int]] = []

    def note(self, text: str) -> None:
        self.log.append((text, self.time.now))

    def wires(self, cpu: EmulatedCpu) -> tuple[EmulatedOutputPin, EmulatedInputPin]:
        out, into = ("to_dsp", "to_fpga") if cpu is self.fpga else ("to_fpga", "to_dsp")
        return EmulatedOutputPin(cpu, self.nets[out]), EmulatedInputPin(cpu, self.nets[into])

    def run(self, fpga: Callable[[], None], dsp: Callable[[], None], until: int = 20 * MS) -> None:
        self.machine.add(self.fpga, fpga)
        self.machine.add(self.dsp, dsp)
        self.machine.run_until(until)
        self.machine.power_off()


def idle(cpu: EmulatedCpu) -> Callable[[], None]:
    return cpu.wait_for_interrupt


def test_both_work_at_the_same_time() -> None:
    pair = Pair()

    def program(cpu: EmulatedCpu, pieces: int) -> Callable[[], None]:
        def main() -> None:
            for _ in range(pieces):
                cpu.spend(1_000_000 // pieces)
            pair.note(cpu.name)

        return main

    pair.run(program(pair.fpga, 1), program(pair.dsp, 10))
    assert sorted(pair.log) == [("dsp", 10 * MS), ("fpga", 10 * MS)]


@pytest.mark.parametrize("sender", ["fpga", "dsp"])
@pytest.mark.parametrize("receiver_sleeps", [True, False])
def test_interrupt_across_is_served_at_its_instant(sender: str, receiver_sleeps: bool) -> None:
    """The sender goes on working for 5 ms after the edge; the other one answers in the middle of that."""
    pair = Pair()
    first, second = (pair.fpga, pair.dsp) if sender == "fpga" else (pair.dsp, pair.fpga)

    def sends() -> None:
        output, _ = pair.wires(first)
        first.spend(100_000)
        output.set(True)
        pair.note("edge")
        first.spend(500_000)
        pair.note("sender done")

    def receives() -> None:
        _, wired_input = pair.wires(second)
        line = second.attach("peer", lambda: pair.note("served"))
        wired_input.interrupt_on(Edge.RISING, line)
        if receiver_sleeps:
            second.wait_for_interrupt()
        else:
            second.spend(300_000)
        pair.note("receiver done")

    programs = {first: sends, second: receives}
    pair.run(programs[pair.fpga], programs[pair.dsp])
    assert pair.log == [
        ("edge", 1 * MS),
        ("served", 1 * MS + 120),
        ("receiver done", 1 * MS + 120 if receiver_sleeps else 3 * MS + 120),
        ("sender done", 6 * MS),
    ]
    assert second.lines["peer"].worst_response_ns == 120


def test_ping_pong_takes_one_entry_each_way() -> None:
    pair = Pair()

    def program(cpu: EmulatedCpu, serves: bool) -> Callable[[], None]:
        def main() -> None:
            output, wired_input = pair.wires(cpu)
            level = True

            def answer() -> None:
                nonlocal level
                pair.note(cpu.name)
                if len(pair.log) < 8:
                    output.set(level)
                    level = not level

            wired_input.interrupt_on(Edge.BOTH, cpu.attach("peer", answer))
            if serves:
                cpu.spend(100)
                answer()
            while True:
                cpu.wait_for_interrupt()

        return main

    pair.run(program(pair.fpga, serves=False), program(pair.dsp, serves=True))
    assert pair.log == [("dsp" if n % 2 == 0 else "fpga", 1000 + 120 * n) for n in range(8)]


def test_sleeping_processor_sleeps_until_its_own_handler() -> None:
    """Requests that are masked, and events of others, do not end its sleep."""
    pair = Pair()

    def dsp() -> None:
        line = pair.dsp.attach("peer", lambda: pair.note("handler"))
        line.disable()
        pair.dsp.attach("tick", lambda: pair.note("tick"))
        pair.dsp.wait_for_interrupt()
        pair.note("awake")

    pair.time.at(1 * MS, pair.dsp.lines["peer"].request)
    pair.time.at(2 * MS, lambda: None)
    pair.time.at(3 * MS, pair.dsp.lines["tick"].request)
    pair.time.at(3 * MS, pair.dsp.lines["peer"].request)
    pair.run(idle(pair.fpga), dsp)
    assert pair.log == [("tick", 3 * MS + 120), ("awake", 3 * MS + 120)]
    assert pair.dsp.lines["peer"].overruns == 1


def test_parked_processor_can_be_reset_while_the_other_runs_on() -> None:
    pair = Pair()

    def dsp() -> None:
        pair.note(f"boot after {pair.dsp.reset_cause}")
        pair.dsp.spend(10_000_000)

    def fpga() -> None:
        pair.fpga.spend(200_000)
        pair.dsp.reset("pulled by fpga")
        pair.fpga.spend(300_000)
        pair.note("fpga done")

    pair.run(fpga, dsp)
    assert pair.log == [
        ("boot after power-on", 0),
        ("boot after pulled by fpga", 2 * MS + 120),
        ("fpga done", 5 * MS),
    ]


def test_spend_of_both_is_stretched_by_their_own_interrupts_only() -> None:
    pair = Pair()
    done: dict[str, int] = {}

    def program(cpu: EmulatedCpu, rate_hz: int) -> Callable[[], None]:
        def main() -> None:
            line = cpu.attach("tick", lambda: cpu.spend(1000))
            EmulatedPeriodicTimer(cpu).start(rate_hz, line)
            cpu.spend(1_000_000)
            done[cpu.name] = cpu.time.now

        return main

    pair.run(program(pair.fpga, 1000), program(pair.dsp, 250))
    # 10 ms of work with n handlers of 10.12 µs in it: those whose request comes before the stretched end.
    assert done == {"fpga": 10 * MS + 10 * 10_120, "dsp": 10 * MS + 2 * 10_120}


def test_two_runs_are_equal() -> None:
    logs = []
    for _ in range(2):
        pair = Pair()

        def program(pair: Pair, cpu: EmulatedCpu, rate_hz: int, work: int) -> Callable[[], None]:
            def main() -> None:
                output, wired_input = pair.wires(cpu)
                state = [False]

                def tick() -> None:
                    cpu.spend(work)
                    state[0] = not state[0]
                    output.set(state[0])
                    pair.note(f"{cpu.name} tick")

                wired_input.interrupt_on(Edge.BOTH, cpu.attach("peer", lambda: pair.note(f"{cpu.name} peer")))
                EmulatedPeriodicTimer(cpu).start(rate_hz, cpu.attach("tick", tick))
                while True:
                    cpu.spend(777)

            return main

        pair.run(program(pair, pair.fpga, 3000, 5000), program(pair, pair.dsp, 4000, 3000), until=10 * MS)
        logs.append(pair.log)
    assert logs[0] == logs[1]
    assert len(logs[0]) > 100
    assert [at for _, at in logs[0]] == sorted(at for _, at in logs[0])
