"""The instant told for the sample read last is that at which the world had what the registers showed."""

from __future__ import annotations

from typing import Any

import numpy as np
from adxl345_rig import MS, US, G, Rig
from hypothesis import given, settings
from hypothesis import strategies as some

from boards.chips.adxl345.sample_age import read_sample_ns

BURST, STATUS = b"\xf2" + bytes(6), b"\xb9\x00"
TURN = 2000
"""ms after which the force repeats itself."""


def clock_hand(t: Any) -> dict[str, Any]:
    """A count for each millisecond."""
    return {"fx": (np.floor(t * 1000.0) % TURN - TURN / 2 + 0.5) / 256.0 * G}


@settings(max_examples=25, deadline=None)
@given(
    some.lists(some.tuples(some.integers(0, 120), some.integers(0, 40)), min_size=1, max_size=30),
    some.sampled_from((0.0, 6300.0, -7800.0)),
    some.sampled_from(("", "INT1")),
)
def test_told_instant_is_that_of_the_sample(
    reads: list[tuple[int, int]], clock_ppm: float, listen: str
) -> None:
    rig = Rig(clock_hand, listen=listen, byte_ns=4 * US, clock_error_ppm=clock_ppm)
    assert read_sample_ns(rig.chip) is None
    rig.write(0x38, 0x9F)
    if listen:
        rig.write(0x2E, 0x01)
    rig.measure(rate=0x0B)
    rig.wait(50 * MS)
    for pause_ms, most in reads:
        rig.wait(pause_ms * MS)
        waiting = rig.spi(STATUS)[1] & 0x3F
        for _ in range(min(waiting, most)):
            count = int.from_bytes(rig.spi(BURST)[1:3], "little", signed=True)
            rig.wait(6 * US)
            told_ns = read_sample_ns(rig.chip)
            assert told_ns is not None
            assert told_ns < rig.time.now
            assert abs((told_ns // MS - (count + TURN // 2) + 1) % TURN - 1) <= 1
