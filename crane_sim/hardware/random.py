"""Random numbers without a state: each is a function of a seed, a stream and a counter.

So a draw does not depend on what was drawn before it, and is the same after a restart. The mixing
function is that of SplitMix64 (Steele, Lea, Flood, "Fast Splittable Pseudorandom Number
Generators", OOPSLA 2014).
"""

from math import cos, log, pi, sqrt

import numpy as np

UINT64_RANGE = 2**64
_STEP, _FIRST, _SECOND = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xBF58476D1CE4E5B9),
    np.uint64(0x94D049BB133111EB),
)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_UNIT = 2.0**-53


def seed_to_uint64(seed: int) -> np.uint64:
    """Return a seed reduced modulo 2^64, as compiled code takes it."""
    return np.uint64(seed % UINT64_RANGE)


def mix(z):
    """Return a word whose bits all depend on all bits of the word z."""
    z = z + _STEP
    z = (z ^ (z >> _30)) * _FIRST
    z = (z ^ (z >> _27)) * _SECOND
    return z ^ (z >> _31)


def uniform(seed, stream, k):
    """Return the number, uniform in [0, 1), of a seed (a word), a stream and a counter.

    Stream and counter are whole numbers >= 0.
    """
    z = mix(mix(mix(seed) ^ np.uint64(stream)) ^ np.uint64(k))
    return np.float64(z >> _11) * _UNIT


def normal(seed, stream, k):
    """Return the normal number, mean 0 and deviation 1, of two streams (Box and Muller).

    They are `stream` and the next one.
    """
    radius = sqrt(-2.0 * log(1.0 - uniform(seed, stream, k)))
    return radius * cos(2.0 * pi * uniform(seed, stream + 1, k))
