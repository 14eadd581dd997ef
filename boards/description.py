"""The board description: what `board.toml` may say. Facts about hardware and tasks, no behaviour."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, PositiveInt, field_validator, model_validator

from boards.places import board_folder
from boards.validation import read_toml, validated

Matrix3 = tuple[tuple[FiniteFloat, FiniteFloat, FiniteFloat], ...]
Vector3 = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Priority = Annotated[int, Field(ge=0, le=15, examples=[3])]
INERTIAL_WORLDS = ("imu", "ten_dof")
PART_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")
"""Names of parts become parts of paths ("board.chips.U2.…"), figures ("cpu.mcu.load"), streams and files."""


class Facts(BaseModel):
    """Base of all description tables: unknown keys are errors, nothing is changed after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Task(Facts):
    """An interrupt line or software task. Lower priority number is more urgent, as on the NVIC."""

    priority: Priority
    deadline_us: float | None = Field(default=None, gt=0, examples=[1000])
    stack_bytes: int = Field(default=0, ge=0, examples=[256])


class Processor(Facts):
    """One processor, its program ("module:function"), tasks and cycle budgets."""

    part: str
    clock_hz: int = Field(ge=1_000_000, le=10_000_000_000, examples=[168_000_000])
    program: str = Field(pattern=r"^[\w.]+:\w+$", examples=["firmware.apps.car_mems.program:program"])
    crystal_error_ppm: FiniteFloat = Field(default=0.0, ge=-500, le=500, examples=[8.0])
    interrupt_entry_cycles: int = Field(default=12, ge=0, le=10_000_000, examples=[12])
    """From an interrupt's acceptance to the first instruction of its handler; 12 is a Cortex-M's own."""
    tasks: dict[str, Task] = Field(min_length=1)
    costs: dict[str, PositiveInt] = {}


class Owned(Facts):
    """Something that belongs to one processor (a log file, a timer)."""

    processor: str


class Bus(Owned):
    """An SPI or I²C bus and its master."""

    kind: Literal["spi", "i2c"]
    clock_hz: int = Field(ge=1_000, le=200_000_000, examples=[5_250_000])
    mode: int = Field(default=3, ge=0, le=3, examples=[3])


class SpiWords(Facts):
    """How the controller clocks one chip on an SPI bus: pauses between words and between transactions."""

    clock_hz: int | None = Field(default=None, ge=1_000, le=200_000_000, examples=[1_000_000])
    """Else that of the bus."""
    bits_per_word: Literal[8, 16, 32] = 8
    stall_ns: int = Field(default=0, ge=0, le=1_000_000, examples=[9_000])
    stall_clocks: int = Field(default=0, ge=0, le=1_000, examples=[1])
    high_ns: int = Field(default=0, ge=0, le=1_000_000, examples=[9_000])


class Chip(Facts):
    """One chip by reference designator: model, connection, mounting and position on the vehicle."""

    part: str
    model: str = Field(pattern=r"^[\w.]+:\w+$", examples=["boards.chips.bmi160:Bmi160"])
    bus: str | None = None
    uart: str | None = None
    name: str | None = None
    world: Literal["imu", "gnss", "compass", "ten_dof", "none"]
    """What it feels; "none": a display, keys, a switch."""
    errors: str | None = None
    mounting: Matrix3 = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    lever_arm_m: Vector3 = (0.0, 0.0, 0.0)
    arm: Vector3 | None = None
    """Of a chip on an arm of the board: its `lever_arm_m` in arm lengths, where that is not given itself."""
    second_antenna_m: Vector3 | None = None
    """Of a receiver with two antennas; `lever_arm_m` is the main one's place."""
    pins: dict[str, str] = {}
    supply: str | None = None
    spi: SpiWords | None = None
    parameters: dict[str, Any] = {}

    @property
    def is_sensor(self) -> bool:
        """Whether it feels anything."""
        return self.world != "none"

    @property
    def is_inertial(self) -> bool:
        """Whether it feels rate and force: the motion of such a chip is what a board computes."""
        return self.world in INERTIAL_WORLDS

    @model_validator(mode="after")
    def _mounting_is_a_rotation(self) -> Chip:
        rows = self.mounting
        if len(rows) != 3:
            raise ValueError(f"mounting has {len(rows)} rows; a rotation matrix has 3")
        for i in range(3):
            for j in range(3):
                dot = sum(rows[i][k] * rows[j][k] for k in range(3))
                if abs(dot - (i == j)) > 1e-6:
                    raise ValueError(
                        f"mounting rows {i + 1} and {j + 1} are not orthonormal (product {dot:g})"
                    )
        a, b, c = rows
        cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        if sum(x * y for x, y in zip(cross, c, strict=True)) < 0.0:
            raise ValueError("mounting is a reflection (determinant −1), not a rotation")
        return self


class Port(Owned):
    """A UART of a processor; without a chip at it, it is a connector to the outside."""

    baud: int = Field(ge=50, le=50_000_000, examples=[9600])


class Flash(Owned):
    """Non-volatile memory for settings."""

    blocks: int = Field(default=2, ge=1, le=4096, examples=[2])
    block_bytes: int = Field(default=2112, ge=64, le=1 << 20, examples=[2112])
    file: str = ""
    """What it holds at power-up: an image of all blocks, as `navtwin calibrate` writes it. Empty: erased."""


class CanPort(Owned):
    """A CAN controller that leads to the outside."""

    bitrate: int = Field(ge=5_000, le=1_000_000, examples=[500_000])


class Pin(Owned):
    """A processor pin on a net."""

    net: str
    use: Literal["input", "output", "capture"]
    wired: bool = True


class MemoryEnd(Facts):
    """One processor's end of a dual-port memory."""

    access_ns: int = Field(ge=1, le=100_000, examples=[30])
    """Of one word; of a bus with set-up, strobe and hold all three."""


class DualPort(Facts):
    """A dual-port memory between two processors, with a mailbox each way."""

    kind: Literal["dual-port"]
    words: int = Field(ge=1, le=1 << 24, examples=[4096])
    word_bits: Literal[16, 32] = 32
    ends: dict[str, MemoryEnd] = Field(examples=[{"fpga": {"access_ns": 20}, "dsp": {"access_ns": 30}}])
    """By processor."""

    @field_validator("ends")
    @classmethod
    def _joins_two(cls, value: dict[str, MemoryEnd]) -> dict[str, MemoryEnd]:
        if len(value) != 2:
            raise ValueError(f"names {len(value)} processors; a dual-port memory joins two")
        return value

    @property
    def processors(self) -> tuple[str, ...]:
        """Those that it joins."""
        return tuple(self.ends)


class SpiPackets(Facts):
    """Packets from one processor's SPI master to the other's SPI slave, by DMA at both ends."""

    kind: Literal["spi-packets"]
    sender: str = Field(examples=["fpga"])
    receiver: str = Field(examples=["dsp"])
    clock_hz: int = Field(ge=1_000, le=100_000_000, examples=[8_750_000])
    pause_ns: int = Field(default=0, ge=0, le=1_000_000, examples=[100])
    """Between two words of 16 bits."""

    @model_validator(mode="after")
    def _joins_two(self) -> SpiPackets:
        _must_differ(sender=self.sender, receiver=self.receiver)
        return self

    @property
    def processors(self) -> tuple[str, ...]:
        """Those that it joins."""
        return (self.sender, self.receiver)


class I2cCommands(Facts):
    """An I²C bus of its own between two processors, one of them the slave."""

    kind: Literal["i2c-commands"]
    master: str = Field(examples=["dsp"])
    slave: str = Field(examples=["fpga"])
    clock_hz: int = Field(ge=1_000, le=1_000_000, examples=[100_000])
    address: int = Field(ge=0x08, le=0x77, examples=[0x2A])

    @model_validator(mode="after")
    def _joins_two(self) -> I2cCommands:
        _must_differ(master=self.master, slave=self.slave)
        return self

    @property
    def processors(self) -> tuple[str, ...]:
        """Those that it joins."""
        return (self.master, self.slave)


def _must_differ(**ends: str) -> None:
    if len(set(ends.values())) < len(ends):
        told = " and ".join(ends)
        raise ValueError(f"{told} are both {next(iter(ends.values()))!r}; it joins two processors")


Interconnect = Annotated[DualPort | SpiPackets | I2cCommands, Field(discriminator="kind")]
"""What joins two processors."""


class Board(Facts):
    """A whole board."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$", examples=["car_mems"])
    title: str
    default_profile: str
    default_scenario: str
    processors: dict[str, Processor] = Field(min_length=1)
    buses: dict[str, Bus] = {}
    chips: dict[str, Chip] = {}
    arm_length_m: float | None = Field(default=None, ge=0.001, le=100.0, examples=[0.25])
    """Of arms that carry chips."""
    uarts: dict[str, Port] = {}
    can: dict[str, CanPort] = {}
    logs: dict[str, Owned] = {}
    flash: dict[str, Flash] = {}
    pins: dict[str, Pin] = {}
    timers: dict[str, Owned] = {}
    interconnects: dict[str, Interconnect] = {}
    profiles: dict[str, dict[str, Any]] = Field(min_length=1)

    @model_validator(mode="before")
    @classmethod
    def _arms_have_their_length(cls, data: Any) -> Any:
        chips = data.get("chips") if isinstance(data, dict) else None
        if not isinstance(chips, dict):
            return data
        length = data.get("arm_length_m")
        placed = {refdes: _on_its_arm(refdes, chip, length) for refdes, chip in chips.items()}
        return {**data, "chips": placed}

    @model_validator(mode="after")
    def _references_lead_somewhere(self) -> Board:
        owned: dict[str, Mapping[str, Owned]] = {
            "buses": self.buses,
            "uarts": self.uarts,
            "can": self.can,
            "logs": self.logs,
            "flash": self.flash,
            "pins": self.pins,
            "timers": self.timers,
        }
        for heading, names in owned.items():
            _must_be_plain(heading, names)
        _must_be_plain("processors", self.processors)
        _must_be_plain("chips", self.chips)
        _must_be_plain("profiles", self.profiles)
        _must_be_plain("interconnects", self.interconnects)
        for heading, processor in self.processors.items():
            _must_be_plain(f"processors.{heading}.tasks", processor.tasks)
        for table in owned.values():
            for name, part in table.items():
                _must_be_known("processor", part.processor, self.processors, name)
        for name, interconnect in self.interconnects.items():
            for end in interconnect.processors:
                _must_be_known("processor", end, self.processors, name)
        for refdes, chip in self.chips.items():
            has_pins_alone = not chip.is_sensor and bool(chip.pins) and chip.bus is chip.uart is None
            if (chip.bus is None) == (chip.uart is None) and not has_pins_alone:
                raise ValueError(f"chip {refdes} must name either a bus or a uart")
            if chip.bus is not None:
                _must_be_known("bus", chip.bus, self.buses, refdes)
            elif chip.uart is not None:
                _must_be_known("uart", chip.uart, self.uarts, refdes)
        _must_be_known("profile", self.default_profile, self.profiles, "default_profile")
        return self


def _on_its_arm(refdes: str, chip: Any, length: Any) -> Any:
    """The table of a chip with the lever arm that its arm makes."""
    if not isinstance(chip, dict) or "arm" not in chip or "lever_arm_m" in chip:
        return chip
    if length is None:
        raise ValueError(f"chip {refdes} sits on an arm: the board needs arm_length_m, for example 0.25")
    arm, numbers = chip["arm"], (int, float)
    if not isinstance(length, numbers) or not isinstance(arm, list):
        return chip
    return {**chip, "lever_arm_m": [length * part if isinstance(part, numbers) else part for part in arm]}


def _must_be_plain(heading: str, names: Iterable[str]) -> None:
    for name in names:
        if PART_NAME.fullmatch(name) is None:
            raise ValueError(
                f"[{heading}] {name!r}: a name consists of letters, digits, _ and -; for example {heading}.U2"
            )


def _must_be_known(kind: str, name: str, known: dict[str, Any], where: str) -> None:
    if name not in known:
        raise ValueError(
            f"{where} names the {kind} {name!r}, which the board does not have; it has: {', '.join(known)}"
        )


def load_board(name_or_path: str, edit: Callable[[dict[str, Any]], dict[str, Any]] | None = None) -> Board:
    """Load and validate a board; `edit` may change its parsed tables before. Raises DescriptionError."""
    path = board_folder(name_or_path) / "board.toml"
    data = read_toml(path)
    if edit is not None:
        data = edit(data)
    return validated(Board, data, str(path))
