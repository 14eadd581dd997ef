"""A register file as data: addresses, access kinds, reset values, reserved bits, and what is not modelled.

Whoever touches a chip in a way that its documents do not cover (an address without a register, a reserved
bit, a write to a read-only register) or that its model leaves out (a tagged field) leaves a report. The
first of its kind is kept with its time, further ones are counted; listeners hear of every one. In strict
mode the report is raised as `UndocumentedAccessError` too, unless the documents say what the chip does
then (a command dropped with an error flag).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import Enum


class Access(Enum):
    """What the bus may do with a register."""

    READ = "R"
    READ_WRITE = "RW"
    WRITE = "W"


@dataclass(frozen=True, slots=True)
class NotModelled:
    """A tag on bits of a register: setting one of them asks for something that the model leaves out.

    `any_write`: already writing the register does.
    """

    mask: int
    reason: str
    any_write: bool = False


@dataclass(frozen=True, slots=True)
class Register:
    """One 8-bit register. `reserved` bits read as reset and ignore writes."""

    address: int
    name: str
    access: Access
    reset: int = 0
    reserved: int = 0
    not_modelled: tuple[NotModelled, ...] = ()


class ReportKind(Enum):
    """Why an access was reported."""

    UNDOCUMENTED_ADDRESS = "undocumented address"
    READ_ONLY = "write to a read-only register"
    WRITE_ONLY = "read of a write-only register"
    RESERVED_BITS = "reserved bits set"
    NOT_MODELLED = "not modelled"
    RESERVED_VALUE = "reserved value"
    TIMING = "timing rule broken"
    PROTOCOL = "protocol"
    DROPPED = "command dropped"


DOCUMENTED_REACTIONS = frozenset({ReportKind.DROPPED})
"""Reported, never raised."""


@dataclass(slots=True)
class AccessReport:
    """One kind of access that was reported: where, what, when first, how often."""

    chip: str
    kind: ReportKind
    register: str
    detail: str
    first_ns: int
    count: int = 1

    def __str__(self) -> str:
        often = f" ({self.count} times)" if self.count > 1 else ""
        return f"{self.chip} at {self.first_ns} ns: {self.kind.value}: {self.register}: {self.detail}{often}"


class UndocumentedAccessError(RuntimeError):
    """Strict mode: the firmware used the chip outside its documents or outside the model."""


Listener = Callable[[AccessReport], None]


class AccessLog:
    """Collects the reports of one chip.

    `listeners` are called with every report, also with repeated ones.
    """

    def __init__(self, chip: str, *, strict: bool = False) -> None:
        self.chip = chip
        self.strict = strict
        self.reports: list[AccessReport] = []
        self.listeners: list[Listener] = []
        self._known: dict[tuple[ReportKind, str, str], AccessReport] = {}

    def report(self, kind: ReportKind, register: str, detail: str, time_ns: int) -> None:
        """Note an access. Raises UndocumentedAccessError in strict mode."""
        key = (kind, register, detail)
        report = self._known.get(key)
        if report is None:
            report = AccessReport(self.chip, kind, register, detail, time_ns)
            self._known[key] = report
            self.reports.append(report)
        else:
            report.count += 1
        for listener in self.listeners:
            listener(report)
        if self.strict and kind not in DOCUMENTED_REACTIONS:
            raise UndocumentedAccessError(str(report))


class RegisterFile:
    """The registers of one chip as its bus sees them.

    The model keeps `values` current and installs hooks: `after_read[address]()` for what clears on read,
    `after_write[address](old, new)` for what a write sets going (called also when the value is the same).
    """

    def __init__(self, registers: Iterable[Register], log: AccessLog) -> None:
        self.registers = {register.address: register for register in registers}
        self.values = bytearray(max(self.registers) + 1)
        self.after_read: dict[int, Callable[[], None]] = {}
        self.after_write: dict[int, Callable[[int, int], None]] = {}
        self._log = log
        self._plain: dict[tuple[int, int], bool] = {}
        self._pretended: dict[int, Register] = {}
        """Registers that hold something else, as they are."""
        self.reset()

    def reset(self) -> None:
        """Load every reset value."""
        for register in self.registers.values():
            self.values[register.address] = register.reset

    def pretend(self, address: int, value: int | None) -> None:
        """Let a register have another content, now and after each reset (a wrong identity, say); None: its
        own again."""
        kept = self._pretended
        own = kept.setdefault(address, self.registers[address])
        self.registers[address] = own if value is None else replace(own, reset=value)
        self.values[address] = self.registers[address].reset

    def read(self, address: int, time_ns: int, *, running_on: bool = False) -> int:
        """One byte for the bus. An address without a register reads as 0, a write-only one as last written.

        `running_on`: a burst from another register arrives here; that it meets an address without a
        register is then no report (drivers read a byte too many).
        """
        register = self.registers.get(address)
        if register is None:
            if not running_on:
                self._log.report(ReportKind.UNDOCUMENTED_ADDRESS, f"0x{address:02X}", "read", time_ns)
            return 0
        if register.access is Access.WRITE:
            self._log.report(ReportKind.WRITE_ONLY, register.name, "read", time_ns)
        value = self.values[address]
        hook = self.after_read.get(address)
        if hook is not None:
            hook()
        return value

    def plain(self, first: int, end: int) -> bool:
        """Whether reading [first, end) only shows `values`: readable registers without hooks, as installed
        when this is first asked. A burst over them may be cut out of `values` at once."""
        span = (first, end)
        known = self._plain.get(span)
        if known is None:
            self._plain[span] = known = all(map(self._is_plain, range(first, end)))
        return known

    def _is_plain(self, address: int) -> bool:
        register = self.registers.get(address)
        readable = register is not None and register.access is not Access.WRITE
        return readable and address not in self.after_read

    def write(self, address: int, value: int, time_ns: int) -> None:
        """One byte from the bus; what may not be written is reported and ignored."""
        register = self.registers.get(address)
        if register is None:
            self._log.report(ReportKind.UNDOCUMENTED_ADDRESS, f"0x{address:02X}", "write", time_ns)
            return
        if register.access is Access.READ:
            self._log.report(ReportKind.READ_ONLY, register.name, "write ignored", time_ns)
            return
        self._check(register, value, time_ns)
        old = self.values[address]
        new = (value & ~register.reserved) | (register.reset & register.reserved)
        self.values[address] = new
        hook = self.after_write.get(address)
        if hook is not None:
            hook(old, new)

    def _check(self, register: Register, value: int, time_ns: int) -> None:
        if value & register.reserved & ~register.reset:
            detail = f"bits 0x{value & register.reserved:02X} ignored"
            self._log.report(ReportKind.RESERVED_BITS, register.name, detail, time_ns)
        for tag in register.not_modelled:
            if tag.any_write or value & tag.mask:
                self._log.report(ReportKind.NOT_MODELLED, register.name, tag.reason, time_ns)
