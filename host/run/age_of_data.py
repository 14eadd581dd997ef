"""How old data are when the board tells what it made of them: from the sample in the chip to the line.

    sample          the chip's own instant, by its own clock; of several chips that of the oldest
    epoch           the solution's time of validity, by the board's clock put on virtual time
    first bit       of the solution's frame on the line to the host

Measured outside of the firmware, at every frame of kind SOLUTION as the board queues it: which sample each
chip was last asked for is known then, and when the line will come to the frame. A chip whose last sample is
older than FORGOTTEN_NS gives none and does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from boards.chips.adxl345.chip import Adxl345
from boards.chips.adxl345.sample_age import read_sample_ns
from firmware.link.frames import HEADER_LENGTH, SOLUTION, SYNC
from hal.emulated.uart_bytes import SentBytes
from host.score.ages import AGE_FIGURES, Ages

HEAD = SYNC + bytes((SOLUTION,))
FORGOTTEN_NS = 100_000_000
LATER_NS = 2_000_000
"""A sample so long after the epoch is of a later tick."""
Teller = Callable[[], int | None]


def sample_tellers(chips: Mapping[str, Any]) -> list[Teller]:
    """Of all chips that can tell which sample was read last."""
    return [partial(read_sample_ns, chip) for chip in chips.values() if isinstance(chip, Adxl345)]


class AgeOfData:
    """Listens to the line to the host. Implements `hal.emulated.uart_faces.LineListener`."""

    def __init__(self, tellers: Sequence[Teller], virtual_ns: Callable[[int], int]) -> None:
        self._tellers = tellers
        self._virtual_ns = virtual_ns
        self._of_data, self._to_epoch, self._to_line = Ages(), Ages(), Ages()

    def announce(self, sent: SentBytes) -> None:
        """These bytes will be on the line."""
        data = sent.data
        if not data.startswith(HEAD) or len(data) < HEADER_LENGTH + 8:
            return
        clock_us = int.from_bytes(data[HEADER_LENGTH : HEADER_LENGTH + 8], "little")
        epoch_ns = self._virtual_ns(clock_us * 1000)
        after = sent.begin - FORGOTTEN_NS
        recent = [ns for tell in self._tellers if (ns := tell()) is not None and ns > after]
        if not recent or max(recent) > epoch_ns + LATER_NS:
            return
        oldest_ns = min(recent)
        self._of_data.add(sent.begin - oldest_ns)
        self._to_epoch.add(epoch_ns - oldest_ns)
        self._to_line.add(sent.begin - epoch_ns)

    def forget(self, _begin_from: int) -> None:
        """What was measured stays: the data had this age when they were queued."""

    def figures(self) -> dict[str, float | None]:
        """By the names of `AGE_FIGURES`; empty for a board without a chip that can tell."""
        if not self._tellers:
            return {}
        kinds = (self._of_data, self._to_epoch, self._to_line)
        values = [value for ages in kinds for value in ages.figures()]
        return dict(zip(AGE_FIGURES, values, strict=True))
