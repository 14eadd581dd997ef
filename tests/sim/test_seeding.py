"""Streams of random numbers: one for each seed and name, and never one for two."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.sim.seeding import LARGEST_SEED, generator

SEEDS = st.integers(0, LARGEST_SEED)
NAMES = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), min_size=1, max_size=12)


@given(SEEDS, NAMES, SEEDS, NAMES)
def test_streams_coincide_only_when_seed_and_name_do(seed, name, other_seed, other_name):
    draws = [
        generator(s, n).integers(0, 2**62, 3).tolist() for s, n in ((seed, name), (other_seed, other_name))
    ]
    assert (draws[0] == draws[1]) == ((seed, name) == (other_seed, other_name))


def test_the_stream_of_a_channel_stays_what_it_was():
    sequence = np.random.SeedSequence([7, *b"U2.gyro_x.noise"])
    expected = np.random.Generator(np.random.PCG64(sequence)).standard_normal(4)
    assert generator(7, "U2.gyro_x.noise").standard_normal(4).tolist() == expected.tolist()


@pytest.mark.parametrize(("seed", "name"), [(2**32 + 1, "a"), (-1, "a"), (1, ""), (1, "a\0")])
def test_what_could_be_taken_for_another_stream_is_refused(seed, name):
    with pytest.raises(ValueError, match=r"for example 1|e\.g\. 'U2"):
        generator(seed, name)
