"""Pins, timers, watchdog and log file beyond what every backend must do."""

import pytest
from emulated_benches import processor

from hal.emulated.pins import EmulatedInputPin, EmulatedOutputPin, Net
from hal.emulated.storage import CardTiming, EmulatedLogFile
from hal.emulated.timers import EmulatedCaptureTimer, EmulatedPeriodicTimer
from hal.emulated.virtual_time import SECOND
from hal.emulated.watchdog import EmulatedWatchdog
from hal.endings import ProcessorReset
from hal.pins import Edge

MS = 1_000_000


def test_net_tells_changes_only_and_whether_anybody_listens() -> None:
    cpu = processor()
    net = Net(cpu.time, "INT1")
    heard: list[tuple[bool, int]] = []

    def listener(level: bool, time_ns: int) -> None:
        heard.append((level, time_ns))

    net.set(True)
    assert not net.listened
    net.listen(listener)
    assert net.listened
    cpu.delay(100)
    net.set(True)
    net.set(False)
    assert heard == [(False, 100)]
    net.ignore(listener)
    assert not net.listened
    net.set(True)
    assert len(heard) == 1
    with pytest.raises(ValueError, match=r"net 'INT1': .* does not listen"):
        net.ignore(listener)


def test_lazy_driver_brings_the_level_up_to_date_for_the_first_look() -> None:
    """A chip that leaves its pin alone while nobody looks is asked before the level is read."""
    cpu = processor()
    net = Net(cpu.time, "INT1")
    net.on_first_listener = lambda: net.set(True)
    assert EmulatedInputPin(cpu, net).read() is True


def test_reading_a_pin_in_a_loop_lets_time_pass() -> None:
    cpu = processor()
    net = Net(cpu.time, "BUSY", level=True)
    pin = EmulatedInputPin(cpu, net)
    cpu.time.at(10_000, lambda: net.set(False))
    while pin.read():
        pass
    assert 10_000 <= cpu.time.now < 10_200


def test_reset_lets_outputs_go_and_inputs_fall_silent() -> None:
    cpu = processor("pin")
    enable, ready = Net(cpu.time, "ENABLE", level=True), Net(cpu.time, "READY")
    output, wired_input = EmulatedOutputPin(cpu, enable), EmulatedInputPin(cpu, ready)
    wired_input.interrupt_on(Edge.RISING, cpu.attach("pin", lambda: None))
    output.set(False)
    cpu.time.at(100, lambda: cpu.reset("test"))
    with pytest.raises(ProcessorReset):
        cpu.delay(MS)
    assert enable.level is True
    assert not ready.listened
    ready.set(True)
    assert cpu.pending == 0


@pytest.mark.parametrize("error_ppb", [0, 50_000, -50_000])
def test_periodic_timer_keeps_the_rate_of_its_crystal(error_ppb: int) -> None:
    """100 000 expiries at 7 kHz: n·10¹⁸ / (7000·(10⁹ + e)) from the start, nothing accumulated."""
    cpu = processor("tick", crystal_error_ppb=error_ppb)
    last: list[int] = []
    line = cpu.attach("tick", lambda: None)
    cpu.delay(123)
    EmulatedPeriodicTimer(cpu).start(7000, line)
    for n in (1, 2, 100_000):
        while line.activations < n:
            cpu.wait_for_interrupt()
        last.append(line.pended_at)
    assert last == [123 + n * SECOND * SECOND // (7000 * (SECOND + error_ppb)) for n in (1, 2, 100_000)]


def test_timer_that_outruns_its_handler_counts_overruns() -> None:
    cpu = processor("tick")
    line = cpu.attach("tick", lambda: cpu.spend(168_000 * 3))
    timer = EmulatedPeriodicTimer(cpu)
    timer.start(1000, line)
    cpu.time.at(99 * MS + 500_000, timer.stop)
    cpu.delay(100 * MS)
    assert line.activations + line.overruns == 99
    assert line.activations == pytest.approx(99 / 3, abs=1)


def test_timer_rates_are_checked() -> None:
    cpu = processor("tick")
    with pytest.raises(ValueError, match="timer rate of 0 Hz; it must be positive"):
        EmulatedPeriodicTimer(cpu).start(0, cpu.lines["tick"])
    with pytest.raises(TypeError, match="is not a line of an emulated processor"):
        EmulatedPeriodicTimer(cpu).start(100, object())  # type: ignore[arg-type]


def test_capture_latches_the_edge_and_not_the_handler() -> None:
    """A busy processor reads the capture late; the latched clock is that of the edge by its own crystal."""
    cpu = processor("pps", crystal_error_ppb=100_000)
    net = Net(cpu.time, "PPS")
    capture = EmulatedCaptureTimer(cpu, net, Edge.FALLING)
    capture.start()
    cpu.time.at(500 * MS, lambda: net.set(True))
    cpu.time.at(600 * MS, lambda: net.set(False))
    cpu.delay(SECOND)
    assert capture.captured() == (1, 600 * MS + 60_000)


def test_watchdog_costs_few_events_however_often_it_is_kicked() -> None:
    cpu = processor()
    watchdog = EmulatedWatchdog(cpu)
    watchdog.start(SECOND)
    for _ in range(2000):
        cpu.delay(5 * MS)
        watchdog.kick()
    assert cpu.time.events_run <= 11
    assert watchdog.bites == 0
    bitten_at = cpu.time.now + SECOND
    with pytest.raises(ProcessorReset, match="watchdog"):
        cpu.delay(10 * SECOND)
    assert cpu.time.now - bitten_at <= 72
    assert watchdog.bites == 1


def test_watchdog_timeout_is_checked() -> None:
    with pytest.raises(ValueError, match="watchdog timeout of 0 ns"):
        EmulatedWatchdog(processor()).start(0)


class Card:
    """A log with blocks of 100 bytes that take 1 ms, two of them for the directory."""

    def __init__(self, capacity: int = 10_000) -> None:
        self.cpu = processor("tick")
        self.safe = b""
        self.log = EmulatedLogFile(self.cpu, self._sink, capacity, CardTiming(100, MS, 2))

    def _sink(self, data: bytes) -> None:
        self.safe += data


def test_full_blocks_are_written_at_once_and_the_rest_by_sync() -> None:
    card = Card()
    card.log.append(bytes(99))
    assert card.cpu.time.now == 0
    card.log.append(bytes(1))
    assert card.cpu.time.now == 1 * MS
    card.log.append(bytes(250))
    assert card.cpu.time.now == 3 * MS
    card.log.sync()
    assert card.cpu.time.now == 6 * MS
    assert len(card.safe) == 350
    card.log.sync()
    assert card.cpu.time.now == 6 * MS, "nothing new to write"


def test_power_cut_in_the_middle_of_a_sync_loses_it() -> None:
    card = Card()
    card.log.append(b"first ")
    card.log.sync()
    card.log.append(b"second ")
    card.cpu.time.at(card.cpu.time.now + 2 * MS, lambda: card.cpu.reset("brown-out"))
    with pytest.raises(ProcessorReset):
        card.log.sync()
    assert card.safe == b"first "
    assert card.log.lost_bytes == 7
    card.log.append(b"third")
    assert card.log.sync()
    assert card.safe == b"first third"


def test_card_pulled_during_a_sync_is_told() -> None:
    card = Card()
    card.log.append(b"data")
    card.cpu.time.at(MS, card.log.remove)
    card.cpu.time.at(2 * MS, card.log.insert)
    assert card.log.sync() is False
    assert card.safe == b""
    assert card.log.append(b"new") is True
    assert card.log.sync() is True
    assert card.safe == b"new"


def test_append_by_an_interrupt_during_a_sync_is_safe_with_the_next_one() -> None:
    card = Card()
    card.cpu.attach("tick", lambda: card.log.append(b"late"))
    card.cpu.time.at(MS, card.cpu.lines["tick"].request)
    card.log.append(b"early ")
    assert card.log.sync()
    assert card.safe == b"early "
    assert card.log.sync()
    assert card.safe == b"early late"


def test_full_and_failed_cards_refuse() -> None:
    card = Card(capacity=10)
    assert card.log.append(bytes(10)) is True
    assert card.log.append(b"x") is False
    assert card.log.sync() is True
    assert len(card.safe) == 10
    card = Card()
    card.log.failed = True
    assert card.log.append(b"x") is False
    assert card.log.sync() is False
