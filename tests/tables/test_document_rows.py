"""The document's tables as they were copied: complete, and consistent in themselves but for its own slips."""

from __future__ import annotations

import pytest

from host.tables.document import AXES, document_drift, document_rows

SLIP = ("pitch", -30.0, 1)
"""Printed with 0.839 for a measured −0.893."""
TABLE_5_1 = {
    ("pitch", 30): (29.856, 0.713, -0.621),
    ("pitch", -30): (-29.439, -0.893, 0.163),
    ("roll", 30): (-0.505, 30.784, 0.735),
    ("roll", -30): (0.827, -30.370, -0.765),
    ("yaw", 30): (0.216, 0.431, 30.196),
}
"""Rows that chapter 5 prints again; its roll at yaw 30 is 0.431, the appendix has 0.413."""


def test_every_ten_degrees_has_its_row() -> None:
    assert [row.angle_deg for row in document_rows("pitch")] == list(range(-90, 91, 10))
    assert [row.angle_deg for row in document_rows("roll")] == list(range(-180, 181, 10))
    assert [row.angle_deg for row in document_rows("yaw")] == list(range(0, 361, 10))


@pytest.mark.parametrize("axis", AXES)
def test_errors_are_those_of_the_measured_angles(axis: str) -> None:
    for row in document_rows(axis):
        for place, name in enumerate(AXES):
            set_deg = row.angle_deg if name == axis else 0.0
            off = abs(row.measured_deg[place] - set_deg)
            if (axis, row.angle_deg, place) == SLIP:
                assert off == pytest.approx(0.893)
                assert row.error_deg[place] == 0.839
            else:
                assert row.error_deg[place] == pytest.approx(off, abs=1e-9)


def test_rows_that_chapter_5_prints_too() -> None:
    for (axis, angle), measured in TABLE_5_1.items():
        row = next(row for row in document_rows(axis) if row.angle_deg == angle)
        for ours, theirs in zip(row.measured_deg, measured, strict=True):
            assert ours == pytest.approx(theirs, abs=0.0181)


def test_largest_error_is_below_a_degree_as_the_document_says() -> None:
    worst = max(row.worst_deg for axis in AXES for row in document_rows(axis))
    assert worst == 0.893


def test_drift() -> None:
    drift = document_drift()
    assert (drift.yaw_deg, drift.after_s) == (25.8, 30.0)
    assert drift.drift_deg == (0.814, 0.790, 1.394)
