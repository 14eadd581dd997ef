"""The FIFO worked out from times and the FIFO of the general way show the same, whatever is asked and when.

A pin that somebody follows, with overrun on it, keeps a chip on the general way; the same chip without a
listener takes the short one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from adxl345_rig import MS, US, G, Rig
from hypothesis import given, settings
from hypothesis import strategies as some

SECOND = 1_000 * MS
BURST, STATUS = b"\xf2" + bytes(6), b"\xb9\x00"
FIFO, STREAM, TRIGGER = 0x40, 0x80, 0xC0
OVERRUN = 0x01


def wandering(t: Any) -> dict[str, Any]:
    """No two samples alike for seconds."""
    return {"fx": 3.0 * np.sin(7.0 * t), "fy": 5.0 * np.sin(11.1 * t), "fz": G + np.sin(13.7 * t)}


PAUSES = some.sampled_from((0, 2 * US, 5 * US, 5 * US, 20 * US))
USUAL = some.one_of(
    some.tuples(some.just("samples"), some.integers(0, 3)),
    some.tuples(some.just("samples"), some.integers(29, 35)),
    some.tuples(some.just("drain"), some.integers(1, 34), PAUSES),
    some.tuples(some.just("status"), PAUSES),
)
SELDOM = some.one_of(
    some.tuples(some.just("wait"), some.sampled_from((3 * US, 8 * SECOND))),
    some.tuples(some.just("wait"), some.integers(0, 40 * MS)),
    some.tuples(some.just("i2c"), some.integers(1, 6)),
    some.tuples(some.just("register"), some.sampled_from((0x00, 0x2B, 0x2C, 0x30, 0x31, 0x36, 0x38))),
    some.tuples(some.just("write"), some.sampled_from((0x2C0B, 0x2C09, 0x1E05, 0x310B, 0x3100, 0x2D08))),
    some.tuples(some.just("mode"), some.sampled_from((0x00, FIFO | 8, STREAM | 16, TRIGGER | 8))),
    some.tuples(some.just("clock"), some.sampled_from((0, 4_000, -9_000))),
    some.tuples(some.just("power")),
)
ACCESSES = some.one_of(USUAL, USUAL, USUAL, SELDOM)


class Asked(Rig):
    """Does what the accesses say; `heard` is all that came back, with its time."""

    def __init__(self, listen: str) -> None:
        super().__init__(wandering, listen=listen, byte_ns=2 * US)
        self.heard: list[tuple[int, bytes]] = []

    def begin(self, mode: int, rate: int) -> None:
        self.write(0x2E, OVERRUN)
        self.write(0x38, mode)
        self.measure(rate=rate)
        self.period_ns = 312_500 << (15 - rate)
        self.wait(2 * self.period_ns)
        self.ask(BURST)

    def ask(self, mosi: bytes, pause_ns: int = 10 * US) -> bytes:
        miso = self.spi(mosi)
        self.wait(pause_ns)
        self.heard.append((self.time.now, miso))
        return miso

    def do(self, what: str, how: int = 0, pause_ns: int = 10 * US) -> None:
        if what == "wait":
            self.wait(how)
        elif what == "samples":
            self.wait(how * self.period_ns)
        elif what == "drain":
            self.ask(STATUS)
            for _ in range(how):
                self.ask(BURST, pause_ns)
        elif what == "status":
            self.ask(STATUS, how)
        elif what == "i2c":
            self.chip.i2c.write(b"\x32", self.time.now)
            self.heard.append((self.time.now, self.chip.i2c.read(how, self.time.now)))
        elif what == "register":
            self.ask(bytes((0x80 | how, 0)))
        elif what == "write":
            self.ask(how.to_bytes(2, "big"))
        elif what == "mode":
            self.ask(bytes((0x38, how)))
        elif what == "clock":
            self.chip.set_clock_error(float(how))
        else:
            self.chip.brownout()
            self.begin(STREAM | 16, 0x0B)


@settings(max_examples=50, deadline=None)
@given(
    some.sampled_from((FIFO | 16, STREAM | 16, STREAM | 31, TRIGGER | 4)),
    some.sampled_from((0x0A, 0x0B, 0x0D)),
    some.lists(ACCESSES, max_size=40),
)
def test_short_and_general_way_show_the_same(mode: int, rate: int, accesses: list[Any]) -> None:
    short, general = Asked(""), Asked("INT1")
    for rig in (short, general):
        rig.begin(mode, rate)
        for access in accesses:
            rig.do(*access)
        rig.do("drain", 34)
        rig.do("register", 0x30)
    assert short.heard == general.heard
    assert [str(one) for one in short.chip.reports] == [str(one) for one in general.chip.reports]


def test_a_reader_at_the_chips_own_pace_gets_every_sample_once() -> None:
    """Over the ends of two blocks, with none, one or two samples at a look."""
    rig = Rig(lambda t: {"fx": 400.0 * t / 256.0 * G}, clock_error_ppm=6_000.0)
    rig.write(0x38, STREAM | 16)
    rig.measure(rate=0x0B)
    got: list[int] = []
    while rig.time.now < 9 * SECOND:
        rig.wait(4_900 * US)
        for _ in range(rig.spi(STATUS)[1] & 0x3F):
            got.append(int.from_bytes(rig.spi(BURST)[1:3], "little", signed=True))
            rig.wait(5 * US)
    assert len(rig.world.calls) >= 3
    first_ns = rig.world.calls[0][0]
    wanted = [round(400.0 * (first_ns * 1e-9 + k / 201.2)) for k in range(len(got))]
    assert max(abs(one - other) for one, other in zip(got, wanted, strict=True)) <= 1
    assert abs(len(got) - (9 - first_ns * 1e-9) * 201.2) < 2
