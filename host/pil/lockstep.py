"""Calls of the twin's kernels, made again by the image and compared one by one.

    lockstep = Lockstep(link, image, greeting.memory, limit=10_000)
    with entries_observed(lockstep.observe):
        ...                       # the twin's firmware runs
    lockstep.flush()

Each call goes over the line with the digest that the twin's own call left; calls are sent in batches. The
image answers with its digests and stops at the first that differs; its arrays are then fetched and compared
with those of the twin, put right, and the work goes on, up to MOST_DIFFERENCES times.
"""

from __future__ import annotations

import functools
import struct
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firmware.numerics.signature import Argument
from host.pil.difference import Difference, first_difference
from host.pil.digest import digest_of
from host.pil.image import Image
from host.pil.kernel_table import SIZES, TargetKernel
from host.pil.mirror import Mirror, Place
from host.pil.monitor_link import CALLS, RESULTS, MonitorLink

BATCH_BYTES = 6000
BATCH_CALLS = 300
LONG_PATCH = 1500
MOST_DIFFERENCES = 10
MASK = (1 << 64) - 1


@dataclass(slots=True)
class Call:
    """One call that the image is to make again."""

    step: int
    kernel: TargetKernel
    record: bytes
    digest: int
    places: list[Place]
    left: list[NDArray[Any]]
    """The twin's arrays after the call."""
    slots: list[int]


@dataclass(slots=True)
class Counts:
    """Cycles of one kernel."""

    calls: int = 0
    total: int = 0
    least: int = 1 << 30
    most: int = 0

    def add(self, cycles: int) -> None:
        """One call more."""
        self.calls += 1
        self.total += cycles
        self.least = min(self.least, cycles)
        self.most = max(self.most, cycles)


@dataclass(slots=True)
class Lockstep:
    """The comparison under way."""

    link: MonitorLink
    image: Image
    memory: int
    limit: int
    """Calls to compare."""
    differences: list[Difference] = field(default_factory=list)
    counts: dict[str, Counts] = field(default_factory=dict)
    skipped: Counter[str] = field(default_factory=Counter)
    """Calls of kernels that are not in the image."""
    latest: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    """Arguments of the last call of each kernel; its arrays go on changing."""
    steps: int = 0
    """Calls seen."""
    compared: int = 0
    _waiting: list[Call] = field(default_factory=list)
    _bytes_waiting: int = 0
    _mirror: Mirror = field(init=False)
    _by_name: dict[str, TargetKernel] = field(init=False)

    def __post_init__(self) -> None:
        self._mirror = Mirror(self.link, self.memory, self.flush)
        self._by_name = {kernel.name: kernel for kernel in self.image.kernels}

    @property
    def is_over(self) -> bool:
        """Whether enough was seen."""
        return self.steps >= self.limit or len(self.differences) >= MOST_DIFFERENCES

    def observe(self, kernel: Any, entry: Callable[..., Any]) -> Callable[..., Any]:
        """For `entries_observed`: what the twin calls instead of `entry`."""
        function = getattr(kernel, "py_func", kernel)
        known = self._by_name.get(f"{function.__module__}.{function.__qualname__}")
        return entry if known is None else functools.partial(self.call, known, entry)

    def call(self, kernel: TargetKernel, entry: Callable[..., Any], *arguments: Any) -> Any:
        """Let the twin make the call, and have it made again."""
        if self.is_over:
            return entry(*arguments)
        places, head, patches = self._before(kernel, arguments)
        result = entry(*arguments)
        slots = result_slots(kernel, result)
        for place in places:
            self._mirror.hold(place)
        left = [place.held for place in places]
        digest = digest_of(kernel.number, left, slots)
        record = b"".join((bytes((kernel.number, len(patches))), head, *patches, struct.pack("<Q", digest)))
        self._waiting.append(Call(self.steps, kernel, record, digest, places, left, slots))
        self._bytes_waiting += len(record)
        self.latest[kernel.name] = arguments
        self.steps += 1
        if self.steps >= self.limit:
            self.flush()
        return result

    def flush(self) -> None:
        """Send what waits and compare."""
        if len(self.differences) >= MOST_DIFFERENCES:
            self._waiting.clear()
        while self._waiting:
            payload = struct.pack("<H", len(self._waiting)) + b"".join(call.record for call in self._waiting)
            answer = self.link.request(CALLS, payload)
            (done,) = struct.unpack_from("<H", answer)
            batch, self._waiting = self._waiting[:done], self._waiting[done:]
            for place, call in enumerate(batch):
                digest, cycles = struct.unpack_from("<QI", answer, 2 + 12 * place)
                self.counts.setdefault(call.kernel.name, Counts()).add(cycles)
                if digest != call.digest:
                    self._differs(call)
            self.compared += done
            if len(self.differences) >= MOST_DIFFERENCES:
                self._waiting.clear()
        self._bytes_waiting = 0

    def forget_arrays(self, sizes: Iterable[int]) -> None:
        """The arrays of the calls to come are others, of so many bytes."""
        self.flush()
        self._mirror.release()
        if not self._mirror.has_room(sizes):
            self._mirror = Mirror(self.link, self.memory, self.flush)

    def _before(
        self, kernel: TargetKernel, arguments: tuple[Any, ...]
    ) -> tuple[list[Place], bytes, list[bytes]]:
        """Places of the arrays, the arguments as the image wants them, and patches to its arrays."""
        places, head = [], []
        for expected, value in zip(kernel.signature.arguments, arguments, strict=True):
            if expected.is_array:
                place = self._mirror.place_of(value)
                places.append(place)
                head.append(bytes((place.handle,)))
            else:
                head.append(scalar_bytes(expected, value))
        changes = [(place, runs) for place in places if (runs := self._mirror.patches(place))]
        length = sum(len(data) + 5 for _, runs in changes for _, data in runs)
        if len(self._waiting) >= BATCH_CALLS or self._bytes_waiting + length > BATCH_BYTES:
            self.flush()
        if length > LONG_PATCH or sum(len(runs) for _, runs in changes) > 255:
            self.flush()
            for place, _ in changes:
                self._mirror.update(place)
            changes = []
        patches = [
            struct.pack("<BHH", place.handle, at, len(data)) + data
            for place, runs in changes
            for at, data in runs
        ]
        return places, b"".join(head), patches

    def _differs(self, call: Call) -> None:
        """Find out where, and give the image what the twin has."""
        theirs = [self._mirror.read(place) for place in call.places]
        answer = self.link.request(RESULTS, b"")
        results = list(struct.unpack(f"<{len(answer) // 8}Q", answer))
        names = [
            name
            for name, one in zip(call.kernel.parameters, call.kernel.signature.arguments, strict=True)
            if one.is_array
        ]
        self.differences.append(
            first_difference(call.step, call.kernel, names, call.left, theirs, call.slots, results)
        )
        for place, values in zip(call.places, call.left, strict=True):
            self._mirror.write(place, values)


def scalar_bytes(expected: Argument, value: Any) -> bytes:
    """A scalar as it lies in a call."""
    if expected.scalar == "float32":
        return np.float32(value).tobytes()
    size = SIZES[expected.scalar]
    return (int(value) & ((1 << 8 * size) - 1)).to_bytes(size, "little")


def result_slots(kernel: TargetKernel, result: Any) -> list[int]:
    """Status and results of a call as the image gives them."""
    values = result if isinstance(result, tuple) else () if result is None else (result,)
    slots = [0]
    for expected, value in zip(kernel.signature.results, values, strict=True):
        if expected.scalar == "float32":
            bits = int(np.float32(value).view(np.uint32))
            slots.append(0x7FC00000 if bits & 0x7FFFFFFF > 0x7F800000 else bits)
        else:
            slots.append(int(value) & MASK)
    return slots
