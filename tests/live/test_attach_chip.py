"""`navtwin attach chip` with chip models behind the emulated bridge."""

from __future__ import annotations

import json
import math
import os
import pty
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from bridged_chips import Desktop
from desk_world import FORCE, RATE, TEMPERATURE
from emulated_bus_pirate import EmulatedBusPirate
from live_benches import until
from pty_port import PtyPort
from typer.testing import CliRunner

from hal.scripted import ScriptedCpu, ScriptedSpi, Transcript
from host.attach.chip_bmi160 import Bmi160OnDesk
from host.cli.main import app

RUN = CliRunner()
IGNORED = ("--seconds", "0.5")


def attach(*options: str) -> Any:
    return RUN.invoke(app, ["attach", "chip", *options])


def figures(*options: str) -> dict[str, Any]:
    done = attach(*options, "--json", "-", "--quiet")
    assert done.exit_code == 0, done.output
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def means(found: dict[str, Any]) -> dict[str, float]:
    return {one["name"]: one["mean"] for one in found["quantities"]}


@pytest.mark.parametrize("bus", ["spi", "i2c"])
def test_a_bmi160_on_the_desk(tmp_path: Path, bus: str) -> None:
    with Desktop(tmp_path / "ttyBRIDGE", clock_error_ppm=20_000.0) as desk:
        found = figures("bmi160", "--port", desk.url, "--bus", bus, "--seconds", "1.2")
        assert not desk.pirate.power  # left without power
    assert found["ok"]
    assert found["found"] == "chip id 0xD1"
    for axis, force, rate in zip("xyz", FORCE, RATE, strict=True):
        assert means(found)[f"force {axis}"] == pytest.approx(force, abs=0.02)
        assert means(found)[f"rate {axis}"] == pytest.approx(math.degrees(rate), abs=0.05)
    noise = {one["name"]: one["noise"] for one in found["quantities"]}
    assert 0.005 < noise["force x"] < 0.04  # 0.002 m/s²/√Hz in some 40 Hz
    assert found["temperature_c"] == pytest.approx(TEMPERATURE, abs=0.1)
    assert found["samples"] + found["samples_missed"] == pytest.approx(1.2 * 102, abs=12)
    assert found["clock_error"] == pytest.approx(0.02, abs=0.015)  # a poll may be 15 ms late
    assert found["bridge"]["failures"] == 0


@pytest.mark.parametrize(
    ("bus", "rate"), [("spi", "100"), ("i2c", "200"), pytest.param("spi", "12.5", marks=pytest.mark.soak)]
)
def test_an_adxl345_on_the_desk(tmp_path: Path, bus: str, rate: str) -> None:
    with Desktop(tmp_path / "ttyBRIDGE", "adxl345") as desk:
        found = figures("adxl345", "--port", desk.url, "--bus", bus, "--rate", rate, "--seconds", "0.9")
    for axis, force in zip("xyz", FORCE, strict=True):
        assert means(found)[f"force {axis}"] == pytest.approx(force, abs=0.05)
    assert found["samples"] == pytest.approx(0.9 * float(rate), rel=0.2, abs=9)
    assert found["temperature_c"] is None


def test_the_table_shows_each_quantity(tmp_path: Path) -> None:
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        done = attach("bmi160", "--port", desk.url, "--seconds", "0.5")
    assert done.exit_code == 0
    assert "(SPI, 1,000 kHz), chip id 0xD1" in done.stdout
    assert all(f"{kind} {axis}" in done.stdout for kind in ("rate", "force") for axis in "xyz")
    assert "°C" in done.stdout
    assert "Traceback" not in done.output


def test_a_record_replays_what_was_seen(tmp_path: Path) -> None:
    record = tmp_path / "desk.txt"
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        found = figures("bmi160", "--port", desk.url, "--seconds", "0.6", "--record", str(record))
    with Transcript(record.read_text()) as transcript:
        chip = Bmi160OnDesk(ScriptedSpi(transcript, "imu"), ScriptedCpu(transcript), 100)
        assert chip.start().ok
        assert chip.temperature() == pytest.approx(found["temperature_c"], abs=0.01)
        samples = []
        while transcript.position < len(transcript.steps):
            samples += chip.poll().samples
    assert len(samples) == found["samples"]
    assert np.mean(samples, axis=0)[3:] == pytest.approx(
        [means(found)[f"force {axis}"] for axis in "xyz"], abs=1e-4
    )


@pytest.mark.parametrize(("chip", "bus"), [("bmi160", "spi"), ("bmi160", "i2c"), ("adxl345", "spi")])
def test_the_command_takes_a_record_for_the_chip(tmp_path: Path, chip: str, bus: str) -> None:
    record = tmp_path / "desk.txt"
    with Desktop(tmp_path / "ttyBRIDGE", chip) as desk:
        options = ("--bus", bus, "--record", str(record), "--seconds", "1.2")
        live = figures(chip, "--port", desk.url, *options)
    replayed = figures(chip, "--port", str(record), "--bus", bus)
    for key in ("ok", "found", "samples", "samples_missed", "temperature_c", "quantities", "restarts"):
        assert replayed[key] == live[key], key
    assert replayed["clock_error"] is None  # a record does not tell the time
    text = record.read_text()
    for place in (len(text) * 9 // 10, len(text) - 1):
        record.write_text(text[:place])  # as kill -9 leaves it
        cut = figures(chip, "--port", str(record), "--bus", bus)
        assert 0 < cut["samples"] <= live["samples"]


def test_a_record_that_does_not_fit_is_one_message(tmp_path: Path) -> None:
    record = tmp_path / "desk.txt"
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        figures("bmi160", "--port", desk.url, "--record", str(record), "--seconds", "0.3")
    whole = record.read_text()
    for options, text, words in (
        (
            ["bmi160", "--rate", "200"],
            whole,
            "the record was made otherwise (chip, bus, rate or driver): step 12",
        ),
        (["adxl345"], whole, "expected: delay 10000000; got: spi imu 2d 00"),
        (["bmi160", "--bus", "i2c"], whole, "the driver differs in word 1 (spi expected, i2c got)"),
        (["bmi160", "--record", "x"], whole, "is a record already"),
        (["bmi160"], "\n".join(whole.splitlines()[:6]) + "\n", "ends before the chip was set up"),
        (["bmi160"], "", "ends before the chip was set up"),
        (["bmi160"], "spi imu 80 -> zz\n", "the record was made otherwise"),
        (["bmi160"], "[project]\n", "is not a record of --record"),
    ):
        record.write_text(text)
        done = attach(*options, "--port", str(record))
        assert done.exit_code == 2, (options, done.output)
        assert words in done.stderr, done.stderr
        assert len(done.stderr.strip().splitlines()) == 1


# -- chips that are not there ----------------------------------------------------------------------


def test_an_empty_desk_is_told_with_what_was_read(tmp_path: Path) -> None:
    record = tmp_path / "desk.txt"
    with PtyPort(tmp_path / "ttyBRIDGE", EmulatedBusPirate().feed) as port:
        for bus in ("spi", "i2c"):
            done = attach("bmi160", "--port", str(port.path), "--bus", bus, "--record", str(record), *IGNORED)
            assert done.exit_code == 1
            assert "nobody answers: chip id reads 0xFF, a BMI160 has 0xD1; is it wired" in done.stderr
            assert "imu" in record.read_text()  # what was tried is recorded


def test_another_chip_is_told_with_its_id(tmp_path: Path) -> None:
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        done = attach("adxl345", "--port", desk.url, *IGNORED)
    assert done.exit_code == 1
    assert "wrong device id: device id reads 0xD1, an ADXL345 has 0xE5\n" in done.stderr


def test_a_chip_that_goes_away_is_told_at_the_end(tmp_path: Path) -> None:
    with Desktop(tmp_path / "ttyBRIDGE") as desk:

        def go() -> None:
            until(lambda: len(desk.pirate.transfers) > 80)
            desk.pirate.spi = None

        Thread(target=go).start()
        done = attach("bmi160", "--port", desk.url, "--seconds", "1.2", "--json", "-")
    assert done.exit_code == 1
    found = json.loads(done.stdout)
    assert not found["ok"]
    assert found["samples"] < 120  # a floating line is no sample
    assert means(found)["force z"] == pytest.approx(FORCE[2], abs=0.05)
    assert "nobody answers" in done.stderr


def test_a_dip_of_the_supply_is_no_sample_of_zero(tmp_path: Path) -> None:
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        left = iter(range(100))

        def feed(data: bytes) -> bytes:
            if next(left, None) == 80:
                desk.chip.brownout()
            return desk.pirate.feed(data)

        desk.port.receiver = feed
        found = figures("bmi160", "--port", desk.url, "--seconds", "1.2")
    assert found["restarts"] >= 1
    assert found["bridge"]["failures"] == 0
    lowest = {one["name"]: one["lowest"] for one in found["quantities"]}
    assert lowest["force z"] == pytest.approx(FORCE[2], abs=0.2)


@pytest.mark.soak
def test_a_bridge_that_is_unplugged_for_a_while_goes_on(tmp_path: Path) -> None:
    with Desktop(tmp_path / "ttyBRIDGE") as desk:

        def pull() -> None:
            until(lambda: len(desk.pirate.transfers) > 80)
            desk.port.unplug()
            desk.pirate.reset()
            time.sleep(0.3)
            desk.port.plug_in()

        Thread(target=pull).start()
        found = figures("bmi160", "--port", desk.url, "--seconds", "3.5")
    assert found["restarts"] >= 1
    assert found["bridge"]["recoveries"] >= 1
    assert means(found)["force z"] == pytest.approx(FORCE[2], abs=0.05)
    assert found["samples"] > 120


# -- what cannot be asked for ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["bmi161", "--port", "P"], "there is no driver for a chip 'bmi161'; there are: bmi160, adxl345"),
        (["bmi160", "--port", "/dev/ttyUSB97"], "--port /dev/ttyUSB97: there is no such port"),
        (["bmi160", "--port", "socket://127.0.0.1:1"], "nobody answers there"),
        (["bmi160", "--port", "P", "--bus", "uart"], "--bus uart: possible are spi and i2c"),
        (["bmi160", "--port", "P", "--address", "0x68"], "--address is for --bus i2c"),
        (["bmi160", "--port", "P", "--bus", "i2c", "--address", "zz"], "--address zz: not a hexadecimal"),
        (["bmi160", "--port", "P", "--bus", "i2c", "--address", "53"], "--address 0x53: a bmi160 has one of"),
        (["bmi160", "--port", "P", "--bus", "i2c", "--address", "0"], "--address 0x00: a bmi160 has one of"),
        (["bmi160", "--port", "P", "--rate", "123"], "--rate 123: a bmi160 has 25, 50, 100, 200"),
        (["bmi160", "--port", "P", "--rate", "12.5"], "--rate 12.5: a bmi160 has 25, 50, 100, 200"),
        (["bmi160", "--port", "P", "--rate", "nan"], "--rate nan: a bmi160 has 25"),
        (["adxl345", "--port", "P", "--rate", "123"], "--rate 123: a adxl345 has 3200, 1600"),
        (["adxl345", "--port", "P", "--speed", "8000000"], "--speed 8000000: for a adxl345 the bridge's spi"),
        (["bmi160", "--port", "P", "--speed", "30000"], "--speed 30000: for a bmi160 the bridge's spi has"),
        (["bmi160", "--port", "/dev/ttyUSB97", "--record", "/nowhere/x.txt"], "--record /nowhere/x.txt"),
        (["bmi160", "--port", "/dev/ttyUSB97", "--record", "/tmp"], "--record /tmp: is a folder"),
        (["bmi160", "--port", ""], "there is no such port"),
        (["bmi160", "--port", "/dev/null"], "/dev/null is not a serial port"),
    ],
)
def test_what_cannot_be_is_one_message(options: list[str], words: str) -> None:
    done = attach(*options)
    assert done.exit_code == 2, done.output
    assert words in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_a_device_that_is_no_bridge_is_one_message(tmp_path: Path) -> None:
    record = tmp_path / "desk.txt"
    with PtyPort(tmp_path / "ttyGNSS", lambda _data: b"$GNGGA,,,,,,0*7F\r\n") as port:
        done = attach("bmi160", "--port", str(port.path), "--record", str(record))
    assert done.exit_code == 2
    assert "instead of BBIO1" in done.stderr
    assert list(tmp_path.iterdir()) == []  # nothing half-written


# -- ending ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.soak)])
def test_ctrl_c_ends_cleanly(tmp_path: Path, how: signal.Signals) -> None:
    record, out = tmp_path / "desk.txt", tmp_path / "out.json"
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "host.cli.main", "attach", "chip", "bmi160", "--port", desk.url),
                *("--record", str(record), "--json", str(out)),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        until(lambda: len(desk.pirate.transfers) > 100, 30.0)
        process.send_signal(how)
        stdout, stderr = process.communicate(timeout=20)
        assert process.returncode == 0, stderr
        assert not desk.pirate.power
    assert stderr == ""
    assert "force z" in stdout
    assert json.loads(out.read_text())["samples"] > 20
    Transcript(record.read_text())  # every line of it is whole
    assert not record.with_name("desk.txt.part").exists()


def test_a_terminal_shows_samples_while_they_come(tmp_path: Path) -> None:
    master, slave = pty.openpty()
    with Desktop(tmp_path / "ttyBRIDGE") as desk:
        command = [sys.executable, "-m", "host.cli.main", "attach", "chip", "bmi160", "--port", desk.url]
        process = subprocess.Popen([*command, "--seconds", "1"], stdout=slave, stderr=subprocess.STDOUT)
        os.close(slave)
        shown = b""
        with suppress(OSError):  # EIO: the other end has been closed
            while piece := os.read(master, 4096):
                shown += piece
        assert process.wait(20) == 0
    os.close(master)
    assert b"Traceback" not in shown
    assert shown.count(b"force z") >= 3  # drawn again and again, and at the end
    assert b"Ctrl-C ends" in shown
    assert b"\x1b[?25h" in shown  # the cursor is back
