"""A scripted I²C bus."""

from hal.errors import BusError, ErrorKind
from hal.scripted.transcript import Transcript, hex_words, to_bytes

FAILURES = {
    "address-nack": ErrorKind.ADDRESS_NACK,
    "data-nack": ErrorKind.DATA_NACK,
    "timeout": ErrorKind.TIMEOUT,
}


class ScriptedI2c:
    """Implements `hal.i2c.I2cBus`: `i2c NAME ADDRESS [write BYTES] [read N] -> BYTES`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name

    def transaction(self, address: int, write: bytes = b"", read_length: int = 0) -> bytes:
        """Run one transaction and return the bytes read."""
        action = f"i2c {self.name} {address:02x}"
        if write:
            action += f" write {hex_words(write)}"
        if read_length:
            action += f" read {read_length}"
        reply = self._transcript.take(action)
        if len(reply) == 1 and reply[0] in FAILURES:
            raise BusError(FAILURES[reply[0]], f"scripted, address 0x{address:02X} on {self.name!r}")
        data = to_bytes(reply)
        if len(data) != read_length:
            raise ValueError(
                f"the transcript answers {len(data)} bytes to a read of {read_length} on i2c {self.name!r}"
            )
        return data
