"""How busy processors, buses and wires were."""

from __future__ import annotations

import numpy as np

from boards.assembly import AssembledBoard
from hal.emulated.cpu import EmulatedCpu
from host.record.result import BusUse, CpuUse, TaskUse
from host.record.run_data import TaskTrace


def cpu_use(board: AssembledBoard, duration_ns: int) -> list[CpuUse]:
    """Load and tasks of every processor."""
    return [_one_cpu(name, cpu, duration_ns) for name, cpu in board.cpus.items()]


def _one_cpu(name: str, cpu: EmulatedCpu, duration_ns: int) -> CpuUse:
    tasks = tuple(
        TaskUse(
            name=line.spec.name,
            load=line.busy_ns / duration_ns,
            activations=line.activations,
            worst_response_us=line.worst_response_ns / 1000,
            worst_busy_us=line.worst_busy_ns / 1000,
            deadline_us=None if line.spec.deadline_ns is None else line.spec.deadline_ns / 1000,
            deadline_misses=line.deadline_misses,
            overruns=line.overruns,
        )
        for line in cpu.lines.values()
        if line.activations or line.overruns
    )
    return CpuUse(
        name=name,
        load=sum(task.load for task in tasks),
        deadline_misses=sum(task.deadline_misses for task in tasks),
        overruns=sum(task.overruns for task in tasks),
        stack_worst_bytes=cpu.stack_worst_bytes,
        resets=len(cpu.resets),
        tasks=tasks,
    )


def bus_use(board: AssembledBoard, duration_ns: int) -> list[BusUse]:
    """Load of every SPI and I²C bus, UART direction, CAN bus and end of an interconnect, with the bytes that
    DMA has moved there; errors as the controllers notice them."""
    buses = [
        BusUse(name, bus.busy_ns / duration_ns, bus.transactions)
        for masters in (board.spi_buses, board.i2c_buses)
        for name, bus in masters.items()
    ]
    for wires in (board.to_board, board.from_board):
        for name, wire in wires.items():
            errors = board.ports[name].errors if wires is board.to_board else 0
            load = wire.busy_ns / duration_ns
            buses.append(BusUse(wire.name, load, wire.bytes_sent, wire.bytes_sent, errors))
    for name, can in board.can_buses.items():
        buses.append(BusUse(name, can.busy_ns / duration_ns, can.frames, errors=can.error_frames))
    for name, ends in board.interconnects.items():
        for processor, end in ends.items():
            moved = getattr(end, "bytes", None)
            buses.append(BusUse(f"{name}.{processor}", end.busy_ns / duration_ns, end.transactions, moved))
    return buses


def task_traces(board: AssembledBoard) -> list[TaskTrace]:
    """The recorded windows of all processors."""
    return [_trace(name, cpu) for name, cpu in board.cpus.items() if cpu.trace]


def _trace(name: str, cpu: EmulatedCpu) -> TaskTrace:
    names = tuple(cpu.lines)
    place = {line.bit: k for k, line in enumerate(cpu.lines.values())}
    rows = [row for row in cpu.trace or () if row[0] in place]
    return TaskTrace(
        processor=name,
        names=names,
        tasks=np.array([place[bit] for bit, _, _ in rows], dtype=np.int64),
        starts=np.array([start for _, start, _ in rows]) / 1e9,
        ends=np.array([end for _, _, end in rows]) / 1e9,
    )
