"""An emulated STM32F405 (QEMU's machine netduinoplus2); its serial port is a pseudo terminal here."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from host.pil.toolchain import EMULATOR, version_of
from host.record.errors import UserError

COUNTING_SHIFT = 3
"""Counting instructions, each one takes 2**3 ns of the emulated clock."""
CORE_HZ = 168_000_000
"""Of this machine's SysTick, whatever the image sets."""
PORT = re.compile(r"redirected to (\S+)")


@contextmanager
def emulated_board(elf: Path, counting: bool = False) -> Iterator[str]:
    """Start the image; gives the name of its serial port. Switched off at the end.

    `counting`: the processor's clock counts instructions. Raises UserError when QEMU is missing or does not
    start.
    """
    version_of(EMULATOR)
    with tempfile.TemporaryFile("w+") as complaints:
        command = [
            EMULATOR.program,
            "-machine",
            "netduinoplus2",
            "-nographic",
            "-nodefaults",
            "-monitor",
            "none",
        ]
        command += ["-chardev", "pty,id=board", "-serial", "chardev:board", "-kernel", str(elf)]
        if counting:
            command += ["-icount", f"shift={COUNTING_SHIFT},sleep=off"]
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=complaints, text=True
        )
        try:
            assert process.stdout is not None
            found = PORT.search(process.stdout.readline())
            if found is None:
                process.wait(10)
                complaints.seek(0)
                raise UserError(f"{EMULATOR.program} does not start: {complaints.read().strip()[-300:]}")
            yield found[1]
        finally:
            process.kill()
            process.wait()


def instructions(ticks: float) -> int:
    """Instructions that passed while the emulated core's clock counted `ticks`."""
    return round(ticks * 1e9 / CORE_HZ / (1 << COUNTING_SHIFT))
