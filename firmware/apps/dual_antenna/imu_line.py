"""The inertial unit's RS-422 line: frames become samples with the time of their validity.

A sample is valid at the end of its period; its frame begins LATENCY_NS later, as the unit's sheet says, and
takes its time on the line: the stream is given times that are so much earlier.
"""

from __future__ import annotations

from firmware.apps.dual_antenna.post import Post
from firmware.drivers import serial_imu_frames as fr
from firmware.drivers.serial_imu import BITS_PER_BYTE, SECOND_NS, SerialImuStream
from hal.board_io import BoardIo

LATENCY_NS = 100_000
WORD = 0xFFFF_FFFF


class ImuLine:
    """Owns the port and the stream."""

    def __init__(self, io: BoardIo, post: Post) -> None:
        self._uart = io.uart["imu"]
        self._clock = io.clock
        self._cpu = io.cpu
        self._post = post
        self._stream = SerialImuStream(baud=self._uart.baud)
        self._delay_ns = LATENCY_NS + fr.FRAME_LENGTH * BITS_PER_BYTE * SECOND_NS // self._uart.baud
        self._cost = io.cpu.cost("imu_frame")
        self._line = io.interrupts.attach("imu_receive", self._on_bytes)
        self._port_errors = 0

    def begin(self) -> None:
        """Receive from now on."""
        self._uart.start_receive(self._stream.ring, self._line)

    def health(self) -> tuple[int, int, int, int, int, int]:
        """Frames, lost samples, bad frames, bytes of garbage, overruns, errors of the port so far."""
        self._port_errors += self._uart.take_errors()
        frames, lost, bad, garbage, overruns = self._stream.statistics()
        return (
            frames & WORD, lost & WORD, bad & WORD, garbage & WORD, overruns & WORD,
            self._port_errors & WORD,
        )  # fmt: skip

    def _on_bytes(self) -> None:
        valid_ns = self._clock.now_ns() - self._delay_ns
        received = self._uart.received()
        stream = self._stream
        while stream.take(received, valid_ns):
            self._cpu.spend(self._cost)
            self._post.sample(stream.sample.tobytes())
