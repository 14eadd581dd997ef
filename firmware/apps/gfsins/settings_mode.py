"""Settings mode of the FPGA: sensors go on being read at 200 Hz, an operator works a menu, the DSP solves.

acquisition   timer: keys, seven FIFOs, the running procedure
command       what the DSP writes over I²C
main          menu and screen twenty times a second; compass, receiver, missing chips, watchdog

The DSP gets no packets of its own accord here, so it neither aligns nor navigates.
"""

from __future__ import annotations

from firmware.apps.gfsins import commands
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.menu import Menu
from firmware.apps.gfsins.menu_tree import menu_of
from firmware.apps.gfsins.procedures import Procedures
from firmware.apps.gfsins.sampling import Sampling
from firmware.apps.gfsins.settings import TICKS_PER_S
from firmware.apps.gfsins.settings_health import SettingsHealth
from firmware.drivers.keypad import KEYS, Keypad
from firmware.drivers.ssd1325 import Ssd1325
from firmware.drivers.text_screen import TextScreen
from hal.board_io import BoardIo

LOOKS_PER_S = 20
TICKS_PER_LOOK = TICKS_PER_S // LOOKS_PER_S
LOOKS_PER_SENSOR_LOOK = 2
LOOKS_PER_RESTORE = 2 * LOOKS_PER_S
"""The display cannot be asked whether it is still set up."""
WATCHDOG_NS = 4_000_000_000


class SettingsMode:
    """`run` returns when the operator leaves."""

    def __init__(self, io: BoardIo, calibration: Calibration) -> None:
        self._io = io
        self._calibration = calibration
        self._starts = 0

    def run(self) -> None:
        """From the reset vector."""
        io = self._io
        io.watchdog.start(WATCHDOG_NS)
        self._starts = self._starts + 1 & commands.BYTE
        self._begin()
        io.timers["acquisition"].start(TICKS_PER_S, io.interrupts.attach("acquisition", self._on_tick))
        self._sampling.compass.start()
        looks = 0
        while not self._menu.has_left:
            while self._sampling.ticks // TICKS_PER_LOOK == looks:
                io.cpu.wait_for_interrupt()
            looks = self._sampling.ticks // TICKS_PER_LOOK
            io.watchdog.kick()
            self._look(looks)
        io.timers["acquisition"].stop()
        self._screen.stop()

    def _begin(self) -> None:
        io = self._io
        self._keypad = Keypad({key: io.inputs[f"key_{key.lower()}"] for key in KEYS}, TICKS_PER_S)
        display = Ssd1325(io.spi["display"], io.outputs["display_dc"], io.outputs["display_reset"], io.cpu)
        self._screen = TextScreen(display, io.cpu, io.cpu.cost("glyph"))
        self._screen.start()
        self._screen.show(["gfsins settings mode", "", "sensors start ..."])
        self._sampling = Sampling(io, self._calibration.corrections)
        self._slave = io.i2c_slaves["commands"]
        self._procedures = Procedures(io, self._sampling, self._calibration)
        self._health = SettingsHealth(io.clock, self._sampling, self._keypad, self._calibration)
        self._menu: Menu = menu_of(self._calibration, self._sampling, self._procedures, self._health)
        self._menu_cost = io.cpu.cost("menu")
        self._health_cost = io.cpu.cost("health")
        self._slave.begin(io.interrupts.attach("command", self._on_command))
        self._sampling.begin()

    def _on_tick(self) -> None:
        self._keypad.scan()
        self._sampling.tick()

    def _on_command(self) -> None:
        self._health.heard()
        self._procedures.on_command(self._slave.taken())

    def _look(self, looks: int) -> None:
        """One turn of the background."""
        io, menu = self._io, self._menu
        if looks % LOOKS_PER_SENSOR_LOOK == 0:
            self._sampling.look()
        if looks % LOOKS_PER_S == 0:
            self._sampling.mend()
            io.cpu.spend(self._health_cost)
        self._procedures.service()
        while (key := self._keypad.take()) is not None:
            menu.press(key)
        io.cpu.spend(self._menu_cost)
        self._screen.show(menu.lines(), menu.marked)
        if looks % LOOKS_PER_RESTORE == 0:
            self._screen.restore()
        self._slave.answer(self._health.status(self._starts))
