"""The kinds of faults that strike a board: on wires, in chips, in sensor elements, in processors.

| kind | target | parameters |
| --- | --- | --- |
| spi-bit-errors | SPI device | probability a bit, line = "miso" or "mosi" |
| spi-missing | SPI device | level = true: reads 0xFF, false: 0x00 |
| spi-stuck | SPI device | the same, but the chip hears |
| spi-register | SPI device | register, value: reads of one register give value |
| spi-word-slip | SPI device | bits: answers come so many clocks late |
| spi-late | SPI device | each answer is that of the transaction before |
| spi-frozen | SPI device | every request gets the answer that it got first |
| spi-swapped | SPI device | with: the device whose chip has its wires; "" the next of its part |
| spi-byte-loss, spi-byte-duplication | SPI device | probability a byte of the answer |
| i2c-nack | I²C device or command channel | byte = −1: the address is refused; 0, 1, …: from that byte on |
| i2c-bit-errors | the same | probability a bit, line = "read" or "write" |
| i2c-clock-stretch | the same | hold_ms: the clock is held low so long |
| i2c-stuck | I²C bus or command channel | line = "sda" or "scl", level |
| uart-… | UART | line = "rx": into the processor, "tx": out of it |
| can-disturbance | CAN bus | no frame gets through |
| packet-loss, packet-word-slip | packet link | probability a packet |
| packet-bit-errors | packet link | probability a bit |
| pin-stuck | net | level: a data-ready or time pulse that nobody sees |
| sensor-frozen | reference designator | quantity = "all" or one, axis |
| sensor-stuck, -saturated, -drift | reference designator | quantity = "" (its first) or one, axis |
| sensor-turned | reference designator | quantity = "all" or one, axis about which it is turned by 180° |
| chip-reset | reference designator | a dip of the supply: brown-out reset |
| chip-off | reference designator | supply off for the duration |
| chip-wrong-id | reference designator | id that it answers with |
| chip-clock | reference designator | ppm by which its clock is fast |
| chip-halt | reference designator | its sample clock stands still: stale data |
| chip-flags | reference designator | flags that it raises with every sample |
| chip-supply | reference designator | volts of its supply |
| chip-busy | reference designator | factor by which the delays of its commands are longer, nack |
| log-removed | log | the card is pulled |
| nav-nan | processor | a kernel leaves NaN behind in its state |
| cpu-reset | processor | reset of the processor |

Defaults and meaning stand in docs/scenarios.md. What the simulated receiver itself gets wrong is in
`host.sim.gnss.faults`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from boards.description import Board
from boards.hints import did_you_mean
from boards.sense import Defect, Drift, Frozen, Saturated, Stuck, Turned
from hal.emulated import faults as wire_faults
from hal.emulated.virtual_time import FAR
from host.run.fault_site import Effect, Site

Maker = Callable[[Site], Effect]


def _on_spi(kind: type[wire_faults.SpiFault], fixed: dict[str, Any] | None = None, **defaults: Any) -> Maker:
    def place(site: Site) -> Effect:
        options = site.parameters(**defaults)
        if "probability" in defaults:
            options |= site.stream
        fault = kind(site.start, site.end, **options, **(fixed or {}))
        fault.install(site.of(site.board.spi_devices, "SPI device"))
        return Effect(lambda: fault.fired, fault.lift)

    return place


def _override_register(site: Site) -> Effect:
    """Chips whose registers are no bytes behind a read bit are asked themselves."""
    device = site.of(site.board.spi_devices, "SPI device")
    chips = site.board.description.chips.items()
    refdes = next(refdes for refdes, chip in chips if (chip.name or refdes) == device.name)
    chip = site.board.chips[refdes]
    if not hasattr(chip, "override_register"):
        return _on_spi(wire_faults.SpiRegisterOverride, register=0x00, value=0x00)(site)
    options = site.parameters(register=chip.identity_register, value=0x00)
    register, value = options["register"], options["value"]
    chip.override_register(register, value)  # refused now rather than in flight
    chip.override_register(register, None)
    effect = _once(
        site,
        lambda: chip.override_register(register, value),
        lambda: chip.override_register(register, None),
    )
    return Effect(lambda: chip.overridden_reads, effect.lift)


def _swap_chips(site: Site) -> Effect:
    """The chips of two devices of the same part have each other's wires."""
    devices = site.board.spi_devices
    device = site.of(devices, "SPI device")
    name = site.parameters(**{"with": ""})["with"] or partner_of(site.board.description, device.name)
    if name not in devices:
        hint = did_you_mean(name, devices)
        raise ValueError(f'parameters.with = "{name}": the board has no such SPI device; {hint}')
    one, other = (wire_faults.SpiSwappedChips(site.start, site.end) for _ in range(2))
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


def _on_i2c(kind: type[wire_faults.I2cFault], **defaults: Any) -> Maker:
    def place(site: Site) -> Effect:
        options = site.parameters(**defaults)
        if "probability" in defaults:
            options |= site.stream
        fault = kind(site.start, site.end, **options)
        fault.install(*site.of(site.board.i2c_targets, "I2C device"))
        return Effect(lambda: fault.fired, fault.lift)

    return place


def _stick_i2c(site: Site) -> Effect:
    fault = wire_faults.I2cStuckLine(site.start, site.end, **site.parameters(line="sda", level=False))
    fault.install(site.of(site.board.i2c_lines, "I2C bus"))
    return Effect(lambda: fault.fired, fault.lift)


def _on_uart(kind: Callable[..., wire_faults.UartFault], **defaults: Any) -> Maker:
    def place(site: Site) -> Effect:
        options = site.parameters(**defaults, line="rx")
        line = options.pop("line")
        if line not in ("rx", "tx"):
            raise ValueError(f"parameters.line = {line!r}; it is 'rx' (into the processor) or 'tx'")
        ends_by_itself = kind is wire_faults.UartGarbage
        if "probability" in defaults or ends_by_itself:
            options |= site.stream
        times = (site.start,) if ends_by_itself else (site.start, site.end)
        fault = kind(*times, **options)
        fault.install(site.of(site.board.to_board if line == "rx" else site.board.from_board, "UART"))
        return Effect(lambda: fault.fired, None if ends_by_itself else fault.lift)

    return place


def _overrun_port(site: Site) -> Effect:
    options = site.parameters(probability=1e-2)
    fault = wire_faults.UartOverrun(site.start, site.end, **options, **site.stream)
    fault.install_at(site.of(site.board.ports, "UART"))
    return Effect(lambda: fault.fired, fault.lift)


def _on_packets(kind: Callable[..., wire_faults.PacketFault], probability: float) -> Maker:
    def place(site: Site) -> Effect:
        options = site.parameters(probability=probability)
        fault = kind(site.start, site.end, **options, **site.stream)
        fault.install(site.of(site.board.packet_senders, "packet link"))
        return Effect(lambda: fault.fired, fault.lift)

    return place


def _disturb_can(site: Site) -> Effect:
    site.parameters()
    fault = wire_faults.CanDisturbance(site.start, site.end)
    fault.install(site.of(site.board.can_buses, "CAN bus"))
    return Effect(lambda: fault.fired, fault.lift)


def _stick_pin(site: Site) -> Effect:
    fault = wire_faults.PinStuck(site.start, site.end, **site.parameters(level=False))
    fault.install(site.of(site.board.nets, "net"))
    return Effect(lambda: fault.fired, fault.lift)


# -- sensor elements -------------------------------------------------------------------------------


def _in_sensor(kind: type[Defect], quantity: str, receiver_too: bool = False, **defaults: Any) -> Maker:
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


# -- chips and processors --------------------------------------------------------------------------


def _once(site: Site, begin: Callable[[], Any], end: Callable[[], Any] | None = None) -> Effect:
    """A fault that happens at an instant, and perhaps ends at another."""
    fired = 0
    over = False

    def strike() -> None:
        nonlocal fired
        if not over:
            fired += 1
            begin()

    def pass_over() -> None:
        nonlocal over
        if fired and not over and end is not None:
            end()
        over = True

    site.board.time.at(site.start, strike)
    if end is None:
        return Effect(lambda: fired)
    if site.end < FAR:
        site.board.time.at(site.end, pass_over)
    return Effect(lambda: fired, pass_over)


def _reset_chip(site: Site) -> Effect:
    site.parameters()
    chip = _able(site, "power")

    def dip() -> None:
        chip.power(False)
        chip.power(True)

    return _once(site, dip)


def _switch_chip_off(site: Site) -> Effect:
    site.parameters()
    chip = _able(site, "power")
    return _once(site, lambda: chip.power(False), lambda: chip.power(True))


def _able(site: Site, ability: str) -> Any:
    """The chip of the fault. Raises ValueError when it has no such ability."""
    chip = site.of(site.board.chips, "chip")
    if not hasattr(chip, ability):
        raise ValueError(f"a {site.board.description.chips[site.fault.target].part} cannot have this fault")
    return chip


def _mistake_id(site: Site) -> Effect:
    chip = _able(site, "pretend_id")
    wrong = site.parameters(id=0xEE)["id"]
    if not 0 <= wrong <= 0xFFFF:
        raise ValueError(f"parameters.id = {wrong}; it must lie in 0 … 65535, e.g. 238")
    return _once(site, lambda: chip.pretend_id(wrong), lambda: chip.pretend_id(None))


def _put_clock_off(site: Site) -> Effect:
    ppm = site.parameters(ppm=20_000.0)["ppm"]
    if not -100_000.0 <= ppm <= 100_000.0:
        raise ValueError(f"parameters.ppm = {ppm}; it must lie in −100000 … 100000, e.g. 20000.0")
    description = site.board.description.chips.get(site.fault.target)
    if description is not None and description.uart is not None:
        return _put_line_off(site, description.uart, description.parameters, ppm)
    assert description is not None
    chip = _able(site, "set_clock_error")
    own = float(description.parameters.get("clock_error_ppm", 0.0))
    return _once(site, lambda: chip.set_clock_error(own + ppm), lambda: chip.set_clock_error(own))


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

    return _once(site, begin, end)


def _halt_chip(site: Site) -> Effect:
    site.parameters()
    chip = _able(site, "halt")
    return _once(site, lambda: chip.halt(True), lambda: chip.halt(False))


def _raise_flags(site: Site) -> Effect:
    chip = _able(site, "raise_flags")
    flags = site.parameters(flags=0x20)["flags"]
    if not 0 < flags <= 0xFFFF:
        raise ValueError(f"parameters.flags = {flags}; it must lie in 1 … 65535, e.g. 32")
    return _once(site, lambda: chip.raise_flags(flags), lambda: chip.raise_flags(0))


def _sag_supply(site: Site) -> Effect:
    chip = _able(site, "supply_v")
    volts = site.parameters(volts=4.6)["volts"]
    own = chip.supply_v

    def set_supply(supply_v: float) -> None:
        chip.supply_v = supply_v

    set_supply(volts)  # refused now rather than in flight
    set_supply(own)
    return _once(site, lambda: set_supply(volts), lambda: set_supply(own))


def _keep_busy(site: Site) -> Effect:
    chip = _able(site, "be_busy")
    options = site.parameters(factor=5.0, nack=False)
    factor, nacks = options["factor"], options["nack"]
    chip.be_busy(factor, nacks)  # refused now rather than in flight
    chip.be_prompt()
    return _once(site, lambda: chip.be_busy(factor, nacks), chip.be_prompt)


def _pull_card(site: Site) -> Effect:
    site.parameters()
    log = site.of(site.board.logs, "log")
    return _once(site, log.remove, log.insert)


def _spoil_state(site: Site) -> Effect:
    site.parameters()
    program = site.of(site.board.programs, "processor")
    return _once(site, program.spoil)


def _reset_cpu(site: Site) -> Effect:
    site.parameters()
    cpu = site.of(site.board.cpus, "processor")
    return _once(site, lambda: cpu.reset("fault of the scenario"))


KINDS: dict[str, Maker] = {
    "spi-bit-errors": _on_spi(wire_faults.SpiBitErrors, probability=1e-4, line="miso"),
    "spi-missing": _on_spi(wire_faults.SpiMissingChip, level=True),
    "spi-stuck": _on_spi(wire_faults.SpiStuckMiso, level=True),
    "spi-register": _override_register,
    "spi-word-slip": _on_spi(wire_faults.SpiWordSlip, bits=1),
    "spi-late": _on_spi(wire_faults.SpiLateAnswers),
    "spi-frozen": _on_spi(wire_faults.SpiFrozenAnswers),
    "spi-swapped": _swap_chips,
    "spi-byte-loss": _on_spi(wire_faults.SpiByteSlips, probability=1e-3),
    "spi-byte-duplication": _on_spi(wire_faults.SpiByteSlips, {"doubled": True}, probability=1e-3),
    "i2c-nack": _on_i2c(wire_faults.I2cNack, byte=-1),
    "i2c-bit-errors": _on_i2c(wire_faults.I2cBitErrors, probability=1e-4, line="read"),
    "i2c-clock-stretch": _on_i2c(wire_faults.I2cClockStretch, hold_ms=2.0),
    "i2c-stuck": _stick_i2c,
    "uart-cut": _on_uart(wire_faults.UartCut),
    "uart-bit-errors": _on_uart(wire_faults.UartBitErrors, probability=1e-3),
    "uart-byte-loss": _on_uart(wire_faults.UartByteLoss, probability=1e-2),
    "uart-byte-duplication": _on_uart(wire_faults.UartByteDuplication, probability=1e-2),
    "uart-framing-errors": _on_uart(wire_faults.UartFramingErrors, probability=1e-2),
    "uart-parity": _on_uart(wire_faults.UartParity),
    "uart-overrun": _overrun_port,
    "uart-truncation": _on_uart(wire_faults.UartTruncation, keep=20),
    "uart-wrong-baud": _on_uart(wire_faults.UartWrongBaud, baud=38_400),
    "uart-garbage": _on_uart(wire_faults.UartGarbage, length=500),
    "can-disturbance": _disturb_can,
    "packet-loss": _on_packets(wire_faults.PacketLoss, 1.0),
    "packet-bit-errors": _on_packets(wire_faults.PacketBitErrors, 1e-4),
    "packet-word-slip": _on_packets(wire_faults.PacketWordSlip, 0.01),
    "pin-stuck": _stick_pin,
    "sensor-frozen": _in_sensor(Frozen, "all", receiver_too=True),
    "sensor-stuck": _in_sensor(Stuck, "", value=0.0),
    "sensor-saturated": _in_sensor(Saturated, "", negative=False),
    "sensor-drift": _in_sensor(Drift, "", rate=0.01),
    "sensor-turned": _in_sensor(Turned, "all", axis="z"),
    "chip-reset": _reset_chip,
    "chip-off": _switch_chip_off,
    "chip-wrong-id": _mistake_id,
    "chip-clock": _put_clock_off,
    "chip-halt": _halt_chip,
    "chip-flags": _raise_flags,
    "chip-supply": _sag_supply,
    "chip-busy": _keep_busy,
    "log-removed": _pull_card,
    "nav-nan": _spoil_state,
    "cpu-reset": _reset_cpu,
}
