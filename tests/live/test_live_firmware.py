"""The whole program of car_mems in real time: its sensor on a bridge, its receiver and host on ports."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest
from bridged_chips import Desktop
from can import Bus
from live_benches import until
from pty_port import PtyPort

import boards
from hal.board_io import BoardIo
from hal.live.bus_pirate_buses import BusPirateAux, BusPirateSpi
from hal.live.can import LiveCan
from hal.live.cpu import LiveCpu
from hal.live.pins import ModemOutput, ModemOutputLine
from hal.live.serial_link import SerialLink
from hal.live.storage import LiveLogFile
from hal.live.timers import LiveTimer
from hal.live.uart import LiveUart
from hal.live.watchdog import LiveWatchdog
from host.link.decoder import LinkDecoder
from host.link.messages import Gnss, Solution, Status

SECONDS = 2.5
SENTENCES = (
    "GNRMC,{t}.00,A,4717.11437,N,00833.91522,E,0.004,,091222,,,A",
    "GNGGA,{t}.00,4717.11437,N,00833.91522,E,1,08,1.01,499.6,M,48.0,M,,",
    "GNGSA,A,3,02,05,12,15,18,21,25,29,,,,,1.9,1.0,1.6",
)


def sentence(body: str) -> bytes:
    total = 0
    for byte in body.encode():
        total ^= byte
    return f"${body}*{total:02X}\r\n".encode()


def receiver(port: PtyPort, stop: Event) -> None:
    """A receiver that has a fix, once a second."""
    for second in range(60):
        port.send(b"".join(sentence(one.format(t=f"0835{second:02d}")) for one in SENTENCES))
        if stop.wait(1.0):
            return


@pytest.fixture
def places(tmp_path: Path) -> Iterator[tuple[Desktop, PtyPort, PtyPort]]:
    with (
        Desktop(tmp_path / "ttyBRIDGE") as desk,
        PtyPort(tmp_path / "ttyGNSS") as gnss,
        PtyPort(tmp_path / "ttyHOST") as host,
    ):
        yield desk, gnss, host


def test_car_mems_runs_in_real_time(places: tuple[Desktop, PtyPort, PtyPort], tmp_path: Path) -> None:
    desk, gnss, host = places
    card = tmp_path / "card.bin"
    board = tomllib.loads((Path(boards.__file__).parent / "car_mems" / "board.toml").read_text())
    processor = board["processors"]["mcu"]
    cpu = LiveCpu(
        {name: task["priority"] for name, task in processor["tasks"].items()},
        processor["costs"],
        {name: task["deadline_us"] * 1000 for name, task in processor["tasks"].items()},
    )
    spi = BusPirateSpi(cpu, desk.url, speed_hz=4_000_000)
    gnss_link, host_link = SerialLink(str(gnss.path), 9600), SerialLink(str(host.path), 230_400)
    can = LiveCan(cpu, "virtual", "car_mems-test")
    other = Bus(interface="virtual", channel="car_mems-test")
    io = BoardIo(
        cpu=cpu,
        clock=cpu,
        interrupts=cpu,
        watchdog=LiveWatchdog(cpu),
        spi={"imu": spi},
        uart={"gnss": LiveUart(cpu, gnss_link), "host": LiveUart(cpu, host_link)},
        can={"can1": can},
        outputs={
            "gnss_enable": ModemOutput(cpu, gnss_link, ModemOutputLine.DTR),
            "led": BusPirateAux(cpu, spi.session),
        },
        timers={"imu_timer": LiveTimer(cpu), "background": LiveTimer(cpu)},
        logs={"sdcard": LiveLogFile(cpu, card)},
    )
    module, _, name = processor["program"].partition(":")
    chip = board["chips"]["U2"]
    installation = {
        "imu": {"C_b_s": np.array(chip["mounting"]), "lever_arm_m": np.zeros(3)},
        "gnss": {"C_b_s": np.eye(3), "lever_arm_m": np.array(board["chips"]["U3"]["lever_arm_m"])},
    }
    program = getattr(import_module(module), name)(io, board["profiles"]["thesis"], installation)
    stop = Event()
    talker = Thread(target=receiver, args=(gnss, stop), daemon=True)

    def end() -> None:
        until(lambda: bool(host.written), patience_s=120.0)  # kernels may have to be compiled first
        stop.wait(SECONDS)
        until(lambda: card.exists() and card.stat().st_size > 1000, patience_s=60.0)  # the background's turn
        cpu.power_off()

    ender = Thread(target=end, daemon=True)
    talker.start()
    ender.start()
    cpu.run(program.main)
    stop.set()
    talker.join()
    spi.close()
    can.close()
    for link in (gnss_link, host_link):
        link.close()

    decoder = LinkDecoder()
    messages = [message for _, message in decoder.feed(bytes(host.written))]
    solutions = [one for one in messages if isinstance(one, Solution)]
    reads = [one.imu_reads for one in messages if isinstance(one, Status)]
    assert decoder.bad_crc == decoder.lost == decoder.garbage_bytes == 0
    assert cpu.resets == []  # nobody forgot the watchdog
    assert len(solutions) >= 9 * SECONDS
    assert all(90 <= later - earlier <= 110 for earlier, later in pairwise(reads))
    epochs = [one for one in messages if isinstance(one, Gnss)]
    assert len(epochs) >= 1
    assert epochs[-1].lat_nanodeg == pytest.approx((47 + 17.11437 / 60) * 1e9, abs=10)
    assert solutions[-1].lat_nanodeg == pytest.approx((47 + 17.11437 / 60) * 1e9, abs=1000)
    assert solutions[-1].lon_nanodeg == pytest.approx((8 + 33.91522 / 60) * 1e9, abs=1000)
    assert solutions[-1].height == pytest.approx(499.6 + 48.0, abs=1.0)
    assert card.stat().st_size > 1000
    assert other.recv(0) is not None
    other.shutdown()
