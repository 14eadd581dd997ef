"""The DSP's output: a line of text takes its time, too, so that the FPGA hears of two in a row one by one."""

from __future__ import annotations

from firmware.apps.gnss_ins.output import Output


class PacedOutput(Output):
    """What all boards say; packing a line costs what packing a solution does."""

    def send_text(self, message: str) -> None:
        """A line for people."""
        super().send_text(message)
        self._cpu.spend(self._frame_cost)
