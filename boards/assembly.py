"""Puts a board together from its description: processors, buses, chips and wires on one virtual time.

What lies outside the board (the world its sensors feel, where its log goes) comes through `Surroundings`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from boards.chips.world import CompassWorld, GnssWorld, ImuWorld, TenDofWorld
from boards.description import Board, Chip, Flash, I2cCommands, Processor
from boards.interconnects import Ends, build, ends_of
from boards.machine import Machine
from boards.sense import Sense
from boards.validation import DescriptionError
from hal.board_io import BoardIo, Named, NotNamedError, Program
from hal.emulated.can import EmulatedCanBus, EmulatedCanController
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.flash import EmulatedFlash
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.packet_link import EmulatedPacketSender
from hal.emulated.pins import EmulatedInputPin, EmulatedOutputPin, Net
from hal.emulated.spi import EmulatedSpiBus, EmulatedSpiDevice, SpiTiming
from hal.emulated.storage import EmulatedLogFile
from hal.emulated.timers import EmulatedCaptureTimer, EmulatedPeriodicTimer
from hal.emulated.uart import EmulatedUart, UartWire
from hal.emulated.virtual_time import VirtualTime
from hal.emulated.watchdog import EmulatedWatchdog

TX_QUEUE_BYTES = 4096


class Surroundings(Protocol):
    """What lies outside the board."""

    def imu(self, refdes: str, chip: Chip) -> ImuWorld:
        """What the inertial chip `refdes` feels."""
        ...

    def gnss(self, refdes: str, chip: Chip) -> GnssWorld:
        """What the receiver `refdes` sees."""
        ...

    def compass(self, refdes: str, chip: Chip) -> CompassWorld:
        """What the compass `refdes` feels."""
        ...

    def ten_dof(self, refdes: str, chip: Chip) -> TenDofWorld:
        """What the sensor `refdes` of rate, force, magnetic field and pressure feels."""
        ...

    def log_sink(self, name: str) -> Callable[[bytes], None]:
        """Where the blocks of the log file `name` go."""
        ...


@dataclass
class AssembledBoard:
    """A board ready to run, with everything on it by its name in the description."""

    description: Board
    machine: Machine
    cpus: dict[str, EmulatedCpu] = field(default_factory=dict)
    programs: dict[str, Program] = field(default_factory=dict)
    spi_buses: dict[str, EmulatedSpiBus] = field(default_factory=dict)
    spi_devices: dict[str, EmulatedSpiDevice] = field(default_factory=dict)
    i2c_buses: dict[str, EmulatedI2cBus] = field(default_factory=dict)
    to_board: dict[str, UartWire] = field(default_factory=dict)
    """For each UART the wire into the processor."""
    from_board: dict[str, UartWire] = field(default_factory=dict)
    can_buses: dict[str, EmulatedCanBus] = field(default_factory=dict)
    i2c_devices: dict[str, tuple[EmulatedI2cBus, int]] = field(default_factory=dict)
    """Bus and address of each chip on I²C, by the firmware's name."""
    chips: dict[str, Any] = field(default_factory=dict)
    """Chip models by reference designator."""
    senses: dict[str, Sense] = field(default_factory=dict)
    """What each chip feels, and the defects of its sensor."""
    nets: dict[str, Net] = field(default_factory=dict)
    logs: dict[str, EmulatedLogFile] = field(default_factory=dict)
    flash: dict[str, EmulatedFlash] = field(default_factory=dict)
    ports: dict[str, EmulatedUart] = field(default_factory=dict)
    interconnects: dict[str, Ends] = field(default_factory=dict)
    """Of each interconnect the ends, by processor."""
    _can_ports: dict[str, EmulatedCanController] = field(default_factory=dict)

    @property
    def packet_senders(self) -> dict[str, EmulatedPacketSender]:
        """Of each packet link the master's end."""
        ends = ((name, end) for name, ends in self.interconnects.items() for end in ends.values())
        return {name: end for name, end in ends if isinstance(end, EmulatedPacketSender)}

    @property
    def i2c_lines(self) -> dict[str, EmulatedI2cBus]:
        """Every pair of I²C lines: those of chips and those between processors."""
        ends = ((name, end) for name, ends in self.interconnects.items() for end in ends.values())
        return self.i2c_buses | {name: end for name, end in ends if isinstance(end, EmulatedI2cBus)}

    @property
    def i2c_targets(self) -> dict[str, tuple[EmulatedI2cBus, int]]:
        """Line and address of every slave: chips by the firmware's name, processors by the interconnect's."""
        joints = self.description.interconnects.items()
        commands = {name: joint.address for name, joint in joints if isinstance(joint, I2cCommands)}
        lines = self.i2c_lines
        return self.i2c_devices | {name: (lines[name], address) for name, address in commands.items()}

    @property
    def time(self) -> VirtualTime:
        """The virtual time that everything on the board shares."""
        return self.machine.time

    def net(self, name: str) -> Net:
        """The net `name`, made at first use."""
        if name not in self.nets:
            self.nets[name] = Net(self.time, name)
        return self.nets[name]


def assemble(description: Board, profile: Mapping[str, Any], surroundings: Surroundings) -> AssembledBoard:
    """Build the board. DescriptionError: a program or chip cannot be had, or refuses its settings."""
    board = AssembledBoard(description, Machine(VirtualTime()))
    for name, processor in description.processors.items():
        board.cpus[name] = _cpu(board, name, processor)
    _wires(board)
    for refdes, chip in description.chips.items():
        _place_chip(board, refdes, chip, surroundings)
    installation = installation_of(description)
    for name, processor in description.processors.items():
        io = _board_io(board, name, surroundings)
        board.programs[name] = _program(processor, io, profile, installation, name)
        board.machine.add(board.cpus[name], board.programs[name].main)
    return board


def _cpu(board: AssembledBoard, name: str, processor: Processor) -> EmulatedCpu:
    lines = [
        LineSpec(
            task_name,
            task.priority,
            None if task.deadline_us is None else round(task.deadline_us * 1000),
            task.stack_bytes,
        )
        for task_name, task in processor.tasks.items()
    ]
    error_ppb = round(processor.crystal_error_ppm * 1000)
    return EmulatedCpu(
        board.time,
        name,
        processor.clock_hz,
        lines,
        processor.costs,
        error_ppb,
        processor.interrupt_entry_cycles,
    )


def _wires(board: AssembledBoard) -> None:
    """Buses, UARTs and CAN with their controllers, and what joins the processors."""
    description = board.description
    for name, bus in description.buses.items():
        cpu = board.cpus[bus.processor]
        if bus.kind == "spi":
            board.spi_buses[name] = EmulatedSpiBus(cpu, SpiTiming(bus.clock_hz), name)
        else:
            try:
                board.i2c_buses[name] = EmulatedI2cBus(cpu, bus.clock_hz, name)
            except ValueError as error:
                raise DescriptionError(f"buses.{name}.clock_hz = {bus.clock_hz}: {error}") from None
    for name, port in description.uarts.items():
        outward = UartWire(board.time, port.baud, f"{name}.tx", TX_QUEUE_BYTES)
        inward = UartWire(board.time, port.baud, f"{name}.rx")
        board.from_board[name], board.to_board[name] = outward, inward
        board.ports[name] = EmulatedUart(board.cpus[port.processor], outward, inward, name)
    for name, can in description.can.items():
        board.can_buses[name] = EmulatedCanBus(board.time, can.bitrate, name)
        node = EmulatedCanController(board.cpus[can.processor], board.can_buses[name], can.processor)
        board._can_ports[name] = node
    for name, interconnect in description.interconnects.items():
        board.interconnects[name] = build(name, interconnect, board.cpus)


def _place_chip(board: AssembledBoard, refdes: str, chip: Chip, surroundings: Surroundings) -> None:
    model = _named(chip.model, f"chip {refdes}")
    feels = getattr(model, "feels", chip.world)
    if chip.world != feels:
        raise DescriptionError(f'chips.{refdes}.world = "{chip.world}": a {chip.part} feels "{feels}"')
    arguments: list[Any] = [board.time]
    if chip.is_sensor:
        sense = Sense(getattr(surroundings, chip.world)(refdes, chip))
        board.senses[refdes] = sense
        arguments.append(sense)
    if chip.uart is not None:
        arguments.append(board.to_board[chip.uart])
    try:
        placed = model(*arguments, **chip.parameters)
    except (TypeError, ValueError) as error:
        raise DescriptionError(
            f"chips.{refdes}.parameters = {chip.parameters!r} do not suit {chip.model}: {error}"
        ) from None
    board.chips[refdes] = placed
    _check_wiring(board.description, refdes, chip, placed)
    for pin, net in chip.pins.items():
        placed.pins[pin] = board.net(net)
    if chip.bus is not None:
        _connect_to_bus(board, refdes, chip, placed)
    elif chip.uart is not None:
        wire = board.from_board[chip.uart]
        wire.connect(placed, rate_of=board.to_board[chip.uart])
    begin = getattr(placed, "wired", None)
    if begin is not None:
        begin()
    if chip.supply is not None:
        placed.power(False)
        board.net(chip.supply).listen(lambda level, _time_ns: placed.power(level))


def _check_wiring(description: Board, refdes: str, chip: Chip, placed: Any) -> None:
    """Pins that the chip does not have, a supply that nobody switches, a clock mode it does not know."""
    for pin in chip.pins:
        if pin not in placed.pins:
            raise DescriptionError(
                f"chips.{refdes}.pins names {pin!r}; a {chip.part} has the pins {', '.join(placed.pins)}"
            )
    outputs = [pin.net for pin in description.pins.values() if pin.use == "output" and pin.wired]
    if chip.supply is not None and chip.supply not in outputs:
        raise DescriptionError(
            f"chips.{refdes}.supply = {chip.supply!r}: no output pin drives that net; "
            f"driven are: {', '.join(outputs) or 'none'}"
        )
    mode = description.buses[chip.bus].mode if chip.bus is not None else None
    modes = getattr(placed, "spi_modes", (mode,))
    if mode is not None and description.buses[str(chip.bus)].kind == "spi" and mode not in modes:
        raise DescriptionError(
            f"buses.{chip.bus}.mode = {mode}: a {chip.part} works in SPI modes {', '.join(map(str, modes))}"
        )


def _connect_to_bus(board: AssembledBoard, refdes: str, chip: Chip, placed: Any) -> None:
    assert chip.bus is not None
    name = chip.name or refdes
    if chip.bus in board.spi_buses:
        bus = board.spi_buses[chip.bus]
        board.spi_devices[name] = bus.device(placed, name, _spi_timing(chip, bus.timing))
    else:
        board.i2c_buses[chip.bus].attach(placed.i2c.address, placed.i2c)
        board.i2c_devices[name] = (board.i2c_buses[chip.bus], placed.i2c.address)


def _spi_timing(chip: Chip, bus: SpiTiming) -> SpiTiming:
    """How the controller clocks this chip."""
    words = chip.spi
    if words is None:
        return bus
    return SpiTiming(
        words.clock_hz or bus.frequency_hz,
        words.bits_per_word,
        words.stall_ns,
        words.stall_clocks,
        high_ns=words.high_ns,
    )


def _board_io(board: AssembledBoard, processor: str, surroundings: Surroundings) -> BoardIo:
    """What is wired to one processor, by the firmware's names."""
    description = board.description
    cpu = board.cpus[processor]

    def mine(table: Mapping[str, Any]) -> list[str]:
        return [name for name, part in table.items() if part.processor == processor]

    def nets(use: str) -> dict[str, Net]:
        pins = {name: description.pins[name] for name in mine(description.pins)}
        return {name: board.net(pin.net) for name, pin in pins.items() if pin.use == use and pin.wired}

    for name in mine(description.logs):
        board.logs[name] = EmulatedLogFile(cpu, surroundings.log_sink(name))
    for name in mine(description.flash):
        board.flash[name] = _flash(cpu, name, description.flash[name])
    own_buses = mine(description.buses)
    spi = {
        chip.name or refdes: board.spi_devices[chip.name or refdes]
        for refdes, chip in description.chips.items()
        if chip.bus in own_buses and chip.bus in board.spi_buses
    }
    return BoardIo(
        cpu=cpu,
        clock=cpu,
        interrupts=cpu,
        watchdog=EmulatedWatchdog(cpu),
        spi=spi,
        i2c={name: board.i2c_buses[name] for name in own_buses if name in board.i2c_buses},
        uart={name: board.ports[name] for name in mine(description.uarts)},
        can={name: board._can_ports[name] for name in mine(description.can)},
        outputs={name: EmulatedOutputPin(cpu, net) for name, net in nets("output").items()},
        inputs={name: EmulatedInputPin(cpu, net) for name, net in nets("input").items()},
        captures={name: EmulatedCaptureTimer(cpu, net) for name, net in nets("capture").items()},
        timers={name: EmulatedPeriodicTimer(cpu) for name in mine(description.timers)},
        logs={name: board.logs[name] for name in mine(description.logs)},
        flash={name: board.flash[name] for name in mine(description.flash)},
        **ends_of(processor, description.interconnects, board.interconnects),
    )


def _flash(cpu: EmulatedCpu, name: str, facts: Flash) -> EmulatedFlash:
    """The memory with what it held when it was last switched off."""
    memory = EmulatedFlash(cpu, name, facts.blocks, facts.block_bytes)
    if facts.file:
        try:
            memory.load(Path(facts.file).read_bytes())
        except (OSError, ValueError) as error:
            told = error.strerror if isinstance(error, OSError) else error
            raise DescriptionError(
                f'flash.{name}.file = "{facts.file}": {told}; for example the file that'
                " `navtwin calibrate --store FILE` writes"
            ) from None
    return memory


def installation_of(description: Board) -> dict[str, Any]:
    """Mounting, lever arm and second antenna of each device, by the firmware's name for it."""
    chips = {chip.name or chip.uart or refdes: _place_of(chip) for refdes, chip in description.chips.items()}
    return Named("a chip called", chips)


def _place_of(chip: Chip) -> dict[str, Any]:
    place = {"C_b_s": chip.mounting, "lever_arm_m": chip.lever_arm_m}
    return place if chip.second_antenna_m is None else place | {"second_antenna_m": chip.second_antenna_m}


def _program(
    processor: Processor,
    io: BoardIo,
    profile: Mapping[str, Any],
    installation: Mapping[str, Any],
    name: str,
) -> Program:
    factory = _named(processor.program, f"processor {name}")
    try:
        program: Program = factory(io, profile, installation)
    except ValueError as error:
        raise DescriptionError(f"profile for processor {name}: {error}") from None
    except NotNamedError as error:
        raise DescriptionError(f"processors.{name}: {error}") from None
    return program


def _named(target: str, where: str) -> Any:
    """The object behind "module:name"."""
    module_name, _, attribute = target.partition(":")
    try:
        return getattr(import_module(module_name), attribute)
    except (ImportError, AttributeError) as error:
        raise DescriptionError(f"{where} names {target!r}, which cannot be loaded: {error}") from None
