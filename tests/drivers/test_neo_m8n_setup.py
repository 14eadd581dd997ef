"""The set-up sequence: against the chip model on real wires, and message for message against pyubx2."""

import pytest
import pyubx2
from receiver_bench import ReceiverBench
from receiver_line import ReceiverLine

from firmware.drivers import gnss_epoch as ge
from firmware.drivers.neo_m8n import Configurator, Phase, ReceiverSetup
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.ubx import frame
from hal.emulated.faults import UartCut
from hal.emulated.virtual_time import SECOND

FAST = ReceiverSetup(baud=115200, rate_hz=1)


def test_messages_are_what_pyubx2_reads_in_them():
    setup = ReceiverSetup(baud=115200, rate_hz=10)
    port = pyubx2.UBXReader.parse(setup.port(), msgmode=pyubx2.SET)
    assert (port.identity, port.portID, port.baudRate) == ("CFG-PRT", 1, 115200)
    assert (port.inUBX, port.inNMEA, port.outUBX, port.outNMEA) == (1, 1, 1, 1)
    told = [pyubx2.UBXReader.parse(message, msgmode=pyubx2.SET) for message in setup.messages()]
    by_hand = {
        (1, 7): 1,
        (0xF0, 2): 10,
        (0xF0, 3): 10,
        (0xF0, 0): 0,
        (0xF0, 1): 0,
        (0xF0, 4): 0,
        (0xF0, 5): 0,
    }
    assert _rates(setup) == by_hand
    rate = next(m for m in told if m.identity == "CFG-RATE")
    assert (rate.measRate, rate.navRate, rate.timeRef) == (100, 1, 1)
    nav5 = next(m for m in told if m.identity == "CFG-NAV5")
    assert (nav5.dyn, nav5.minEl, nav5.dynModel) == (1, 0, 4)
    gnss = next(m for m in told if m.identity == "CFG-GNSS")
    enabled = {getattr(gnss, f"gnssId_{k:02d}"): getattr(gnss, f"enable_{k:02d}") for k in range(1, 5)}
    assert enabled == {0: 1, 1: 1, 5: 1, 6: 0}


def _rates(setup: ReceiverSetup) -> dict[tuple[int, int], int]:
    messages = [m for m in setup.messages() if m[2:4] == b"\x06\x01"]
    return {(m[6], m[7]): m[8] for m in messages}


def test_port_message_is_the_fact_sheets():
    expected = "B5620600140001000000D008000000C201000700030000000000C07E"
    assert ReceiverSetup(baud=115200).port() == bytes.fromhex(expected)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"baud": 31250}, "baud is 31250; possible: 9600, 115200"),
        ({"rate_hz": 3}, "rate_hz is 3; possible: 1, 2"),
        ({"dynamic_model": "car"}, "dynamic_model is 'car'; possible: portable, stationary"),
    ],
)
def test_what_the_receiver_cannot_do_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        ReceiverSetup(**changes)


def test_from_power_on_to_nav_pvt():
    bench = ReceiverBench(FAST)
    assert bench.run_until(Phase.RUNNING, 8) < 8
    assert bench.setup.refused == []
    assert bench.chip.baud == bench.stream.baud == 115200
    bench.epochs.clear()
    bench.run(3)
    assert len(bench.epochs) == 3
    everything = ge.HAS_POSITION | ge.HAS_VELOCITY | ge.HAS_ACCURACY | ge.HAS_TIME | ge.HAS_DATE
    for epoch in bench.epochs:
        assert epoch["flags"] & everything == everything
        assert epoch["lat_nanodeg"] == 48_000_000_000
        assert (epoch["vel_n_mmps"], epoch["vel_d_mmps"]) == (10_000, -500)
        # output begins 80 ms after validity, on the second
        assert abs(epoch["burst_start_ns"] % SECOND - 80_000_000) < 100_000
    assert {s.system for s in bench.stream.satellites()} == {"GPS", "GLONASS"}


def test_faster_rates():
    for rate_hz in (5, 10):
        bench = ReceiverBench(ReceiverSetup(baud=115200, rate_hz=rate_hz))
        bench.run_until(Phase.RUNNING, 8)
        bench.run(1)
        bench.epochs.clear()
        bench.run(2)
        assert len(bench.epochs) == 2 * rate_hz


def test_left_as_it_comes():
    bench = ReceiverBench(None)
    bench.run(5)
    assert bench.setup.phase is Phase.RUNNING
    assert bench.to_chip.bytes_sent == 0
    assert len(bench.epochs) >= 4


def test_a_receiver_that_was_set_up_before_is_found_at_its_bit_rate():
    bench = ReceiverBench(None)
    bench.run(1)
    bench.chip.receive(ReceiverSetup(baud=57600).port(), bench.time.now)
    bench.run(20)
    assert bench.setup.baud == 57600
    bench.epochs.clear()
    bench.run(5)
    assert len(bench.epochs) >= 4


@pytest.mark.parametrize("setup", [FAST, ReceiverSetup(baud=9600), ReceiverSetup(baud=230400)])
def test_a_receiver_that_was_reset_is_set_up_again(setup):
    bench = ReceiverBench(setup, backup_supply=False)
    bench.run_until(Phase.RUNNING, 10)
    bench.chip.power(False)
    bench.run(1)
    bench.chip.power(True)
    bench.run_until(Phase.LISTENING, 8)
    bench.run_until(Phase.RUNNING, 20)
    assert bench.setup.setups == 2
    assert bench.chip.baud == setup.baud


def test_a_cable_that_comes_back_needs_no_search():
    bench = ReceiverBench(FAST)
    bench.run_until(Phase.RUNNING, 10)
    cut = UartCut(bench.time.now, bench.time.now + 8 * SECOND)
    cut.install(bench.to_board)
    bench.run(9)
    assert cut.fired > 0
    bench.run_until(Phase.RUNNING, 6)


def test_an_absent_receiver_is_asked_now_and_then_for_ever():
    bench = ReceiverBench(FAST, powered=False)
    bench.run(60)
    assert bench.setup.phase is Phase.LISTENING
    assert 0 < bench.to_chip.bytes_sent < 60 * 8
    bench.chip.power(True)
    bench.run_until(Phase.RUNNING, 40)


class DeafUart:
    """Takes everything, answers nothing."""

    def __init__(self) -> None:
        self.written: list[bytes] = []
        self.bauds: list[int] = []
        self.room = 1000

    def set_baud(self, baud: int) -> None:
        self.bauds.append(baud)

    def tx_free(self) -> int:
        return self.room

    def write(self, data: bytes) -> int:
        self.written.append(data)
        return len(data)


SENTENCE = b"$GNRMC,,V,,,,,,,,,,N*4D\r\n"


class SteppedSetup:
    """The set-up of a deaf port; the test says what the receiver is heard to say."""

    def __init__(self) -> None:
        self.uart = DeafUart()
        self.stream = ReceiverStream(baud=115200)
        self.line = ReceiverLine(self.stream)
        self.setup = Configurator(self.uart, self.stream, FAST)
        self.tenths = 0

    def step(self, heard: bytes = b"") -> None:
        if heard:
            self.line.send(heard)
        self.setup.step(self.tenths * SECOND // 10)
        self.tenths += 1


def test_messages_without_an_answer_are_repeated_then_the_search_begins_anew():
    bench = SteppedSetup()
    bench.step()
    bench.step(SENTENCE)
    assert bench.setup.phase is Phase.CONFIGURING
    for _ in range(80):
        bench.step()
    assert bench.uart.written.count(FAST.messages()[0]) == 3
    assert bench.setup.phase is Phase.LISTENING


def test_nothing_is_sent_into_a_full_queue():
    bench = SteppedSetup()
    bench.uart.room = 5
    for _ in range(50):
        bench.step(SENTENCE)
    assert bench.uart.written == []


def test_refusals_are_told():
    bench = SteppedSetup()
    bench.step()
    bench.step(SENTENCE)
    for _ in range(40):
        answer = b""
        if bench.uart.written:
            asked = bench.uart.written.pop()[2:4]
            answer = frame(0x0500 if asked == b"\x06\x24" else 0x0501, asked)
        bench.step(answer)
    assert bench.setup.phase is Phase.RUNNING
    assert bench.setup.refused == [0x0624]
