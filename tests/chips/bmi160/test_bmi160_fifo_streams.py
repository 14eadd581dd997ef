"""Everything that goes into the FIFO comes out of it again, whatever the pieces in which it is read."""

from __future__ import annotations

from math import radians
from struct import unpack
from typing import Any

from bmi160_fifo_rig import ACCEL_ON, GYRO_ON, HEADER, counting, fifo_rig, length
from bmi160_rig import MS, G
from hypothesis import Phase, given, settings
from hypothesis import strategies as st


def climbing(t: Any) -> dict[str, Any]:
    """Every sample has a value of its own."""
    return {"fx": 0.9 * t * G, "wx": radians(1000.0) * t}


def registers_after_each_sample(
    accel_code: int, gyro_code: int, rate: int, column: int, end_ns: int
) -> list[int]:
    """What the data registers show after every sample from 299.005 ms on, read one by one."""
    rig = fifo_rig(HEADER, climbing, (0x40, 0x20 | accel_code), (0x42, 0x20 | gyro_code))
    values = []
    for n in range(1, 20 * rate):
        instant = n * 1_000_000_000 // rate
        if 299_005_000 < instant <= end_ns:
            rig.until(max(instant, rig.time.now))
            data = rig.chip.transaction(b"\x8c" + bytes(12), rig.time.now, rig.time.now + 1)
            values.append(unpack("<6h", data[1:])[column])
    return values


class HeaderReader:
    """Takes header-mode bursts apart; an incomplete frame at the end of a burst is left to the next."""

    def __init__(self) -> None:
        self.runs: dict[str, list[list[int]]] = {"gyro": [[]], "accel": [[]]}
        """x values, a new list after every skip frame."""
        self.skipped = 0

    def burst(self, data: bytes) -> None:
        while data and data[0] != 0x80:
            header = data[0]
            size = 2 if header == 0x40 else 1 + 6 * (bool(header & 8) + bool(header & 4))
            frame, data = data[:size], data[size:]
            if len(frame) < size:
                return
            if header == 0x40:
                self.skipped += frame[1]
                for runs in self.runs.values():
                    runs.append([])
                continue
            if header & 8:
                self.runs["gyro"][-1].append(unpack("<h", frame[1:3])[0])
            if header & 4:
                self.runs["accel"][-1].append(unpack("<h", frame[-6:-4])[0])


@settings(max_examples=25, deadline=None, phases=(Phase.explicit, Phase.reuse, Phase.generate))
@given(
    accel_code=st.integers(6, 10),
    gyro_code=st.integers(6, 10),
    reads=st.lists(st.tuples(st.integers(1, 80), st.integers(1, 160)), min_size=3, max_size=12),
)
def test_header_stream_reassembles_to_the_samples(
    accel_code: int, gyro_code: int, reads: list[tuple[int, int]]
) -> None:
    """Reads of any length at any time give every sample once and in order, but for those told as skipped."""
    rig = fifo_rig(GYRO_ON | ACCEL_ON | HEADER, climbing, (0x40, 0x20 | accel_code), (0x42, 0x20 | gyro_code))
    reader = HeaderReader()
    for wait_ms, count in [*reads, (1, 1030)]:
        rig.wait(wait_ms * MS)
        end = rig.time.now
        reader.burst(rig.read(0x24, count))
    for sensor, code, column in (("gyro", gyro_code, 0), ("accel", accel_code, 3)):
        expected = registers_after_each_sample(accel_code, gyro_code, 25 << (code - 6), column, end)
        at = [[expected.index(value) for value in run] for run in reader.runs[sensor]]
        assert all(run == list(range(run[0], run[0] + len(run))) for run in at if run)
        flat = [index for run in at for index in run]
        assert flat == sorted(flat)
        assert not flat or flat[-1] == len(expected) - 1
        if code >= max(accel_code, gyro_code):
            assert len(expected) - len(flat) == reader.skipped


@settings(max_examples=15, deadline=None, phases=(Phase.explicit, Phase.reuse, Phase.generate))
@given(reads=st.lists(st.tuples(st.integers(1, 80), st.integers(0, 10)), min_size=2, max_size=8))
def test_headerless_stream_reassembles_to_the_samples(reads: list[tuple[int, int]]) -> None:
    rig = fifo_rig(GYRO_ON | ACCEL_ON, counting)
    stream = b""
    for wait_ms, frames in [*reads, (1, 85)]:
        rig.wait(wait_ms * MS)
        count = min(frames * 12, length(rig))
        stream += rig.read(0x24, count)
    frames_read = [unpack("<6h", stream[i : i + 12]) for i in range(0, len(stream), 12)]
    assert [frame[3] for frame in frames_read] == [
        round(16384 * ((30 + n) % 100) / 100) for n in range(len(frames_read))
    ]
    assert len(frames_read) >= sum(wait for wait, _ in reads) // 10
