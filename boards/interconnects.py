"""What joins two processors of one board, built from its description: for each kind a builder and a face."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from boards.description import DualPort, I2cCommands, Interconnect, SpiPackets
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.dual_port import EmulatedDualPort
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.i2c_slave import EmulatedI2cSlave
from hal.emulated.packet_link import EmulatedPacketReceiver, EmulatedPacketSender

Ends = dict[str, Any]
"""What each processor sees of it, by the processor's name. An end counts `transactions` and `busy_ns`."""


class Kind(NamedTuple):
    """One kind of interconnect."""

    build: Callable[[str, Any, Mapping[str, EmulatedCpu]], Ends]
    """(name, description, processors) → ends."""
    faces: Callable[[Any], dict[str, str]]
    """Where each program finds its end: processor → field of `hal.board_io.BoardIo`."""


def _dual_port(name: str, facts: DualPort, cpus: Mapping[str, EmulatedCpu]) -> Ends:
    memory = EmulatedDualPort(name, facts.words, facts.word_bits // 8)
    return {processor: memory.side(cpus[processor], end.access_ns) for processor, end in facts.ends.items()}


def _spi_packets(name: str, facts: SpiPackets, cpus: Mapping[str, EmulatedCpu]) -> Ends:
    receiver = EmulatedPacketReceiver(name, cpus[facts.receiver])
    sender = EmulatedPacketSender(name, cpus[facts.sender], receiver, facts.clock_hz, facts.pause_ns)
    return {facts.sender: sender, facts.receiver: receiver}


def _i2c_commands(name: str, facts: I2cCommands, cpus: Mapping[str, EmulatedCpu]) -> Ends:
    bus = EmulatedI2cBus(cpus[facts.master], facts.clock_hz, name)
    slave = EmulatedI2cSlave(cpus[facts.slave])
    bus.attach(facts.address, slave)
    return {facts.master: bus, facts.slave: slave}


KINDS: dict[str, Kind] = {
    "dual-port": Kind(_dual_port, lambda facts: dict.fromkeys(facts.ends, "memories")),
    "spi-packets": Kind(
        _spi_packets, lambda facts: {facts.sender: "packet_senders", facts.receiver: "packet_receivers"}
    ),
    "i2c-commands": Kind(
        _i2c_commands, lambda facts: {facts.master: "command_buses", facts.slave: "i2c_slaves"}
    ),
}


def build(name: str, facts: Interconnect, cpus: Mapping[str, EmulatedCpu]) -> Ends:
    """The ends of one interconnect."""
    return KINDS[facts.kind].build(name, facts, cpus)


def ends_of(
    processor: str, described: Mapping[str, Interconnect], built: Mapping[str, Ends]
) -> dict[str, Ends]:
    """One processor's ends by name, as fields of its `BoardIo`."""
    found: dict[str, Ends] = {}
    for name, facts in described.items():
        if processor in built[name]:
            face = KINDS[facts.kind].faces(facts)[processor]
            found.setdefault(face, {})[name] = built[name][processor]
    return found
