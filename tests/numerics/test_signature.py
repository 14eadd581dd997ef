import re

import numpy as np
import pytest

from firmware.numerics.signature import parse_signature


def test_arrays_and_scalars():
    signature = parse_signature("void(float32[::1], int64[::1], uint8[::1], int64, float32)")
    assert [(a.scalar, a.is_array) for a in signature.arguments] == [
        ("float32", True),
        ("int64", True),
        ("uint8", True),
        ("int64", False),
        ("float32", False),
    ]
    assert signature.results == ()


@pytest.mark.parametrize(
    ("text", "results", "is_tuple"),
    [
        ("float32(float32)", ["float32"], False),
        ("boolean()", ["boolean"], False),
        ("UniTuple(int32, 3)(int64)", ["int32"] * 3, True),
        ("Tuple((float32, int64, boolean))(float32[::1])", ["float32", "int64", "boolean"], True),
    ],
)
def test_results(text, results, is_tuple):
    signature = parse_signature(text)
    assert [r.scalar for r in signature.results] == results
    assert signature.returns_tuple is is_tuple


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("float32", "has not the form result(arguments)"),
        ("(float32)", "has not the form result(arguments)"),
        ("void(float32[::1]", "has not the form result(arguments)"),
        ("void(float)", "unknown type 'float'"),
        ("void(float32[:])", "unknown type 'float32[:]'"),
        ("void(float32[:, ::1])", "unknown type 'float32[:'"),
        ("none(float32)", "unknown type 'none'"),
    ],
)
def test_what_is_not_well_formed_is_shown_with_a_valid_example(text, message):
    with pytest.raises(
        ValueError, match=re.escape(message) + r".*; a valid one: \"void\(float32\[::1\], int64\)\""
    ):
        parse_signature(text)


def test_scalars_are_converted_as_the_compiled_kernel_does():
    (argument,) = parse_signature("void(float32)").arguments
    assert argument.convert(0.1) == np.float32(0.1)
    assert isinstance(argument.convert(1), np.float32)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.zeros(4), "got float64 of shape (4,)"),
        (np.zeros((2, 2), np.float32), "got float32 of shape (2, 2)"),
        (np.zeros(8, np.float32)[::2], "with strides (8,)"),
        ([0.0], "got a list"),
    ],
)
def test_wrong_arrays_are_refused(value, message):
    (argument,) = parse_signature("void(float32[::1])").arguments
    with pytest.raises(TypeError) as error:
        argument.convert(value)
    assert message in str(error.value)


def test_results_are_narrowed():
    signature = parse_signature("Tuple((float32, int32))()")
    single, integer = signature.convert_result((0.1, 7))
    assert (type(single), type(integer)) == (np.float32, np.int32)
    assert parse_signature("void()").convert_result(None) is None
