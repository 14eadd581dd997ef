"""What a SiRF III hears in its binary protocol.

    A0 A2 | length, 2 bytes | payload | sum of the payload & 0x7FFF, 2 bytes | B0 B3     high byte first

| message | fields | what it does here |
| --- | --- | --- |
| 129 | mode, ten pairs of rate and checksum switch, baud (2 bytes) | back to NMEA |
| 132 | control | version: message 6 |
| 134 | baud (4 bytes), data bits, stop bits, parity, 0 | port |
| 166 | mode, message, rate in s, 4 × 0 | 0 sets a rate, 1 asks once, 2 sets that of all |
| 128, 133 … 170 | | modes, masks, aiding, polls: accepted and without effect |

The payload of 129 has 24 bytes: 0x81, mode, ten pairs of rate and checksum switch, baud rate (2 bytes).
"""

from __future__ import annotations

HEAD, TAIL = b"\xa0\xa2", b"\xb0\xb3"
SWITCH_TO_NMEA, POLL_VERSION, SET_PORT, SET_RATE = 129, 132, 134, 166
WITHOUT_EFFECT = frozenset((128, *range(133, 171))) - {SET_PORT, SET_RATE}
EIGHT_ONE_NONE = bytes((8, 1, 0))
SWITCH_LENGTH = 24
LONGEST = 1023
RATES_FROM = 2
ORDER = (0, 1, 2, 3, 4, 5, 6, None, 8, None)
"""Which message each pair is for."""


class BinaryInput:
    """Bytes in, payloads with a good checksum out."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[bytes]:
        """The payloads that `data` completes."""
        buffer = self._buffer
        buffer += data
        found: list[bytes] = []
        while (at := buffer.find(HEAD)) >= 0:
            del buffer[:at]
            if len(buffer) < 4:
                return found
            length = int.from_bytes(buffer[2:4], "big")
            if length > LONGEST:
                del buffer[:1]
                continue
            if len(buffer) < length + 8:
                return found
            payload = bytes(buffer[4 : 4 + length])
            check = int.from_bytes(buffer[4 + length : 6 + length], "big")
            if check == sum(payload) & 0x7FFF and bytes(buffer[6 + length : 8 + length]) == TAIL:
                found.append(payload)
                del buffer[: length + 8]
            else:
                del buffer[:1]
        del buffer[: max(0, len(buffer) - 1)]
        return found


def switch_of(payload: bytes) -> tuple[dict[int, int], int] | None:
    """(rate in s of each message, baud) of message 129; None for any other."""
    if len(payload) != SWITCH_LENGTH or payload[0] != SWITCH_TO_NMEA:
        return None
    rates = {
        message: payload[RATES_FROM + 2 * place] for place, message in enumerate(ORDER) if message is not None
    }
    return rates, int.from_bytes(payload[22:24], "big")
