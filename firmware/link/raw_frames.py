"""Raw frames: everything that the navigation loop of a board takes in, in the order in which it took it.

They are frames as all others (`firmware.link.frames`: sync, sequence, CRC). The same navigation code, fed
with them in their order, comes to the same bits; so they serve in both directions: a board tells them to
its host, and a loop without sensors of its own can be fed with them. `docs/link.md` has the byte tables.

Each input begins with its number, counted from 0 at START; a gap tells that inputs are missing. STATE is no
input: a copy of the whole memory of navigation as it was before input `number`, in slices.
"""

from __future__ import annotations

from struct import Struct
from typing import Final

RAW_START: Final = 0x10
RAW_IMU: Final = 0x11
RAW_EPOCH: Final = 0x12
RAW_TEMPERATURE: Final = 0x13
RAW_CLOCK: Final = 0x14
RAW_STATE: Final = 0x15
RAW_WANTED: Final = 0x16

RAW_FORMAT: Final = 1

INPUTS: Final = {
    RAW_START: Struct("<IBBBBHHHI"),
    RAW_IMU: Struct("<Iq15s"),
    RAW_EPOCH: Struct("<IIq26q"),
    RAW_TEMPERATURE: Struct("<Id"),
    RAW_CLOCK: Struct("<I"),
}
"""START: number (0), RAW_FORMAT, 1 when every sample is a step and 0 for ten-sample means, bytes of a float,
steps between two solutions, floats and integers in the state, CRC-16 of that memory, board clock in µs.
IMU: number, board clock at the read in ns, the sensor's burst. EPOCH: number, count and time of the
TIMEPULSE edge when the epoch was dated, the epoch's record. TEMPERATURE: number, °C. CLOCK: number."""

WANTED: Final = Struct("<I")
"""Of a loop that is fed: number of the input that should come now, after one that did not follow."""

SLICE_HEAD: Final = Struct("<IHH")
"""STATE: number of the next input when the copy was made, number of this slice, slices of the copy."""
SLICE_BYTES: Final = 240

FRAME_BYTES: Final = 7
"""Of a frame besides its payload."""
IMU_FRAME_BYTES: Final = INPUTS[RAW_IMU].size + FRAME_BYTES
SLICE_FRAME_BYTES: Final = SLICE_HEAD.size + SLICE_BYTES + FRAME_BYTES
SAMPLES_A_SLICE: Final = 10
"""A slice of the state goes out behind every tenth sample."""


def slices_of(memory: bytes, number: int) -> list[bytes]:
    """Payloads of the STATE frames of a copy of the memory, made before input `number`."""
    parts = [memory[at : at + SLICE_BYTES] for at in range(0, len(memory), SLICE_BYTES)]
    return [SLICE_HEAD.pack(number, n, len(parts)) + part for n, part in enumerate(parts)]
