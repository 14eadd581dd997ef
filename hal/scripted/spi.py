"""A scripted SPI slave."""

from hal.scripted.transcript import Transcript, hex_words, to_bytes


class ScriptedSpi:
    """Implements `hal.spi.SpiDevice`: `spi NAME BYTES -> BYTES`."""

    def __init__(self, transcript: Transcript, name: str) -> None:
        self._transcript = transcript
        self.name = name

    def transaction(self, buffer: bytearray) -> None:
        """Exchange the whole buffer in place."""
        reply = to_bytes(self._transcript.take(f"spi {self.name} {hex_words(buffer)}"))
        if len(reply) != len(buffer):
            raise ValueError(
                f"the transcript answers {len(reply)} bytes to {len(buffer)} on spi {self.name!r}; "
                "an exchange gives back as many as it sends, e.g. 'spi imu 80 00 -> 00 d1'"
            )
        buffer[:] = reply
