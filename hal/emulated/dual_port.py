"""Dual-port memory on virtual time: two sides, each on the bus of its own processor.

Mostly nothing falls due while a side is at work; its words then change hands at once. Otherwise a write is
kept, with what stood there before, for as long as a read may have begun before its end: that read finds of
each word what was there at the end of the word's own access time.

A reset of a processor leaves the words and both mailboxes as they are, but its side interrupts it no more
until it is told to.
"""

from __future__ import annotations

from typing import Final, NamedTuple, SupportsIndex

from hal.emulated.cpu import EmulatedCpu
from hal.emulated.interrupt_line import EmulatedLine, emulated_line
from hal.emulated.whole_number import whole_number
from hal.interrupts import InterruptLine

WORD_BYTES: Final = (2, 4)

Words = bytes | bytearray | memoryview


class _Write(NamedTuple):
    """One write that a read may have met under way."""

    start_ns: int
    access_ns: int
    address: int
    before: bytes
    end_ns: int


class EmulatedDualPort:
    """The memory itself. `side` hands out its two sides."""

    def __init__(self, name: str, words: int, word_bytes: int = 4) -> None:
        if words < 1 or word_bytes not in WORD_BYTES:
            raise ValueError(
                f"dual-port memory {name!r} of {words} words of {word_bytes} bytes; words have 2 or 4,"
                " and there is at least one"
            )
        self.name = name
        self.words = words
        self.word_bytes = word_bytes
        self.sides: list[EmulatedDualPortSide] = []
        self.bytes = bytearray(words * word_bytes)
        self._writes: list[_Write] = []
        """Those that a read under way may have met, in order of their beginning."""
        self._reads: list[int] = []
        """When the reads under way have begun."""
        self.under_way = 0
        """Accesses that something else may come between."""

    def side(self, cpu: EmulatedCpu, access_ns: int) -> EmulatedDualPortSide:
        """The next side, on the bus of `cpu`. Raises ValueError for a third one."""
        if len(self.sides) == 2:
            raise ValueError(f"dual-port memory {self.name!r} has two sides already")
        side = EmulatedDualPortSide(self, cpu, access_ns)
        for other in self.sides:
            side.other, other.other = other, side
        self.sides.append(side)
        return side

    def put(self, address: int, data: bytes) -> None:
        """Words that nobody reads meanwhile."""
        begin = address * self.word_bytes
        self.bytes[begin : begin + len(data)] = data

    def get(self, address: int, count: int) -> bytes:
        """Words that nobody writes meanwhile."""
        begin = address * self.word_bytes
        return bytes(self.bytes[begin : begin + count * self.word_bytes])

    def begin_write(self, address: int, data: bytes, start_ns: int, access_ns: int) -> _Write:
        """A write that others may come between."""
        count = len(data) // self.word_bytes
        before = self.get(address, count)
        write = _Write(start_ns, access_ns, address, before, start_ns + count * access_ns)
        self._writes.append(write)
        self.under_way += 1
        self.put(address, data)
        return write

    def end_write(self, write: _Write, now_ns: int) -> None:
        """It is over, or was broken off: what was not written yet stays as it was."""
        written = (now_ns - write.start_ns) // write.access_ns
        left = write.before[written * self.word_bytes :]
        if left:
            self.put(write.address + written, left)
        self._forget(now_ns)

    def begin_read(self, start_ns: int) -> None:
        """A read that others may come between."""
        self._reads.append(start_ns)
        self.under_way += 1

    def end_read(self, start_ns: int, now_ns: int) -> None:
        """It is over, or was broken off."""
        self._reads.remove(start_ns)
        self._forget(now_ns)

    def found(self, address: int, count: int, start_ns: int, access_ns: int) -> bytes:
        """What a read finds that began then: of each word what was there at the end of its access."""
        width = self.word_bytes
        found = bytearray(self.get(address, count))
        for write in reversed(self._writes):
            length = len(write.before) // width
            for word in range(max(address, write.address), min(address + count, write.address + length)):
                read_ns = start_ns + (word - address + 1) * access_ns
                place = word - write.address
                if write.start_ns + (place + 1) * write.access_ns > read_ns:
                    at = (word - address) * width
                    found[at : at + width] = write.before[place * width : (place + 1) * width]
        return bytes(found)

    def _forget(self, now_ns: int) -> None:
        """An access is over; writes that no read can have met any more are forgotten."""
        self.under_way -= 1
        earliest = min(self._reads, default=now_ns)
        self._writes = [write for write in self._writes if write.end_ns > earliest]


class EmulatedDualPortSide:
    """One side. Implements `hal.dual_port.DualPortMemory`."""

    def __init__(self, memory: EmulatedDualPort, cpu: EmulatedCpu, access_ns: int) -> None:
        if access_ns <= 0:
            raise ValueError(f"dual-port memory {memory.name!r}: access_ns = {access_ns}; e.g. 30")
        self.words = memory.words
        self.word_bytes = memory.word_bytes
        self.access_ns = access_ns
        self.transactions = 0
        self.accesses = 0
        """Words read and written, mailboxes too."""
        self._memory = memory
        self._cpu = cpu
        self._time = cpu.time
        self._free_at = 0
        self._mailbox = 0
        self._mask = (1 << 8 * memory.word_bytes) - 1
        self._line: EmulatedLine | None = None
        self.other: EmulatedDualPortSide | None = None
        cpu.reset_hooks.append(self._reset)

    @property
    def busy_ns(self) -> int:
        """How long its bus was at work."""
        return self.accesses * self.access_ns

    def read(self, address: SupportsIndex, count: SupportsIndex) -> bytes:
        """See `hal.dual_port.DualPortMemory`."""
        if isinstance(address, int) and isinstance(count, int):
            return self._read(address, count)
        return self._read(whole_number(address, "address"), whole_number(count, "count of words"))

    def _read(self, address: int, count: int) -> bytes:
        if address < 0 or count < 1 or address + count > self.words:
            self._refuse(address, count)
        memory, time = self._memory, self._time
        start = time.now
        if start < self._free_at:
            start = self._wait()
        end = self._free_at = start + count * self.access_ns
        self.transactions += 1
        self.accesses += count
        if end < time.limit and not memory.under_way:
            time.now = end
            begin = address * self.word_bytes
            return bytes(memory.bytes[begin : begin + count * self.word_bytes])
        memory.begin_read(start)
        try:
            self._cpu.wait_until(end)
            return memory.found(address, count, start, self.access_ns)
        finally:
            memory.end_read(start, time.now)

    def write(self, address: SupportsIndex, data: Words) -> None:
        """See `hal.dual_port.DualPortMemory`."""
        self._write(address if isinstance(address, int) else whole_number(address, "address"), data)

    def _write(self, address: int, data: Words) -> None:
        width = self.word_bytes
        count, rest = divmod(len(data), width)
        if rest:
            raise ValueError(
                f"dual-port memory {self._memory.name!r}: {len(data)} bytes are no whole words of"
                f" {width} bytes"
            )
        if address < 0 or count < 1 or address + count > self.words:
            self._refuse(address, count)
        memory, time = self._memory, self._time
        start = time.now
        if start < self._free_at:
            start = self._wait()
        end = self._free_at = start + count * self.access_ns
        self.transactions += 1
        self.accesses += count
        if end < time.limit and not memory.under_way:
            time.now = end
            memory.bytes[address * width : (address + count) * width] = data
            return
        write = memory.begin_write(address, bytes(data), start, self.access_ns)
        try:
            self._cpu.wait_until(end)
        finally:
            memory.end_write(write, time.now)

    def ring(self, value: SupportsIndex) -> None:
        """See `hal.dual_port.DualPortMemory`."""
        self._access_mailbox()
        other = self.other
        if other is not None:
            word = value if isinstance(value, int) else whole_number(value, "mailbox word")
            other._mailbox = word & self._mask
            line = other._line
            if line is not None:
                line.request()

    def rung(self) -> int:
        """See `hal.dual_port.DualPortMemory`."""
        self._access_mailbox()
        return self._mailbox

    def interrupt_on_ring(self, line: InterruptLine) -> None:
        """See `hal.dual_port.DualPortMemory`."""
        self._line = emulated_line(line)

    def _access_mailbox(self) -> None:
        time = self._time
        start = time.now
        if start < self._free_at:
            start = self._wait()
        end = self._free_at = start + self.access_ns
        self.transactions += 1
        self.accesses += 1
        if end < time.limit:
            time.now = end
        else:
            self._cpu.wait_until(end)

    def _wait(self) -> int:
        """A handler waits for the access that it came into; returns now."""
        while self._time.now < self._free_at:
            self._cpu.wait_until(self._free_at)
        return self._time.now

    def _refuse(self, address: int, count: int) -> None:
        raise ValueError(
            f"dual-port memory {self._memory.name!r}: words {address} … {address + count - 1};"
            f" it has 0 … {self.words - 1}"
        )

    def _reset(self) -> None:
        self._line = None
        self._free_at = self._time.now
