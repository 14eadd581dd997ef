"""The processor against schedules worked out by hand. At 100 MHz a cycle is 10 ns and an entry 120 ns."""

import pytest
from emulated_benches import Complementing

import hal.emulated.cpu
from boards.machine import Machine
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.pins import EmulatedInputPin, EmulatedOutputPin, Net
from hal.emulated.spi import EmulatedSpiBus, SpiTiming
from hal.emulated.timers import EmulatedPeriodicTimer
from hal.emulated.virtual_time import VirtualTime
from hal.emulated.watchdog import EmulatedWatchdog
from hal.endings import ProcessorReset, SpinError
from hal.pins import Edge

US = 1000
LINES = (LineSpec("high", 1), LineSpec("middle", 2), LineSpec("low", 3, deadline_ns=12 * US))


def processor(lines: tuple[LineSpec, ...] = LINES, crystal_error_ppb: int = 0) -> EmulatedCpu:
    return EmulatedCpu(VirtualTime(), "mcu", 100_000_000, lines, {"filter": 500}, crystal_error_ppb)


def works(cpu: EmulatedCpu, name: str, cycles: int, log: list[tuple[str, int]]) -> None:
    """Attach a handler that works for `cycles` and logs when it begins and ends its work."""

    def handler() -> None:
        log.append((f"{name} begins", cpu.time.now))
        cpu.spend(cycles)
        log.append((f"{name} ends", cpu.time.now))

    cpu.attach(name, handler)


def request_at(cpu: EmulatedCpu, name: str, *instants: int) -> None:
    for at in instants:
        cpu.time.at(at, cpu.lines[name].request)


def test_work_takes_cycles_rounded_up_to_ns() -> None:
    cpu = EmulatedCpu(VirtualTime(), "mcu", 168_000_000)
    cpu.spend(168_000)
    assert cpu.time.now == 1_000_000
    cpu.spend(1)
    assert cpu.time.now == 1_000_006


def test_nested_interrupts_follow_the_schedule() -> None:
    """Low at 1.0 µs works 10 µs, high at 5.0 µs works 2 µs in its middle, the thread works 50 µs in all."""
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "low", 1000, log)
    works(cpu, "high", 200, log)
    request_at(cpu, "low", 1000)
    request_at(cpu, "high", 5000)
    cpu.spend(5000)
    assert log == [("low begins", 1120), ("high begins", 5120), ("high ends", 7120), ("low ends", 13240)]
    assert cpu.time.now == 50_000 + 12_240
    low, high = cpu.lines["low"], cpu.lines["high"]
    assert (low.worst_response_ns, low.busy_ns, low.worst_start_ns) == (12_240, 10_120, 0)
    assert (high.worst_response_ns, high.busy_ns, high.worst_start_ns) == (2_120, 2_120, 0)
    assert low.deadline_misses == 1
    assert high.deadline_misses == 0


def test_less_urgent_request_waits_and_equal_priority_does_not_nest() -> None:
    cpu = processor((LineSpec("a", 2), LineSpec("b", 2), LineSpec("c", 1)))
    log: list[tuple[str, int]] = []
    works(cpu, "a", 100, log)
    works(cpu, "b", 100, log)
    works(cpu, "c", 100, log)
    request_at(cpu, "b", 1000)
    request_at(cpu, "a", 1200)
    request_at(cpu, "c", 1300)
    cpu.spend(1000)
    assert log == [
        ("b begins", 1120),
        ("c begins", 1420),
        ("c ends", 2420),
        ("b ends", 3240),
        ("a begins", 3360),
        ("a ends", 4360),
    ]
    assert cpu.lines["a"].worst_start_ns == 3240 - 1200


def test_request_during_the_own_handler_is_measured_from_its_own_instant() -> None:
    """Requests at 1 and 4 µs of a 10 µs handler; a third finds the second still pending."""
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "low", 1000, log)
    request_at(cpu, "low", 1000, 4000, 5000)
    cpu.spend(3000)
    low = cpu.lines["low"]
    assert [at for _, at in log] == [1120, 11_120, 11_240, 21_240]
    assert low.activations == 2
    assert low.overruns == 1
    assert low.worst_response_ns == 21_240 - 4000
    assert low.worst_start_ns == 11_120 - 4000
    assert low.deadline_misses == 1


def test_late_arrival_during_entry_runs_first() -> None:
    """High comes 50 ns into the entry of low: it is served, then the entry of low is over."""
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "low", 100, log)
    works(cpu, "high", 100, log)
    request_at(cpu, "low", 1000)
    request_at(cpu, "high", 1050)
    cpu.spend(1000)
    assert log == [("high begins", 1170), ("high ends", 2170), ("low begins", 2170), ("low ends", 3170)]


def test_wire_time_is_not_stretched_by_interrupts() -> None:
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "high", 200, log)
    device = EmulatedSpiBus(cpu, SpiTiming(1_000_000)).device(Complementing())
    request_at(cpu, "high", 5000)
    device.transaction(bytearray(4))
    assert cpu.time.now == 32 * US
    assert log == [("high begins", 5120), ("high ends", 7120)]
    request_at(cpu, "high", 63_000)
    device.transaction(bytearray(4))
    assert cpu.time.now == 63_000 + 120 + 2000, "the handler was at work when the wire fell idle"


def test_disabled_line_is_served_when_it_is_enabled() -> None:
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "high", 100, log)
    line = cpu.lines["high"]
    line.disable()
    request_at(cpu, "high", 1000)
    cpu.spend(500)
    assert log == []
    line.enable()
    assert log == [("high begins", 5120), ("high ends", 6120)]
    assert line.worst_response_ns == 5120


def test_pend_of_a_more_urgent_line_runs_before_it_returns() -> None:
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "high", 100, log)
    cpu.lines["high"].pend()
    assert log == [("high begins", 120), ("high ends", 1120)]


def test_sleep_ends_with_the_handler() -> None:
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "low", 100, log)
    request_at(cpu, "low", 7000)
    cpu.time.at(3000, lambda: None)
    cpu.wait_for_interrupt()
    assert cpu.time.now == 7000 + 120 + 1000


def test_own_pin_interrupts_before_time_passes_on() -> None:
    """A request made outside every event is served as soon as the firmware lets time pass."""
    cpu = processor()
    log: list[tuple[str, int]] = []
    works(cpu, "high", 100, log)
    net = Net(cpu.time, "JUMPER")
    output, wired_input = EmulatedOutputPin(cpu, net), EmulatedInputPin(cpu, net)
    wired_input.interrupt_on(Edge.RISING, cpu.lines["high"])
    cpu.spend(100)
    output.set(True)
    cpu.spend(1000)
    assert log == [("high begins", 1120), ("high ends", 2120)]
    assert cpu.time.now == 1000 + 10_000 + 1120


def test_clock_runs_with_its_crystal() -> None:
    cpu = processor(crystal_error_ppb=50_000)
    cpu.delay(1_000_000_000)
    assert cpu.clock_at(cpu.time.now) == 1_000_050_000
    assert cpu.clock_at(cpu.virtual_ns(700_000_000)) == pytest.approx(700_000_000, abs=1)


def test_unknown_cost_lists_the_known_ones() -> None:
    with pytest.raises(
        KeyError, match=r"processors.mcu.costs 'filtre', which the board does not name; it names: filter"
    ):
        processor().cost("filtre")


def test_endless_polling_names_the_task(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hal.emulated.cpu, "POLL_LIMIT", 1000)
    cpu = processor()

    def waits_for_nothing() -> None:
        while cpu.now_ns() >= 0:
            pass

    cpu.attach("low", waits_for_nothing)
    request_at(cpu, "low", 1000)
    with pytest.raises(
        SpinError, match=r"task 'low' on processor 'mcu' read registers .* give its waiting loop"
    ):
        cpu.spend(1000)


def test_trace_shows_who_worked_when() -> None:
    cpu = processor()
    works(cpu, "low", 1000, [])
    works(cpu, "high", 200, [])
    cpu.start_trace()
    request_at(cpu, "low", 1000)
    request_at(cpu, "high", 5000)
    cpu.spend(5000)
    bits = {line.bit: name for name, line in cpu.lines.items()}
    assert [(bits[bit], start, end) for bit, start, end in cpu.trace] == [
        ("high", 5000, 7120),
        ("low", 1000, 13_240),
    ]


class Firmware:
    """A program that counts its boots and leaves a timer and a watchdog running."""

    def __init__(self, cpu: EmulatedCpu, kicks: bool) -> None:
        self.cpu = cpu
        self.timer = EmulatedPeriodicTimer(cpu)
        self.watchdog = EmulatedWatchdog(cpu)
        self.kicks = kicks
        self.boots: list[tuple[int, int, str]] = []
        self.ticks: list[int] = []
        self.unwound = 0

    def program(self) -> None:
        cpu = self.cpu
        self.boots.append((cpu.time.now, cpu.clock_at(cpu.time.now), cpu.reset_cause))
        line = cpu.attach("low", lambda: self.ticks.append(cpu.time.now))
        if len(self.boots) == 1:
            self.timer.start(100, line)
            self.watchdog.start(55_000_000)
        try:
            while True:
                cpu.wait_for_interrupt()
                if self.kicks:
                    self.watchdog.kick()
        finally:
            self.unwound += 1


def machine_with(cpu: EmulatedCpu, firmware: Firmware) -> Machine:
    machine = Machine(cpu.time)
    machine.add(cpu, firmware.program)
    return machine


def test_watchdog_reboots_and_peripherals_are_off_after_it() -> None:
    cpu = processor()
    firmware = Firmware(cpu, kicks=False)
    machine = machine_with(cpu, firmware)
    machine.run_until(200_000_000)
    assert cpu.resets == [(55_000_120, "watchdog")]
    assert firmware.boots == [(0, 0, "power-on"), (55_000_120, 0, "watchdog")]
    assert firmware.ticks[-1] == 50_000_120, "the timer of before the reset ran on"
    assert len(firmware.ticks) == 5
    machine.power_off()


def test_kicked_watchdog_is_quiet() -> None:
    cpu = processor()
    firmware = Firmware(cpu, kicks=True)
    machine = machine_with(cpu, firmware)
    machine.run_until(200_000_000)
    assert cpu.resets == []
    assert len(firmware.ticks) == 19
    machine.power_off()


def test_reset_unwinds_a_nested_handler() -> None:
    cpu = processor()
    unwound: list[str] = []

    def handler() -> None:
        try:
            cpu.spend(1_000_000)
        except ProcessorReset:
            unwound.append("handler")
            raise

    cpu.attach("low", handler)
    request_at(cpu, "low", 1000)
    cpu.time.at(5000, lambda: cpu.reset("brown-out"))
    with pytest.raises(ProcessorReset, match="brown-out"):
        cpu.spend(1_000_000)
    assert unwound == ["handler"]
    assert cpu.pending == 0
    assert cpu.running_name == "main"


def test_reset_leaves_nothing_pending() -> None:
    """Pins that fall back at the reset make edges; their requests are forgotten with the rest."""
    cpu = processor()
    net = Net(cpu.time, "JUMPER")
    output, wired_input = EmulatedOutputPin(cpu, net), EmulatedInputPin(cpu, net)
    wired_input.interrupt_on(Edge.FALLING, cpu.attach("high", lambda: None))
    output.set(True)
    cpu.reset("test")
    with pytest.raises(ProcessorReset):
        cpu.spend(1000)
    assert net.level is False
    assert cpu.pending == 0


def test_power_off_unwinds_the_firmware_once() -> None:
    cpu = processor()
    firmware = Firmware(cpu, kicks=True)
    machine = machine_with(cpu, firmware)
    machine.run_until(30_000_000)
    machine.power_off()
    assert firmware.unwound == 1
    with pytest.raises(RuntimeError, match="switched off"):
        machine.run_until(40_000_000)


def test_run_goes_on_where_it_stopped() -> None:
    logs = []
    for stops in ([200_000_000], [*range(7_000_000, 200_000_000, 7_000_000), 200_000_000]):
        cpu = processor()
        firmware = Firmware(cpu, kicks=True)
        machine = machine_with(cpu, firmware)
        for stop in stops:
            machine.run_until(stop)
        logs.append(firmware.ticks)
        machine.power_off()
    assert logs[0] == logs[1]


def test_an_activation_broken_off_by_a_reset_leaves_nothing_to_the_next() -> None:
    """High interrupts low, then a reset ends low; later low works 1000 cycles alone, all of it its own."""
    cpu = processor()

    def program() -> None:
        works(cpu, "low", 1000, [])
        works(cpu, "high", 200, [])
        cpu.wait_for_interrupt()

    request_at(cpu, "low", 1000, 100_000)
    request_at(cpu, "high", 2000)
    cpu.time.at(6000, lambda: cpu.reset("watchdog"))
    machine = Machine(cpu.time)
    machine.add(cpu, program)
    machine.run_until(200_000)
    machine.power_off()
    low = cpu.lines["low"]
    assert [cause for _at, cause in cpu.resets] == ["watchdog"]
    assert (low.activations, low.busy_ns, low.worst_busy_ns) == (1, 10_120, 10_120)


def test_figures_of_repeated_activations_are_those_of_each() -> None:
    """A hundred alike, one that is interrupted, a hundred alike again, ten shorter ones."""
    cpu = processor()
    lengths = iter([1000] * 201 + [300] * 10)
    cpu.attach("low", lambda: cpu.spend(next(lengths)))
    works(cpu, "high", 200, [])
    request_at(cpu, "low", *(50_000 * n for n in range(1, 212)))
    request_at(cpu, "high", 50_000 * 101 + 5000)
    cpu.spend(1_500_000)
    low = cpu.lines["low"]
    assert low.activations == 211
    assert low.busy_ns == 201 * 10_120 + 10 * 3_120
    assert (low.worst_busy_ns, low.worst_response_ns, low.deadline_misses) == (10_120, 12_240, 1)
