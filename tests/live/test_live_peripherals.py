"""CAN, storage, pins and timers of the live backend beyond what conformance asks."""

from __future__ import annotations

import time
from pathlib import Path

import can
import pytest
from live_benches import MS, VirtualCan, until
from pty_port import PtyPort

from hal.can import CanFrame
from hal.live.can import CanPortError, LiveCan
from hal.live.cpu import LiveCpu
from hal.live.pins import ModemInput, ModemInputLine, ModemOutput, ModemOutputLine
from hal.live.serial_link import SerialLink
from hal.live.storage import LiveLogFile
from hal.live.timers import LiveCapture, LiveTimer
from hal.live.watchdog import LiveWatchdog
from hal.pins import Edge


@pytest.mark.parametrize(
    ("interface", "channel"), [("socketcan", "nosuch0"), ("slcan", "/dev/ttyUSB97"), ("nonsense", "x")]
)
def test_a_can_bus_that_is_not_there_is_told(interface: str, channel: str) -> None:
    with pytest.raises(CanPortError) as caught:
        LiveCan(LiveCpu(), interface, channel)
    assert f"CAN {interface}:{channel} cannot be opened: " in str(caught.value)


def test_only_classic_data_frames_are_received(tmp_path: Path) -> None:
    bench = VirtualCan(tmp_path)
    for odd in (
        can.Message(arbitration_id=1, is_remote_frame=True),
        can.Message(arbitration_id=2, is_error_frame=True),
        can.Message(arbitration_id=3, data=bytes(12), is_fd=True),
    ):
        bench._other.send(odd)
    bench.feed(CanFrame(4, b"\x04"))
    bench.settle()
    assert bench.controller.receive() == CanFrame(4, b"\x04")
    assert bench.controller.receive() is None
    assert bench.controller.ignored == 3
    bench.close()


def test_a_serial_can_adapter_that_is_unplugged_is_found_again(tmp_path: Path) -> None:
    """Its text protocol as it is: t, identifier in three digits, length, data, carriage return."""
    with PtyPort(tmp_path / "adapter") as device:
        controller = LiveCan(LiveCpu(), "slcan", str(device.path), sleep_after_open=0.0)
        device.send(b"t1232AABB\r")
        until(lambda: controller.receive() == CanFrame(0x123, b"\xaa\xbb"), 5.0)
        device.unplug()
        until(lambda: not controller.link.is_open, 5.0)
        assert controller.send([CanFrame(1, b"x")]) == 0
        assert controller.failures == 1
        assert controller.last_problem
        device.plug_in()
        until(lambda: controller.link.is_open, 10.0)
        device.send(b"t4561CC\r")
        until(lambda: controller.receive() == CanFrame(0x456, b"\xcc"), 5.0)
        assert controller.send([CanFrame(0x7FF, b"\x01")]) == 1
        until(lambda: b"t7FF101\r" in bytes(device.written), 5.0)
        assert (controller.link.losses, controller.link.reopenings) == (1, 1)
        controller.close()


def test_frames_that_nobody_fetches_are_counted(tmp_path: Path) -> None:
    bench = VirtualCan(tmp_path)
    for number in range(4200):
        bench._other.send(can.Message(arbitration_id=number % 2048, data=b"\x01", is_extended_id=False))
    until(lambda: bench.controller.frames_received + bench.controller.overruns == 4200, 10.0)
    assert bench.controller.overruns == 4200 - 4096
    assert bench.controller.receive() == CanFrame(0, b"\x01")  # the oldest were kept
    bench.close()


def test_a_full_medium_refuses_and_tells() -> None:
    log = LiveLogFile(LiveCpu(), Path("/dev/full"))
    assert log.append(b"x") is False
    assert log.problem
    log.close()


def test_a_log_goes_on_behind_what_is_there(tmp_path: Path) -> None:
    path = tmp_path / "log.bin"
    path.write_bytes(b"before ")
    log = LiveLogFile(LiveCpu(), path)
    assert log.append(b"and after")
    assert log.sync()
    log.close()
    assert path.read_bytes() == b"before and after"


def test_a_log_is_found_again_when_its_folder_is_back(tmp_path: Path) -> None:
    folder = tmp_path / "card"
    log = LiveLogFile(LiveCpu(), folder / "log.bin")
    assert log.append(b"x") is False
    assert "No such file" in log.problem
    folder.mkdir()
    assert log.append(b"x") is True
    (folder / "log.bin").unlink()
    assert log.sync() is False  # what was appended is nowhere
    assert log.append(b"y") is True
    log.close()
    assert (folder / "log.bin").read_bytes() == b"y"


def test_modem_lines_may_be_inverted() -> None:
    cpu = LiveCpu()
    link = SerialLink("loop://", 9600)
    for out, line, read in (
        (ModemOutputLine.RTS, ModemInputLine.CTS, "cts"),
        (ModemOutputLine.DTR, ModemInputLine.DSR, "dsr"),
    ):
        output = ModemOutput(cpu, link, out, inverted=True)
        upright = ModemInput(cpu, link, line)
        turned = ModemInput(cpu, link, line, inverted=True)
        for level in (True, False):
            output.set(level)
            assert upright.read() is not level
            assert turned.read() is level
            assert link.modem_line(read) is not level
    link.close()
    assert ModemInput(cpu, link, ModemInputLine.CTS).read() is False  # a port that is away has no level


def test_a_capture_tells_the_time_of_the_edge_and_may_choose_it() -> None:
    cpu = LiveCpu()
    link = SerialLink("loop://", 9600)
    output = ModemOutput(cpu, link, ModemOutputLine.RTS)
    output.set(True)
    capture = LiveCapture(cpu, ModemInput(cpu, link, ModemInputLine.CTS), Edge.FALLING)
    capture.start()
    cpu.delay(5 * MS)
    before = cpu.now_ns()
    output.set(False)
    cpu.delay(20 * MS)
    count, at = capture.captured()
    assert count == 1
    assert before <= at <= before + 20 * MS
    output.set(True)
    cpu.delay(5 * MS)
    assert capture.captured() == (1, at)
    link.close()


@pytest.mark.parametrize("wrong", [0, -1])
def test_rates_and_time_outs_are_positive(wrong: int) -> None:
    cpu = LiveCpu({"tick": 1})
    with pytest.raises(ValueError, match=r"it must be positive, e\.g\. 100"):
        LiveTimer(cpu).start(wrong, cpu.attach("tick", lambda: None))
    with pytest.raises(ValueError, match=r"it must be positive, e\.g\. 1_000_000_000"):
        LiveWatchdog(cpu).start(wrong)


def test_a_timer_keeps_its_rate_over_many_periods() -> None:
    """The n-th expiry is due at n / rate: 333 Hz does not divide a second."""
    cpu = LiveCpu({"tick": 1})
    ticks: list[float] = []
    timer = LiveTimer(cpu)
    begin = time.monotonic()
    timer.start(333, cpu.attach("tick", lambda: ticks.append(time.monotonic())))
    while len(ticks) < 333:
        cpu.wait_for_interrupt()
    assert all(tick - begin >= (n + 1) / 333 - 1e-6 for n, tick in enumerate(ticks))
    assert ticks[-1] - begin == pytest.approx(1.0, abs=0.1)
