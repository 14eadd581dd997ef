"""The 1024-byte FIFO as a byte container (fact sheet section 6).

Frames go in whole. When one does not fit, the oldest go out; in header mode a skip frame then tells how
many were lost and stands in front of what is left. A read takes bytes from the front; a frame that was
read only in part comes again, whole, at the next read. Beyond the last frame a read gets, in header mode,
one sensor time frame when that is enabled, then 0x80 for ever; without headers 0x80 0x00 in turn.
"""

from __future__ import annotations

from collections import deque

CAPACITY = 1024
SKIP, SENSOR_TIME, INPUT_CONFIG, EMPTY = 0x40, 0x44, 0x48, 0x80
"""Headers of control frames, and what an empty FIFO answers."""

GYRO_FRAME, ACCEL_FRAME = 0x88, 0x84
"""Headers of regular frames; a combined frame has both bits."""

_SKIP_FRAME_LENGTH = 2
INPUT_CONFIG_LENGTH = 2


class Fifo:
    """Frames in order of time."""

    __slots__ = ("_fill", "_frames", "_skipped", "header_mode")

    def __init__(self) -> None:
        self.header_mode = True
        self._frames: deque[bytes] = deque()
        self._fill = 0
        self._skipped = 0

    def __len__(self) -> int:
        """FIFO_LENGTH: bytes of complete frames, the skip frame included."""
        return self._fill + self._overhead()

    def _overhead(self) -> int:
        return _SKIP_FRAME_LENGTH if self._skipped and self.header_mode else 0

    def flush(self) -> None:
        """Forget all frames and what was skipped."""
        self._frames.clear()
        self._fill = self._skipped = 0

    def fits(self, length: int) -> bool:
        """Whether a frame of `length` bytes goes in without pushing the oldest out."""
        return len(self) + length <= CAPACITY

    def push(self, frame: bytes) -> None:
        """Put a frame in; the oldest go out for it when there is no room."""
        while not self.fits(len(frame)):
            oldest = self._frames.popleft()
            self._fill -= len(oldest)
            if oldest[0] != INPUT_CONFIG or not self.header_mode:
                self._skipped += 1
        self._frames.append(frame)
        self._fill += len(frame)

    def read(self, count: int, sensor_time: bytes | None) -> bytes:
        """One burst of `count` bytes. `sensor_time`: the three bytes for the time frame, None without it."""
        data = bytearray()
        if self._overhead():
            data += bytes((SKIP, min(self._skipped, 0xFF)))
            if count >= _SKIP_FRAME_LENGTH:
                self._skipped = 0
        frames = self._frames
        while frames and len(data) + len(frames[0]) <= count:
            frame = frames.popleft()
            self._fill -= len(frame)
            data += frame
        if frames and len(data) < count:
            data += frames[0]
        if len(data) < count:
            data += self._beyond(count - len(data), sensor_time)
        return bytes(data[:count])

    def _beyond(self, count: int, sensor_time: bytes | None) -> bytes:
        if not self.header_mode:
            return b"\x80\x00" * (count // 2 + 1)
        time_frame = bytes((SENSOR_TIME,)) + sensor_time if sensor_time is not None else b""
        return time_frame + bytes((EMPTY,)) * count
