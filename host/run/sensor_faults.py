"""Faults of sensor elements: what a chip feels is wrong; the kinds stand in `fault_kinds`."""

from __future__ import annotations

from typing import Any

from boards.sense import Defect
from host.run.fault_site import Effect, Maker, Site


def in_sensor(kind: type[Defect], quantity: str, receiver_too: bool = False, **defaults: Any) -> Maker:
    """`quantity`: what is struck when none is named; "": the first that the chip measures."""

    def place(site: Site) -> Effect:
        chip = site.of(site.board.chips, "chip")
        options = site.parameters(**{"quantity": quantity, "axis": "all", **defaults})
        struck = _quantities(site, chip, options.pop("quantity"), receiver_too)
        defect = kind(site.start, site.end, struck, **options)
        site.board.senses[site.fault.target].defects.append(defect)
        _look_anew(site, chip)

        def lift() -> None:
            defect.end_ns = min(defect.end_ns, site.board.time.now)
            _look_anew(site, chip)

        return Effect(lambda: defect.fired, lift)

    return place


def _quantities(site: Site, chip: Any, asked: str, receiver_too: bool) -> tuple[str, ...]:
    measured: tuple[str, ...] = getattr(chip, "measures", ())
    if not measured:
        if receiver_too and asked == "all" and site.fault.target in site.board.senses:
            return ()
        raise ValueError(
            f"{site.fault.target} is no sensor of force, rate, field or pressure; of a receiver there are"
            " sensor-frozen, gnss-spoofing (drift) and gnss-position-jump"
        )
    if asked == "all":
        return measured
    if asked in ("", *measured):
        return (asked or measured[0],)
    raise ValueError(f"parameters.quantity = {asked!r}; {site.fault.target} measures {', '.join(measured)}")


def _look_anew(site: Site, chip: Any) -> None:
    """A chip that has sampled ahead does it again; before the run it has not."""
    again = getattr(chip, "look_anew", None)
    if again is not None and site.board.time.now > 0:
        again()
