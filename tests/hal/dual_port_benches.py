"""Benches of the checks for dual-port memories: on virtual time, and on a transcript."""

from __future__ import annotations

from scripted_benches import GrowingTranscript

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.dual_port import EmulatedDualPort
from hal.emulated.interrupt_line import LineSpec
from hal.emulated.virtual_time import VirtualTime
from hal.scripted import ScriptedCpu, ScriptedDualPort

WORDS = 64


class EmulatedDualPortBench:
    def __init__(self) -> None:
        time = VirtualTime()
        near = EmulatedCpu(time, "near", 300_000_000, [LineSpec("ring", 1)])
        far = EmulatedCpu(time, "far", 50_000_000)
        memory = EmulatedDualPort("emif", WORDS, word_bytes=2)
        self.near = memory.side(near, 30)
        self._far = memory.side(far, 20)
        self._near_cpu = near
        self.rings: list[int] = []
        self.near.interrupt_on_ring(near.attach("ring", lambda: self.rings.append(self.near.rung())))

    def expect_write(self, address: int, data: bytes) -> None:
        pass

    def expect_read(self, address: int, data: bytes) -> None:
        pass

    def expect_ring(self, value: int) -> None:
        pass

    def far_read(self, address: int, count: int) -> bytes:
        return self._far.read(address, count)

    def far_write(self, address: int, data: bytes) -> None:
        self._far.write(address, data)

    def far_ring(self, value: int) -> None:
        self._far.ring(value)
        self._near_cpu.spend(1)

    def far_rung(self) -> int:
        return self._far.rung()


class ScriptedDualPortBench:
    """The other side is what the transcript says; it keeps the words, too."""

    def __init__(self) -> None:
        self._script = GrowingTranscript()
        self.near = ScriptedDualPort(self._script, "emif", WORDS)
        self.rings: list[int] = []
        self._cpu = ScriptedCpu(self._script)
        line = self._cpu.attach("ring", lambda: self.rings.append(self.near.rung()))
        self.near.interrupt_on_ring(line)
        self._written: dict[int, bytes] = {}
        self._rung = 0

    def expect_write(self, address: int, data: bytes) -> None:
        self._script.add(f"memory emif write {address} {data.hex(' ')}")
        for place in range(0, len(data), 4):
            self._written[address + place // 4] = data[place : place + 4]

    def expect_read(self, address: int, data: bytes) -> None:
        self._script.add(f"memory emif read {address} {len(data) // 4} -> {data.hex(' ')}")

    def expect_ring(self, value: int) -> None:
        self._script.add(f"memory emif ring {value}")
        self._rung = value

    def far_read(self, address: int, count: int) -> bytes:
        return b"".join(self._written[address + k] for k in range(count))

    def far_write(self, address: int, data: bytes) -> None:
        pass

    def far_ring(self, value: int) -> None:
        self._script.add(f"<- memory emif ring {value}")
        self._cpu.spend(1)

    def far_rung(self) -> int:
        self._script.finish()
        return self._rung
