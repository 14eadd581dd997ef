"""The image in the FPGA's flash: two inputs, read at power-up and at every reset, choose what it does.

    MODE1 MODE0   0 0 acquisition   0 1 settings   anything else: acquisition

"Leave" in the settings menu goes on as acquisition at once; the next reset looks at the inputs again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware.apps.gfsins.acquisition import Acquisition
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.corrections import Corrections
from firmware.apps.gfsins.settings import Settings
from firmware.apps.gfsins.settings_mode import SettingsMode
from hal.board_io import BoardIo

SETTINGS_CODE = 0b01


def program(io: BoardIo, profile: Mapping[str, Any], installation: Mapping[str, Any]) -> FpgaProgram:
    """The program of the FPGA's processor. Raises ValueError for a profile that no program could mean."""
    Settings.of(profile)
    return FpgaProgram(io)


class FpgaProgram:
    """Implements `hal.board_io.Program`."""

    def __init__(self, io: BoardIo) -> None:
        self._calibration = Calibration(io.flash.get("calibration"), Corrections())
        self._inputs = io.inputs["mode0"], io.inputs["mode1"]
        self._acquisition = Acquisition(io, self._calibration)
        self._settings_mode = SettingsMode(io, self._calibration)

    def main(self) -> None:
        """From the reset vector."""
        self._calibration.load()
        low, high = (pin.read() for pin in self._inputs)
        if low | high << 1 == SETTINGS_CODE:
            self._settings_mode.run()
        self._acquisition.main()

    def spoil(self) -> None:
        """There is no navigation here."""
        self._acquisition.spoil()

    def memory(self) -> bytes:
        """Nothing that navigation depends on outlives its handing over."""
        return self._acquisition.memory()
