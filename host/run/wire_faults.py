"""Faults on wires: buses, serial lines, packet links, CAN, pins; the kinds stand in `fault_kinds`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from boards.description import Board
from boards.hints import did_you_mean
from hal.emulated import faults
from host.run.fault_site import Effect, Maker, Site, once


def on_spi(kind: type[faults.SpiFault], fixed: dict[str, Any] | None = None, **defaults: Any) -> Maker:
    """A fault between an SPI device and its chip; `fixed`: what a scenario cannot choose."""

    def place(site: Site) -> Effect:
        options = site.parameters(**defaults)
        if "probability" in defaults:
            options |= site.stream
        fault = kind(site.start, site.end, **options, **(fixed or {}))
        fault.install(site.of(site.board.spi_devices, "SPI device"))
        return Effect(lambda: fault.fired, fault.lift)

    return place


def override_register(site: Site) -> Effect:
    """Chips whose registers are no bytes behind a read bit are asked themselves."""
    device = site.of(site.board.spi_devices, "SPI device")
    chips = site.board.description.chips.items()
    refdes = next(refdes for refdes, chip in chips if (chip.name or refdes) == device.name)
    chip = site.board.chips[refdes]
    if not hasattr(chip, "override_register"):
        return on_spi(faults.SpiRegisterOverride, register=0x00, value=0x00)(site)
    options = site.parameters(register=chip.identity_register, value=0x00)
    register, value = options["register"], options["value"]
    chip.override_register(register, value)  # refused now rather than in flight
    chip.override_register(register, None)
    effect = once(
        site,
        lambda: chip.override_register(register, value),
        lambda: chip.override_register(register, None),
    )
    return Effect(lambda: chip.overridden_reads, effect.lift)


def swap_chips(site: Site) -> Effect:
    """The chips of two devices of the same part have each other's wires."""
    devices = site.board.spi_devices
    device = site.of(devices, "SPI device")
    name = site.parameters(**{"with": ""})["with"] or partner_of(site.board.description, device.name)
    if name not in devices:
        hint = did_you_mean(name, devices)
        raise ValueError(f'parameters.with = "{name}": the board has no such SPI device; {hint}')
    one, other = (faults.SpiSwappedChips(site.start, site.end) for _ in range(2))
    one.install_with(device, devices[name], other)

    def lift() -> None:
        one.lift()
        other.lift()

    return Effect(lambda: one.fired + other.fired, lift)


def partner_of(board: Board, name: str) -> str:
    """The SPI device behind that one with a chip of the same part, in the order of the board; behind the last
    comes the first. Raises ValueError when there is none."""
    part = next(chip.part for refdes, chip in board.chips.items() if (chip.name or refdes) == name)
    alike = [
        chip.name or refdes
        for refdes, chip in board.chips.items()
        if chip.part == part and chip.bus is not None and board.buses[chip.bus].kind == "spi"
    ]
    if len(alike) < 2:
        raise ValueError(f"the board has no other {part} on SPI; name a device, parameters.with")
    return alike[(alike.index(name) + 1) % len(alike)]


def on_i2c(kind: type[faults.I2cFault], **defaults: Any) -> Maker:
    """A fault between an I²C bus and one of its targets."""

    def place(site: Site) -> Effect:
        options = site.parameters(**defaults)
        if "probability" in defaults:
            options |= site.stream
        fault = kind(site.start, site.end, **options)
        fault.install(*site.of(site.board.i2c_targets, "I2C device"))
        return Effect(lambda: fault.fired, fault.lift)

    return place


def stick_i2c(site: Site) -> Effect:
    """A line of an I²C bus is held."""
    fault = faults.I2cStuckLine(site.start, site.end, **site.parameters(line="sda", level=False))
    fault.install(site.of(site.board.i2c_lines, "I2C bus"))
    return Effect(lambda: fault.fired, fault.lift)


def on_uart(kind: Callable[..., faults.UartFault], **defaults: Any) -> Maker:
    """A fault on one direction of a serial line."""

    def place(site: Site) -> Effect:
        options = site.parameters(**defaults, line="rx")
        line = options.pop("line")
        if line not in ("rx", "tx"):
            raise ValueError(f"parameters.line = {line!r}; it is 'rx' (into the processor) or 'tx'")
        ends_by_itself = kind is faults.UartGarbage
        if "probability" in defaults or ends_by_itself:
            options |= site.stream
        times = (site.start,) if ends_by_itself else (site.start, site.end)
        fault = kind(*times, **options)
        fault.install(site.of(site.board.to_board if line == "rx" else site.board.from_board, "UART"))
        return Effect(lambda: fault.fired, None if ends_by_itself else fault.lift)

    return place


def overrun_port(site: Site) -> Effect:
    """The port's receiver comes too late for bytes."""
    options = site.parameters(probability=1e-2)
    fault = faults.UartOverrun(site.start, site.end, **options, **site.stream)
    fault.install_at(site.of(site.board.ports, "UART"))
    return Effect(lambda: fault.fired, fault.lift)


def on_packets(kind: Callable[..., faults.PacketFault], probability: float) -> Maker:
    """A fault on a packet link."""

    def place(site: Site) -> Effect:
        options = site.parameters(probability=probability)
        fault = kind(site.start, site.end, **options, **site.stream)
        fault.install(site.of(site.board.packet_senders, "packet link"))
        return Effect(lambda: fault.fired, fault.lift)

    return place


def disturb_can(site: Site) -> Effect:
    """No frame gets through a CAN bus."""
    site.parameters()
    fault = faults.CanDisturbance(site.start, site.end)
    fault.install(site.of(site.board.can_buses, "CAN bus"))
    return Effect(lambda: fault.fired, fault.lift)


def stick_pin(site: Site) -> Effect:
    """A net stays at one level."""
    fault = faults.PinStuck(site.start, site.end, **site.parameters(level=False))
    fault.install(site.of(site.board.nets, "net"))
    return Effect(lambda: fault.fired, fault.lift)
