"""Captures of emulated buses, without a whole board: a manifest that describes them, and their traffic."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.virtual_time import VirtualTime
from host.capture.writer import CaptureWriter
from host.cli.main import app

BOARD = """
name = "bench"
title = "buses"
default_profile = "plain"
default_scenario = "still"
[processors.mcu]
part = "STM32F405"
clock_hz = 168_000_000
program = "nowhere:program"
tasks = { other = { priority = 2 } }
[profiles.plain]
"""
PORT = '[uarts.p]\nprocessor = "mcu"\nbaud = 9600\n'
STILL = "duration_s = 8.0\n[place]\nlatitude_deg = 30.0\nlongitude_deg = 114.0\n"


def processor() -> EmulatedCpu:
    """A processor on virtual time of its own."""
    return EmulatedCpu(VirtualTime(), "mcu", 168_000_000, [LineSpec("other", 2)])


def bus_table(name: str, kind: str, clock_hz: int, mode: int = 3) -> str:
    """Of a board's text."""
    return f'[buses.{name}]\nkind = "{kind}"\nprocessor = "mcu"\nclock_hz = {clock_hz}\nmode = {mode}\n'


def capture(path: Path, tables: str, **manifest: Any) -> CaptureWriter:
    """A capture of a board with these tables besides its processor."""
    told = {
        "board": "bench",
        "board_text": BOARD + tables,
        "scenario": "still",
        "scenario_text": STILL,
        "overrides": [],
        **manifest,
    }
    return CaptureWriter(path, told)


def finish(writer: CaptureWriter, end_ns: int) -> Path:
    """End a capture."""
    writer.flush(end_ns)
    writer.close({"duration_s": str(end_ns / 1e9)})
    return writer.path


def waves(*arguments: object) -> Any:
    """Outcome of `navtwin waves …`."""
    return CliRunner().invoke(app, ["waves", *map(str, arguments)])
