"""SHA-256 of sixteen messages in lanes: the digests of the library."""

import hashlib

import numpy as np
import pytest

from crane_sim.numerics.hashing import hexdigests, hexdigests_in_lanes

RNG = np.random.default_rng(1)


@pytest.mark.parametrize("words", [0, 1, 13, 14, 15, 16, 29, 30, 20010])  # the padding takes one block, or two
def test_messages_in_lanes_have_the_digests_of_the_library(words: int) -> None:
    """Messages of whole blocks, of parts of one, and of none have the digest that hashlib gives each of them."""
    messages = RNG.integers(0, 2**32, (16, words), dtype=np.uint32)
    assert hexdigests_in_lanes(messages) == [hashlib.sha256(message.tobytes()).hexdigest() for message in messages]


@pytest.mark.parametrize("count", [1, 16])
def test_any_number_of_messages_is_hashed(count: int) -> None:
    """Arrays of floats are hashed by their bytes, as many as there are."""
    messages = RNG.random((count, 7, 3))
    assert hexdigests(messages) == [hashlib.sha256(message.tobytes()).hexdigest() for message in messages]
