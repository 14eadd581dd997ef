"""What the settings menu of this board holds."""

from __future__ import annotations

from collections.abc import Callable

from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.corrections import AXES
from firmware.apps.gfsins.menu import Choice, Item, Menu, two_ends
from firmware.apps.gfsins.menu_axis import axis_page, factor_text, offset_text
from firmware.apps.gfsins.menu_procedure import ProcedurePage
from firmware.apps.gfsins.menu_status import StatusPage
from firmware.apps.gfsins.procedures import Procedures
from firmware.apps.gfsins.sampling import Sampling
from firmware.apps.gfsins.settings_health import SettingsHealth

LABELS = {
    "accelerometers": "Accel. 12 positions",
    "rates": "Rates, turn table",
    "earth-rate": "Rates, 12 positions",
    "compass": "Compass 24 headings",
    "ellipse": "Compass ellipse",
    "alignment": "Initial alignment",
}
"""Of the procedures; one that is not here is listed by its own name."""


def menu_of(
    calibration: Calibration, sampling: Sampling, procedures: Procedures, health: SettingsHealth
) -> Menu:
    """The menu, at its first page."""
    items = [
        Item(lambda: "Status", lambda menu: menu.open(StatusPage(health))),
        Item(lambda: "Scale and offset", lambda menu: menu.open(_axes(calibration, sampling))),
        *(_procedure(procedures, name) for name in procedures.NAMES),
        Item(lambda: "Leave", lambda menu: menu.open(_leaving())),
    ]
    return Menu(Warned(Choice("SETTINGS", items), health))


class Warned:
    """Implements `Page`: the first page, whose title gives way to a warning."""

    def __init__(self, page: Choice, health: SettingsHealth) -> None:
        self._page = page
        self._health = health

    @property
    def marked(self) -> int | None:
        """As on the page."""
        return self._page.marked

    def lines(self) -> list[str]:
        """The page, or the warning above its items."""
        title, *items = self._page.lines()
        warning = self._health.warning()
        return [title if warning is None else f"! {warning}", *items]

    def press(self, key: str, menu: Menu) -> None:
        """The page's affair."""
        self._page.press(key, menu)


def _procedure(procedures: Procedures, name: str) -> Item:
    def begin(menu: Menu) -> None:
        menu.open(ProcedurePage(LABELS.get(name, name), name, procedures))

    return Item(lambda: LABELS.get(name, name), begin)


def _axes(calibration: Calibration, sampling: Sampling) -> Choice:
    corrections = calibration.corrections

    def item(axis: int) -> Item:
        def text() -> str:
            factor, offset = factor_text(corrections, axis), offset_text(corrections, axis)
            return two_ends(f"A{axis + 1} {factor}", offset)

        def chosen(menu: Menu) -> None:
            menu.open(axis_page(axis, calibration, sampling))

        return Item(text, chosen)

    return Choice("Scale, offset", [item(axis) for axis in range(AXES)])


def _leaving() -> Choice:
    return Choice("Leave settings?", [_plain("No", lambda menu: menu.back()), _plain("Yes, start", _leave)])


def _plain(text: str, chosen: Callable[[Menu], None]) -> Item:
    return Item(lambda: text, chosen)


def _leave(menu: Menu) -> None:
    menu.has_left = True
