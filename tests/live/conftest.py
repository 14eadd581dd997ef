"""A pseudo-terminal answers at once, so that nobody needs to wait for a USB adapter here."""

import pytest

from hal.live import bus_pirate


@pytest.fixture(autouse=True)
def _no_usb_adapter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus_pirate, "ANSWER_S", 0.004)
    monkeypatch.setattr(bus_pirate, "QUIET_S", 0.01)
