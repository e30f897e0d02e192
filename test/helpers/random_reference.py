"""Random numbers of `hardware.random` in Python's whole numbers."""

from math import cos, log, pi, sqrt

WORD = 2**64


def mix(z: int) -> int:
    """Return SplitMix64's output for a state, in whole numbers."""
    z = (z + 0x9E3779B97F4A7C15) % WORD
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 % WORD
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB % WORD
    return z ^ (z >> 31)


def uniform(seed: int, stream: int, k: int) -> float:
    """Return the uniform number of a stream and a counter."""
    return (mix(mix(mix(seed) ^ stream) ^ k) >> 11) * 2.0**-53


def normal(seed: int, stream: int, k: int) -> float:
    """Return the normal number of two streams and a counter."""
    return sqrt(-2.0 * log(1.0 - uniform(seed, stream, k))) * cos(
        2.0 * pi * uniform(seed, stream + 1, k)
    )
