"""The host's ears: what came over the board's wires, handed to digest, capture and intake in batches.

Nobody on this side is in a hurry, so the wires keep what was sent (`LateReceiver`) and no event is spent on
it: asked every `FLUSH_EVERY_NS` of virtual time while there is a capture, else when a batch is scored.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Protocol

from boards.assembly import AssembledBoard
from hal.emulated.can_bus import EmulatedCanBus
from hal.emulated.i2c import I2cObserver
from hal.emulated.uart_bytes import SentBytes
from hal.emulated.uart_receiver import LateReceiver
from hal.emulated.uart_wire import UartWire
from host.capture.blocks import can_records
from host.capture.writer import (
    FLUSH_EVERY_NS,
    CanRecorder,
    LineRecorder,
    SpiRecorder,
    UartRecorder,
)
from host.record.can_course import CanCourse
from host.run.arrivals import Piece
from host.run.can_rhythm import CanRhythm


class WireRecords(Protocol):
    """Who takes what happens on the wires: `host.capture.writer`, or a replay that compares."""

    def spi_recorder(self, bus: str) -> SpiRecorder | None:
        """For one chip select."""
        ...

    def i2c_recorder(self, bus: str) -> I2cObserver | None:
        """For one I²C bus."""
        ...

    def uart_recorder(self, port: str, direction: str) -> UartRecorder:
        """For what a UART sends."""
        ...

    def line_recorder(self, port: str) -> LineRecorder | None:
        """For what comes to a UART."""
        ...

    def can_recorder(self, bus: str) -> CanRecorder:
        """For a CAN bus."""
        ...

    def pin_tape(self, net: str) -> list[int] | None:
        """For the changes of a net."""
        ...

    def show_sensor(self, refdes: str, part: str, bus: str) -> None:
        """A chip on a chip select whose samples people may want to see."""
        ...

    def glimpse(self) -> None:
        """Time to show one."""
        ...

    def clock(self, reset_ns: int, processor: str, rate_ppb: int) -> None:
        """A processor's clock counts from `reset_ns` on."""
        ...

    def flush(self, now_ns: int | None = None) -> None:
        """All that happened before has been told."""
        ...


class LineTape:
    """Tells a capture all that is put on a line, with its exact instants."""

    def __init__(self, wire: UartWire, record: LineRecorder) -> None:
        self._time = wire.time
        self._record = record
        wire.attach(self)

    def announce(self, sent: SentBytes) -> None:
        """These bytes will be on the line."""
        self._record(self._time.now, sent.start, sent.first, sent.baud, sent.data, sent.form)

    def forget(self, begin_from: int) -> None:
        """Bytes whose start bit lies at `begin_from` or later will not come after all."""
        self._record(self._time.now, begin_from, 0, 0, b"", 0)


class WireEar:
    """One direction of one UART."""

    def __init__(self, wire: UartWire, record: UartRecorder | None) -> None:
        self._receiver: LateReceiver = wire.connect_late()
        self._record = record

    def take(self) -> list[Piece]:
        """All that has ended since the last time; every piece goes to the capture."""
        pieces = self._receiver.pieces()
        if self._record is not None:
            for data, end_ns, baud in pieces:
                self._record(end_ns, data, baud)
        return [piece[:2] for piece in pieces]


class CanEar:
    """One CAN bus."""

    def __init__(self, bus: EmulatedCanBus, record: CanRecorder | None) -> None:
        self._listener = bus.listen_late()
        self._record = record
        self.rhythm = CanRhythm(bus.name)

    def take(self) -> bytes:
        """Records (`blocks.can_records`) of all frames that have ended since the last time, which also go to
        the capture."""
        taken = []
        for heard in self._listener.take_parts():
            records = can_records(heard)
            if self._record is not None:
                self._record(records, heard)
            self.rhythm.add(heard)
            taken.append(records)
        return b"".join(taken)


class Ears:
    """Listens to every wire. `hexdigest` is the run's state hash: SHA-256 over what the board sent on each
    wire, wire by wire (of CAN frames also when and under what identifier), and its final navigation state.
    """

    def __init__(
        self,
        board: AssembledBoard,
        host_port: str,
        to_host: Callable[[Sequence[Piece]], None],
        capture: WireRecords | None,
    ) -> None:
        self._board = board
        self._host_port = host_port
        self._to_host = to_host
        self._capture = capture
        self._from_board = {
            port: WireEar(wire, self._uart_recorder(port, "tx")) for port, wire in board.from_board.items()
        }
        self._can_ears = {
            name: CanEar(bus, None if capture is None else capture.can_recorder(name))
            for name, bus in board.can_buses.items()
        }
        self._hashes = {name: hashlib.sha256() for name in (*board.from_board, *board.can_buses)}
        if capture is not None:
            self._tap(board, capture)
            for refdes, chip in board.description.chips.items():
                if chip.bus in board.spi_buses:
                    capture.show_sensor(refdes, chip.part, f"{chip.bus}.{chip.name or refdes}")
            self._clocks_told: dict[str, int] = {}
            board.time.at(FLUSH_EVERY_NS, lambda: self._write_out(capture))

    def _tap(self, board: AssembledBoard, capture: WireRecords) -> None:
        """Have told what comes to the board, as it comes."""
        for name, device in board.spi_devices.items():
            device.observer = capture.spi_recorder(f"{device.bus.name}.{name}")
        for name, bus in board.i2c_buses.items():
            bus.observer = capture.i2c_recorder(name)
        for port, wire in board.to_board.items():
            record = capture.line_recorder(port)
            if record is not None:
                LineTape(wire, record)
        for name, net in board.nets.items():
            net.tape = capture.pin_tape(name)
            if net.tape is not None and net.level:
                net.tape.append(2 * board.time.now + net.level)

    def hand_on(self) -> None:
        """Give everything that has come by now to those who wait for it."""
        for port, ear in self._from_board.items():
            pieces = ear.take()
            if pieces:
                self._hashes[port].update(b"".join([data for data, _end_ns in pieces]))
                if port == self._host_port:
                    self._to_host(pieces)
        for name, can_ear in self._can_ears.items():
            self._hashes[name].update(can_ear.take())

    def can_courses(self, duration_ns: int) -> list[CanCourse]:
        """When the frames of every CAN bus came, after the run."""
        return [course for ear in self._can_ears.values() for course in ear.rhythm.courses(duration_ns)]

    def hexdigest(self) -> str:
        """The hash, after the run."""
        whole = hashlib.sha256()
        for digest in self._hashes.values():
            whole.update(digest.digest())
        for program in self._board.programs.values():
            whole.update(program.memory())
        return whole.hexdigest()

    def _write_out(self, capture: WireRecords) -> int:
        """Event: nothing stays in memory for as long as a second."""
        self.hand_on()
        self._tell_clocks(capture)
        capture.glimpse()
        capture.flush(self._board.time.now)
        return self._board.time.now + FLUSH_EVERY_NS

    def _tell_clocks(self, capture: WireRecords) -> None:
        """Those that have begun to count since the last time."""
        for name, cpu in self._board.cpus.items():
            reset_ns = cpu.virtual_ns(0)
            if self._clocks_told.get(name) != reset_ns:
                self._clocks_told[name] = reset_ns
                capture.clock(reset_ns, name, cpu.crystal_error_ppb)

    def _uart_recorder(self, port: str, direction: str) -> UartRecorder | None:
        return None if self._capture is None else self._capture.uart_recorder(port, direction)
