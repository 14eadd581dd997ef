"""UBX frames (fact sheet section 4): 0xB5 0x62, class, id, length, payload, two checksum bytes.

The checksum is the 8-bit Fletcher sum over class, id, length and payload.
"""

from itertools import accumulate

SYNC = b"\xb5\x62"
CLASS_NAV = 0x01
CLASS_INF = 0x04
CLASS_ACK = 0x05
CLASS_CFG = 0x06
CLASS_MON = 0x0A


def fletcher(data: bytes | bytearray) -> bytes:
    """CK_A, CK_B of `data`."""
    return bytes((sum(data) & 0xFF, sum(accumulate(data)) & 0xFF))


def frame(message_class: int, message_id: int, payload: bytes = b"") -> bytes:
    """A whole frame."""
    body = bytes((message_class, message_id)) + len(payload).to_bytes(2, "little") + payload
    return SYNC + body + fletcher(body)


def acknowledge(accepted: bool, message_class: int, message_id: int) -> bytes:
    """ACK-ACK or ACK-NAK of a message."""
    return frame(CLASS_ACK, 1 if accepted else 0, bytes((message_class, message_id)))
