"""Text of numbers against Python's own."""

import json
from decimal import ROUND_HALF_UP, Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.record.row_text import RowText


@given(st.floats(-1e6, 1e6), st.integers(0, 9))
def test_a_number_is_the_nearest_with_its_decimals(value, decimals):
    text = RowText.csv([decimals]).text(np.array([[value]])).decode().rstrip("\n")
    assert abs(Decimal(text) - Decimal(value)) <= Decimal(10) ** -decimals / 2 + Decimal(abs(value) * 2.3e-16)
    assert len(text.partition(".")[2]) == decimals
    assert not text.startswith("-") or Decimal(text) != 0


@pytest.mark.parametrize("value", [0.0, -0.0, 0.5, -0.5, 1.25, 9.995, 99.9999, 123456789.0, -1e-9, 1 / 3])
def test_ties_go_away_from_zero(value):
    for decimals in (0, 1, 3):
        text = RowText.csv([decimals]).text(np.array([[value]])).decode().strip()
        scaled = Decimal(value * 10.0**decimals).quantize(Decimal(1), ROUND_HALF_UP)
        assert Decimal(text) == scaled.scaleb(-decimals)


def test_rows_are_csv_lines_and_json_objects():
    rows = np.array([[1.5, np.nan], [-2.25, 40.0]])
    assert RowText.csv([2, 0]).text(rows) == b"1.50,\n-2.25,40\n"
    objects = [json.loads(text) for text in RowText.json(["a", "b"], [2, 0]).texts(rows)]
    assert objects == [{"a": 1.5, "b": None}, {"a": -2.25, "b": 40}]


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan, 1e300, 9.3e9])
def test_what_is_not_finite_or_too_large_is_left_empty(value):
    assert RowText.csv([9]).text(np.array([[value]])) == b"\n"


def test_no_rows_give_no_text():
    assert RowText.csv([3]).text(np.empty((0, 1))) == b""
    assert RowText.json(["a"], [3]).texts(np.empty((0, 1))) == []


def test_pieces_must_fit_the_columns():
    with pytest.raises(ValueError, match="2 columns need 3 pieces of text, not 1"):
        RowText([b","], [1, 2], b"")
