"""Benches of the checks for packet links and I²C slaves: on virtual time, and on a transcript."""

from __future__ import annotations

from scripted_benches import GrowingTranscript

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.i2c import EmulatedI2cBus
from hal.emulated.i2c_slave import EmulatedI2cSlave
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.packet_link import EmulatedPacketReceiver, EmulatedPacketSender
from hal.emulated.virtual_time import VirtualTime
from hal.scripted import ScriptedCpu
from hal.scripted.i2c_slave import ScriptedI2cSlave
from hal.scripted.packet_link import ScriptedPacketReceiver, ScriptedPacketSender

ADDRESS = 0x2A


class EmulatedPackets:
    def __init__(self) -> None:
        time = VirtualTime()
        self._cpu = EmulatedCpu(time, "fpga", 70_000_000, [LineSpec("packet", 1)])
        self.receiver = EmulatedPacketReceiver("packets", self._cpu)
        self.sender = EmulatedPacketSender("packets", self._cpu, self.receiver, 8_750_000, 100)
        self.sender.disturbances.append(self._note)
        self._line = self._cpu.attach("packet", lambda: self.whole.append(self.receiver.received()))
        self.whole: list[int] = []
        self._last = b""

    def _note(self, data: bytes) -> bytes:
        self._last = data
        return data

    def begin(self, ring: bytearray, packet_bytes: int) -> None:
        self.receiver.begin(ring, packet_bytes, self._line)

    def expect_send(self, data: bytes, busy: bool = False) -> None:
        pass

    def carried(self) -> bytes:
        self._cpu.delay(1_000_000)
        return self._last

    def bring(self, data: bytes) -> None:
        assert self.sender.send(data)
        self._cpu.delay(1_000_000)


class ScriptedPackets:
    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._cpu = ScriptedCpu(self._script)
        self.sender = ScriptedPacketSender(self._script, "packets")
        self.receiver = ScriptedPacketReceiver(self._script, "packets")
        self.whole: list[int] = []
        self._line = self._cpu.attach("packet", lambda: self.whole.append(self.receiver.received()))
        self._sent = b""

    def begin(self, ring: bytearray, packet_bytes: int) -> None:
        self.receiver.begin(ring, packet_bytes, self._line)

    def expect_send(self, data: bytes, busy: bool = False) -> None:
        self._script.add(f"packets packets send {data.hex(' ')}" + (" -> busy" if busy else ""))
        self._sent = self._sent if busy else data

    def carried(self) -> bytes:
        self._script.finish()
        return self._sent

    def bring(self, data: bytes) -> None:
        self._script.add(f"<- packets packets {data.hex(' ')}")
        self._cpu.spend(1)


class EmulatedSlave:
    def __init__(self) -> None:
        time = VirtualTime()
        self._cpu = EmulatedCpu(time, "fpga", 70_000_000, [LineSpec("command", 1)])
        self._bus = EmulatedI2cBus(self._cpu, 100_000, "commands")
        self.slave = EmulatedI2cSlave(self._cpu)
        self._bus.attach(ADDRESS, self.slave)
        self.heard: list[bytes] = []
        self.slave.begin(self._cpu.attach("command", lambda: self.heard.append(self.slave.taken())))

    def expect_answer(self, data: bytes) -> None:
        pass

    def master_writes(self, data: bytes) -> None:
        self._bus.transaction(ADDRESS, data)
        self._cpu.spend(1)

    def master_reads(self, length: int) -> bytes:
        return self._bus.transaction(ADDRESS, b"", length)


class ScriptedSlave:
    """What the master reads a transcript does not tell; the bench keeps the answers."""

    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self._cpu = ScriptedCpu(self._script)
        self.slave = ScriptedI2cSlave(self._script, "commands")
        self.heard: list[bytes] = []
        self.slave.begin(self._cpu.attach("command", lambda: self.heard.append(self.slave.taken())))
        self._answer = b""

    def expect_answer(self, data: bytes) -> None:
        self._script.add(f"slave commands answer {data.hex(' ')}")
        self._answer = data

    def master_writes(self, data: bytes) -> None:
        self._script.add(f"<- slave commands {data.hex(' ')}")
        self._cpu.spend(1)

    def master_reads(self, length: int) -> bytes:
        self._script.finish()
        return self._answer[:length].ljust(length, b"\xff")
