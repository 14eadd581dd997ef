"""Every live backend goes through the checks that `hal.conformance` ships."""

from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import live_benches as live
import pytest

from hal.conformance import can, clock, i2c, interrupts, pins, spi, storage, timers, uart, watchdog
from hal.live.can import CanPortError

BENCHES: dict[ModuleType, dict[str, Callable[[Path], Any]]] = {
    spi: {"bridge": live.BridgeSpi},
    i2c: {"bridge": live.BridgeI2c},
    uart: {
        "pty": live.PtySerial,
        "tcp": live.TcpSerial,
        "rfc2217": live.Rfc2217Serial,
        "loop": live.LoopSerial,
    },
    can: {"virtual": live.VirtualCan, "udp_multicast": live.MulticastCan},
    pins: {"modem lines": live.ModemJumper},
    interrupts: {"live": live.LiveInterrupts},
    clock: {"live": live.LiveClock},
    timers: {"live": live.LiveTimers},
    storage: {"file": live.LiveStorage},
    watchdog: {"live": live.LiveWatchdogBench},
}

RUNS = [
    pytest.param(check, bench, id=f"{suite.__name__.rpartition('.')[2]}-{backend}-{check.__name__}")
    for suite, benches in BENCHES.items()
    for backend, bench in benches.items()
    for check in suite.CHECKS
]


@pytest.fixture
def bench(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Any]:
    try:
        made = request.param(tmp_path)
    except CanPortError as error:
        pytest.skip(f"this system has no such bus: {error}")
    yield made
    if hasattr(made, "close"):
        made.close()


@pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning")  # in pyserial's own RFC 2217
@pytest.mark.parametrize(("check", "bench"), RUNS, indirect=["bench"])
def test_live_backend_conforms(check: Callable[[Any], None], bench: Any) -> None:

    check(bench)
