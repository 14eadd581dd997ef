"""How the FPGA and its surroundings do in settings mode: for the status page, and for the DSP over I²C."""

from __future__ import annotations

from firmware.apps.gfsins import commands
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.calibration_store import Found
from firmware.apps.gfsins.sampling import Sampling
from firmware.drivers.hmc6343 import Outcome as CompassOutcome
from firmware.drivers.keypad import Keypad
from hal.clock import Clock

DSP_SILENT_NS = 3_000_000_000
"""The DSP tells every second that it is there."""
COMPASS_OUTCOMES = tuple(CompassOutcome)


class SettingsHealth:
    """Knows who is there."""

    def __init__(self, clock: Clock, sampling: Sampling, keypad: Keypad, calibration: Calibration) -> None:
        self.sampling = sampling
        self._calibration = calibration
        self._clock = clock
        self._keypad = keypad
        self._heard_ns: int | None = None

    def heard(self) -> None:
        """The DSP has written something."""
        self._heard_ns = self._clock.now_ns()

    @property
    def dsp_is_silent(self) -> bool:
        """Whether it has not been heard of for long."""
        return self._heard_ns is None or self._clock.now_ns() - self._heard_ns > DSP_SILENT_NS

    @property
    def stuck_keys(self) -> tuple[str, ...]:
        """Keys that nobody can be holding."""
        return self._keypad.stuck

    @property
    def calibration(self) -> Found:
        """What the flash held."""
        return self._calibration.found

    def warning(self) -> str | None:
        """What an operator must know whatever page he is on: the worst of it."""
        chips = self.sampling.chips
        if chips.missing:
            return f"no chip {chip_digits(chips.missing)}"
        if chips.stuck:
            return f"stuck chip {chip_digits(chips.stuck)}"
        if not self.sampling.compass.works:
            return "no compass"
        if self.dsp_is_silent:
            return "DSP is silent"
        if self.stuck_keys:
            return f"key stuck: {self.stuck_keys[0]}"
        if self._calibration.found is Found.SPOILT:
            return "calibration spoilt"
        return None

    def status(self, starts: int) -> bytes:
        """As in acquisition mode, with another mark."""
        chips, receiver = self.sampling.chips, self.sampling.receiver
        return commands.pack_status(
            commands.SETTINGS_MARK,
            starts,
            chips.missing,
            chips.stuck,
            0,
            COMPASS_OUTCOMES.index(self.sampling.compass.outcome),
            receiver.phase,
            receiver.port_errors & commands.BYTE,
            0,
        )


def chip_digits(bits: int) -> str:
    """Bit k as the number k + 1: "37" for chips 3 and 7."""
    return "".join(str(k + 1) for k in range(8) if bits >> k & 1)
