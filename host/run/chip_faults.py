"""Faults of whole chips, logs and processors; the kinds stand in `fault_kinds`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from host.run.fault_site import Effect, Site, once


def reset_chip(site: Site) -> Effect:
    """A dip of the supply: the chip begins anew."""
    site.parameters()
    chip = _able(site, "power")

    def dip() -> None:
        chip.power(False)
        chip.power(True)

    return once(site, dip)


def switch_chip_off(site: Site) -> Effect:
    """Without supply from begin to end."""
    site.parameters()
    chip = _able(site, "power")
    return once(site, lambda: chip.power(False), lambda: chip.power(True))


def _able(site: Site, ability: str) -> Any:
    """The chip of the fault. Raises ValueError when it has no such ability."""
    chip = site.of(site.board.chips, "chip")
    if not hasattr(chip, ability):
        raise ValueError(f"a {site.board.description.chips[site.fault.target].part} cannot have this fault")
    return chip


def mistake_id(site: Site) -> Effect:
    """The chip answers with another identity."""
    chip = _able(site, "pretend_id")
    wrong = site.parameters(id=0xEE)["id"]
    if not 0 <= wrong <= 0xFFFF:
        raise ValueError(f"parameters.id = {wrong}; it must lie in 0 … 65535, e.g. 238")
    return once(site, lambda: chip.pretend_id(wrong), lambda: chip.pretend_id(None))


def put_clock_off(site: Site) -> Effect:
    """The chip's own clock is fast by so much."""
    ppm = site.parameters(ppm=20_000.0)["ppm"]
    if not -100_000.0 <= ppm <= 100_000.0:
        raise ValueError(f"parameters.ppm = {ppm}; it must lie in −100000 … 100000, e.g. 20000.0")
    description = site.board.description.chips.get(site.fault.target)
    if description is not None and description.uart is not None:
        return _put_line_off(site, description.uart, description.parameters, ppm)
    assert description is not None
    chip = _able(site, "set_clock_error")
    own = float(description.parameters.get("clock_error_ppm", 0.0))
    return once(site, lambda: chip.set_clock_error(own + ppm), lambda: chip.set_clock_error(own))


def _put_line_off(site: Site, uart: str, parameters: Mapping[str, Any], ppm: float) -> Effect:
    """A chip on a serial line has its bit rate of its clock, and its samples, if it takes any by itself."""
    wire = site.board.to_board[uart]
    own = float(parameters.get("clock_error_ppm", 0.0))
    sampling = getattr(site.board.chips[site.fault.target], "set_clock_error", lambda _ppm: None)

    def begin() -> None:
        wire.forced_baud = round(wire.baud * (1.0 + ppm * 1e-6))
        sampling(own + ppm)

    def end() -> None:
        wire.forced_baud = None
        sampling(own)

    return once(site, begin, end)


def halt_chip(site: Site) -> Effect:
    """The chip's sample clock stands still."""
    site.parameters()
    chip = _able(site, "halt")
    return once(site, lambda: chip.halt(True), lambda: chip.halt(False))


def raise_flags(site: Site) -> Effect:
    """The chip raises these flags with every sample."""
    chip = _able(site, "raise_flags")
    flags = site.parameters(flags=0x20)["flags"]
    if not 0 < flags <= 0xFFFF:
        raise ValueError(f"parameters.flags = {flags}; it must lie in 1 … 65535, e.g. 32")
    return once(site, lambda: chip.raise_flags(flags), lambda: chip.raise_flags(0))


def sag_supply(site: Site) -> Effect:
    """The chip's supply is at so many volts."""
    chip = _able(site, "supply_v")
    volts = site.parameters(volts=4.6)["volts"]
    own = chip.supply_v

    def set_supply(supply_v: float) -> None:
        chip.supply_v = supply_v

    set_supply(volts)  # refused now rather than in flight
    set_supply(own)
    return once(site, lambda: set_supply(volts), lambda: set_supply(own))


def keep_busy(site: Site) -> Effect:
    """The chip's commands take longer than their delays."""
    chip = _able(site, "be_busy")
    options = site.parameters(factor=5.0, nack=False)
    factor, nacks = options["factor"], options["nack"]
    chip.be_busy(factor, nacks)  # refused now rather than in flight
    chip.be_prompt()
    return once(site, lambda: chip.be_busy(factor, nacks), chip.be_prompt)


def pull_card(site: Site) -> Effect:
    """The card of a log is pulled."""
    site.parameters()
    log = site.of(site.board.logs, "log")
    return once(site, log.remove, log.insert)


def spoil_state(site: Site) -> Effect:
    """A kernel leaves NaN behind."""
    site.parameters()
    program = site.of(site.board.programs, "processor")
    return once(site, program.spoil)


def reset_cpu(site: Site) -> Effect:
    """The processor begins anew."""
    site.parameters()
    cpu = site.of(site.board.cpus, "processor")
    return once(site, lambda: cpu.reset("fault of the scenario"))
