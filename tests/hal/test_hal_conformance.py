"""Every backend of `hal` goes through the checks that `hal.conformance` ships."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import dual_port_benches
import emulated_benches as emulated
import flash_benches
import processor_link_benches as links
import pytest
import scripted_benches as scripted

from hal.conformance import (
    can,
    clock,
    dual_port,
    flash,
    i2c,
    i2c_slave,
    interrupts,
    packet_link,
    pins,
    spi,
    storage,
    timers,
    uart,
    watchdog,
)

BENCHES: dict[ModuleType, dict[str, Callable[[], Any]]] = {
    spi: {"emulated": emulated.EmulatedSpi, "scripted": scripted.ScriptedSpiBench},
    i2c: {"emulated": emulated.EmulatedI2c, "scripted": scripted.ScriptedI2cBench},
    uart: {"emulated": emulated.EmulatedSerial, "scripted": scripted.ScriptedSerial},
    can: {"emulated": emulated.EmulatedCan, "scripted": scripted.ScriptedCanBench},
    pins: {"emulated": emulated.EmulatedPins, "scripted": scripted.ScriptedPins},
    interrupts: {"emulated": emulated.EmulatedInterrupts, "scripted": scripted.ScriptedInterrupts},
    clock: {"emulated": emulated.EmulatedClock, "scripted": scripted.ScriptedClock},
    timers: {"emulated": emulated.EmulatedTimers, "scripted": scripted.ScriptedTimers},
    dual_port: {
        "emulated": dual_port_benches.EmulatedDualPortBench,
        "scripted": dual_port_benches.ScriptedDualPortBench,
    },
    packet_link: {"emulated": links.EmulatedPackets, "scripted": links.ScriptedPackets},
    i2c_slave: {"emulated": links.EmulatedSlave, "scripted": links.ScriptedSlave},
    storage: {"emulated": emulated.EmulatedStorage, "scripted": scripted.ScriptedStorage},
    flash: {"emulated": flash_benches.EmulatedFlashBench, "scripted": flash_benches.ScriptedFlashBench},
    watchdog: {"emulated": emulated.EmulatedWatchdogBench},
}

RUNS = [
    pytest.param(check, bench, id=f"{suite.__name__.rpartition('.')[2]}-{backend}-{check.__name__}")
    for suite, benches in BENCHES.items()
    for backend, bench in benches.items()
    for check in suite.CHECKS
]


@pytest.mark.parametrize(("check", "bench"), RUNS)
def test_backend_conforms(check: Callable[[Any], None], bench: Callable[[], Any]) -> None:
    check(bench())


class WrongSpi(emulated.EmulatedSpi):
    """A backend that forgets the last byte."""

    class Device:
        def transaction(self, buffer: bytearray) -> None:
            for at in range(len(buffer) - 1):
                buffer[at] ^= 0xFF

    def __init__(self) -> None:
        super().__init__()
        self.device = self.Device()  # type: ignore[assignment]


def test_checks_find_a_wrong_backend() -> None:
    with pytest.raises(AssertionError, match="1 bytes: 01, expected fe"):
        spi.exchanges_in_place(WrongSpi())


class DoubleLatching(emulated.EmulatedPins):
    """A backend that pends both edges whatever was chosen."""

    class BothEdges:
        def __init__(self, real: Any) -> None:
            self._real = real

        def interrupt_on(self, _edge: pins.Edge, line: Any) -> None:
            self._real.interrupt_on(pins.Edge.BOTH, line)

    def __init__(self) -> None:
        super().__init__()
        self.input = self.BothEdges(self.input)  # type: ignore[assignment]


def test_checks_find_wrong_edges() -> None:
    with pytest.raises(AssertionError, match=r"3 interrupts on Edge\.RISING, expected 2"):
        pins.edges_interrupt(DoubleLatching())
