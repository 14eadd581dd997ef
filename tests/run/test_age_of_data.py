"""Age of data: exact for frames and samples at known instants, unmoved by what is no solution."""

from __future__ import annotations

import pytest

from firmware.link.frames import PAYLOADS, SOLUTION, STATUS, FrameWriter
from hal.emulated.uart_bytes import SentBytes
from host.run.age_of_data import AgeOfData

MS = 1_000_000
START_NS = 5_000 * MS
"""When the board's clock began."""


def frame(kind: int, clock_us: int) -> bytes:
    layout = PAYLOADS[kind]
    values = layout.unpack(bytes(layout.size))
    return FrameWriter().pack(kind, clock_us, *values[1:])


def heard(samples: list[int | None], *frames: tuple[int, int, int]) -> dict[str, float | None]:
    """Figures after frames (kind, board time µs, first bit ns) with such instants of the chips' samples."""
    ages = AgeOfData([lambda one=one: one for one in samples], lambda clock_ns: START_NS + clock_ns)  # type: ignore[misc]
    for kind, clock_us, first_bit_ns in frames:
        ages.announce(SentBytes(frame(kind, clock_us), first_bit_ns, 0, 230_400))
    return ages.figures()


def test_age_is_that_of_the_oldest_sample() -> None:
    figures = heard(
        [START_NS + 7 * MS, START_NS + 6 * MS, None],
        (SOLUTION, 10_000, START_NS + 12 * MS),
        (STATUS, 10_000, START_NS + 90 * MS),
        (SOLUTION, 11_000, START_NS + 14 * MS),
    )
    assert figures["age_of_data_mean_us"] == 7_000.0
    assert figures["age_of_data_max_us"] == 8_000.0
    assert figures["sample_to_epoch_mean_us"] == 4_500.0
    assert figures["epoch_to_line_max_us"] == 3_000.0


def test_what_says_nothing_is_left_out() -> None:
    silent_for_long = [START_NS + 7 * MS, START_NS - 500 * MS]
    assert heard(silent_for_long, (SOLUTION, 10_000, START_NS + 12 * MS))["age_of_data_max_us"] == 5_000.0
    of_a_later_tick = [START_NS + 16 * MS]
    assert heard(of_a_later_tick, (SOLUTION, 10_000, START_NS + 18 * MS))["age_of_data_max_us"] is None
    assert heard([], (SOLUTION, 10_000, START_NS + 12 * MS)) == {}


def test_of_a_hundred_ages_the_95th_is_told() -> None:
    frames = [(SOLUTION, 50_000, START_NS + 50 * MS + k * 100_000) for k in range(1, 101)]
    figures = heard([START_NS + 50 * MS], *frames)
    assert figures["epoch_to_line_p95_us"] == pytest.approx(9_500.0, abs=10.0)
    assert figures["epoch_to_line_max_us"] == 10_000.0
