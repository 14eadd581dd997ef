"""Length of a CAN 2.0 data frame on the wire, with the stuff bits that its content really needs.

    SOF 1 | id 11, RTR, IDE, r0 | DLC 4 | data 8n | CRC 15 | delimiter, ACK, delimiter | EOF 7   (base)
    SOF 1 | id 11, SRR, IDE, id 18, RTR, r1, r0 | DLC 4 | …                                       (extended)

After five equal bits from the start of frame to the end of the CRC follows one of the other level, which
counts for the next five. The CRC has the polynomial x¹⁵+x¹⁴+x¹⁰+x⁸+x⁷+x⁴+x³+1 (0x4599), start value 0, over
the unstuffed bits before it (fact sheet, section 4; CAN specification 2.0, part B).

Both the CRC and the stuffing go a byte at a time through tables: `frame_bits` for one frame, `ends_of_sets`
for many sets.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hal.can import CanFrame

CRC_POLYNOMIAL = 0x4599
TRAILER_BITS = 10
"""CRC delimiter, acknowledge slot and delimiter, end of frame."""
INTERFRAME_BITS = 3
LONGEST_FRAME_BITS = 157
"""An extended frame of 8 bytes, 128 bits, with a stuff bits after the first five and every four behind."""


def _crc_of_byte(byte: int) -> int:
    crc = byte << 7
    for _ in range(8):
        crc = (crc << 1) ^ (CRC_POLYNOMIAL if crc & 0x4000 else 0)
        crc &= 0x7FFF
    return crc


def _stuff(state: int, value: int, bits: int) -> tuple[int, int]:
    """State after and stuff bits in `value`, most significant bit first.

    State: 4·level + (length of the run of that level − 1); a run of five is ended by its stuff bit.
    """
    stuffed = 0
    for shift in range(bits - 1, -1, -1):
        level = value >> shift & 1
        run = state & 3
        if state >> 2 != level:
            state = level << 2
        elif run < 3:
            state += 1
        else:
            stuffed += 1
            state = (1 - level) << 2
    return state, stuffed


CRC_TABLE = tuple(_crc_of_byte(byte) for byte in range(256))


def _linked_table() -> list[list[Any]]:
    """One row per stuffing state: for a byte the row of the state after it and the stuff bits in it; at
    256 + v for a tail of seven bits v the stuff bits alone."""
    rows: list[list[Any]] = [[] for _ in range(8)]
    for state, row in enumerate(rows):
        for byte in range(256):
            after, stuffed = _stuff(state, byte, 8)
            row.append((rows[after], stuffed))
        row.extend(_stuff(state, tail, 7)[1] for tail in range(128))
    return rows


STUFF_ROWS = _linked_table()


@lru_cache(maxsize=4096)
def _header(identifier: int, extended: bool, length: int) -> tuple[int, int, int]:
    """CRC and stuffing state before the data; bits of the frame without the stuff bits behind."""
    limit = 0x1FFF_FFFF if extended else 0x7FF
    if not 0 <= identifier <= limit:
        kind = "29-bit" if extended else "11-bit"
        raise ValueError(f"CAN identifier 0x{identifier:X}: a {kind} one is at most 0x{limit:X}")
    if length > 8:
        raise ValueError(f"CAN frame 0x{identifier:X} with {length} data bytes; 8 at most")
    if extended:
        high, low = identifier >> 18, identifier & 0x3FFFF
        bits, value = 39, ((high << 2 | 0b11) << 18 | low) << 7 | length
    else:
        bits, value = 19, identifier << 7 | length
    crc = 0
    for shift in range(-(-bits // 8) * 8 - 8, -1, -8):
        crc = (crc << 8 & 0x7FFF) ^ CRC_TABLE[(crc >> 7 ^ value >> shift) & 0xFF]
    state, stuffed = _stuff(0, value, bits - 1)
    return crc, state, bits + stuffed + 8 * length + 15 + TRAILER_BITS


def frame_bits(frame: CanFrame) -> int:
    """Bits from start of frame to end of frame, without the interframe space.

    Raises ValueError for a frame that CAN 2.0 does not have.
    """
    identifier, data, extended = frame
    crc, state, bits = _header(identifier, extended, len(data))
    row = STUFF_ROWS[state]
    table = CRC_TABLE
    for byte in data:
        crc = (crc & 0x7F) << 8 ^ table[crc >> 7 ^ byte]
        row, stuffed = row[byte]
        bits += stuffed
    row, stuffed = row[crc >> 7]
    return bits + stuffed + row[256 + (crc & 0x7F)]


def check_frame(frame: CanFrame) -> None:
    """Raise ValueError for a frame that CAN 2.0 does not have."""
    _header(frame[0], frame[2], len(frame[1]))


SYMBOLS = 256 + 128
"""What the stuffing table knows for each state: bytes, and tails of seven bits."""


@lru_cache(maxsize=1)
def _tables() -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """CRC of a byte; by SYMBOLS · state + symbol: 4 · (SYMBOLS · state after it) + stuff bits in it."""
    symbols = [(byte, 8) for byte in range(256)] + [(tail, 7) for tail in range(128)]
    stuffing = [_stuff(state, *symbol) for state in range(8) for symbol in symbols]
    return np.array(CRC_TABLE, np.int32), np.array([4 * SYMBOLS * s + n for s, n in stuffing], np.int32)


@lru_cache(maxsize=64)
def _heads(identifiers: tuple[int, ...]) -> NDArray[np.int32]:
    return np.array([_header(identifier, False, 8) for identifier in identifiers], np.int32)


def ends_of_sets(
    begins_ns: NDArray[np.int64], identifiers: tuple[int, ...], data: bytes, bitrate: int
) -> tuple[NDArray[np.int64], int]:
    """(ends of all frames in ns, bits of all frames with interframe spaces) of sets (`hal.can.CanSet`) that
    begin at `begins_ns` and have these identifiers. `data`: that of all sets, one behind the other."""
    from hal.emulated.can_kernel import fill_ends  # numba takes long to import, and not all need it

    ends_ns = np.empty(len(data) // 8, np.int64)
    array = np.frombuffer(data, np.uint8)
    bits = fill_ends(begins_ns, _heads(identifiers), array, *_tables(), INTERFRAME_BITS, bitrate, ends_ns)
    return ends_ns, int(bits)


def arbitration_key(frame: CanFrame) -> int:
    """Lower wins: the bits of the arbitration field as they stand on the wire."""
    if frame.extended:
        high, low = frame.identifier >> 18, frame.identifier & 0x3FFFF
        return (high << 2 | 0b11) << 18 | low
    return frame.identifier << 20
