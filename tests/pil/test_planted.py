"""Differences built into images of whole boards are caught, in floating and in fixed point."""

import json

import pytest
from pil_tools import needs_processor

from host.cli.pil_run import Asked, execute
from host.pil.planted import plant
from host.record.result import RunRequest

FIXED = """define i64 @a(i64 %x) {
  %t = mul nsw i64 %x, 341782638
  %h = add i64 %t, 536870912
  %r = ashr i64 %h, 30
  %k = mul nsw i64 %r, 36
  %z = add i64 %k, 536870912
  ret i64 %z
}
"""


def test_planted_constants_leave_sizes_alone():
    assert plant("constant", FIXED) == FIXED.replace("341782638", "341782639")


def test_planted_rounding_leaves_out_halves_and_nothing_else():
    assert plant("rounding", FIXED) == FIXED.replace("%t, 536870912", "%t, 0")


@pytest.mark.soak
@needs_processor
@pytest.mark.parametrize(
    ("board", "scenario", "profile", "planted"),
    [
        ("car_mems", "static", "full-rate", "fma"),
        ("uav_ahrs", "flight", "fixed", "constant"),
        ("uav_ahrs", "flight", "fixed", "rounding"),
    ],
)
def test_a_difference_in_a_board_is_caught(board, scenario, profile, planted, tmp_path):
    figures = tmp_path / "pil.json"
    asked = Asked(RunRequest(board, scenario, profile), 10_000, None, False, False, planted)
    assert execute(asked, str(figures), quiet=True) == 1
    found = json.loads(figures.read_text())
    assert found["differences"] == 10
    assert found["first_difference"]["kernel"].startswith(("firmware.nav.", "firmware.apps."))
    assert found["first_difference"]["twin"] != found["first_difference"]["target"]
