"""The status page: who is there and who is not."""

from __future__ import annotations

from firmware.apps.gfsins.accelerations import CHIPS
from firmware.apps.gfsins.calibration_store import Found
from firmware.apps.gfsins.menu import Menu, two_ends
from firmware.apps.gfsins.settings_health import SettingsHealth, chip_digits
from firmware.drivers.hmc6343 import Outcome as CompassOutcome

COMPASS = {
    CompassOutcome.OK: "ok",
    CompassOutcome.ABSENT: "missing",
    CompassOutcome.WRONG_CHIP: "wrong chip",
    CompassOutcome.NOT_CONFIGURED: "not set up",
    CompassOutcome.NOT_RUNNING: "not running",
    CompassOutcome.LATE: "late",
}
CALIBRATION = {Found.NOTHING: "none", Found.GOOD: "loaded", Found.SPOILT: "spoilt"}
"""What there is room for."""


class StatusPage:
    """Implements `Page`; any key leaves it."""

    marked: int | None = None

    def __init__(self, health: SettingsHealth) -> None:
        self._health = health

    def lines(self) -> list[str]:
        """As of now."""
        health = self._health
        sampling = health.sampling
        chips = sampling.chips
        return [
            "STATUS",
            two_ends("chips", _chips(chips.missing, chips.stuck)),
            two_ends("compass", COMPASS[sampling.compass.outcome]),
            two_ends("GPS", "set up" if sampling.receiver.is_running else "is being set up"),
            two_ends("GPS epochs", str(sampling.receiver.epochs)),
            two_ends("DSP", "silent" if health.dsp_is_silent else "answers"),
            two_ends("calibration", CALIBRATION[health.calibration]),
            two_ends("keys", f"{health.stuck_keys[0]} stuck" if health.stuck_keys else "ok"),
        ]

    def press(self, key: str, menu: Menu) -> None:
        """Whatever it is."""
        menu.back()


def _chips(missing: int, stuck: int) -> str:
    told = []
    if missing:
        told.append(f"no {chip_digits(missing)}")
    if stuck:
        told.append(f"stuck {chip_digits(stuck)}")
    return " ".join(told) or f"all {CHIPS}"
