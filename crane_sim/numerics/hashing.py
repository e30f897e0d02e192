"""SHA-256 of sixteen messages of one length at once, one in each lane of a vector of 512 bits.

FIPS 180-4. On a processor with AVX-512 it takes half the time of the instructions that hash one message; without them
the library does it.
"""

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import binding, ir
from numba.core import cgutils, types
from numba.core import config as numba_config

from crane_sim.numerics.jit import entry_point, intrinsic
from crane_sim.numerics.lanes import use_wide_vectors

LANES = 16
"""32-bit words of a vector."""
BLOCK = 64  # bytes
_settings: Any = numba_config
IS_WIDE = bool(dict(binding.get_host_cpu_features()).get("avx512f")) and not _settings.DISABLE_JIT
"""Whether the processor has vectors of 512 bits, and code is compiled."""
_PRIMES = [p for p in range(2, 312) if all(p % d for d in range(2, p))]


def _fraction_bits(prime: int, root: int) -> int:
    """Return the first 32 bits of the fractional part of the square root (2) or cube root (3) of a prime."""
    scaled, low, high = prime << (32 * root), 0, prime << 32
    while low < high:  # the whole root of the scaled prime
        middle = (low + high + 1) // 2
        low, high = (middle, high) if middle**root <= scaled else (low, middle - 1)
    return low & 0xFFFFFFFF


START = np.array([_fraction_bits(prime, 2) for prime in _PRIMES[:8]], np.uint32)
ROUNDS = [_fraction_bits(prime, 3) for prime in _PRIMES]
_WORD: Any = ir.IntType(32)
_VECTOR: Any = ir.VectorType(_WORD, LANES)


def _constant(value: int) -> Any:
    return ir.Constant(_VECTOR, [value] * LANES)


def _call(builder: Any, name: str, *args: Any) -> Any:
    kind = ir.FunctionType(_VECTOR, [_VECTOR] * len(args))
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{LANES}i32"), args)


def _rotations(builder: Any, x: Any, first: int, second: int, third: int, shifted: bool = False) -> Any:
    """Return x rotated right by three numbers of bits, combined by exclusive or; the third one is shifted if asked."""
    parts = [_call(builder, "fshr", x, x, _constant(bits)) for bits in (first, second)]
    last = builder.lshr(x, _constant(third)) if shifted else _call(builder, "fshr", x, x, _constant(third))
    return builder.xor(builder.xor(*parts), last)


def _transpose(builder: Any, rows: list[Any]) -> list[Any]:
    """Return the columns of a square of words."""
    index, step = ir.VectorType(_WORD, LANES), 1
    while step < LANES:
        low = ir.Constant(index, [k if not k & step else LANES + k - step for k in range(LANES)])
        high = ir.Constant(index, [k + step if not k & step else LANES + k for k in range(LANES)])
        for i in (i for i in range(LANES) if not i & step):
            pair = rows[i], rows[i + step]
            rows[i], rows[i + step] = (builder.shuffle_vector(*pair, mask) for mask in (low, high))
        step *= 2
    return rows


def _rounds(builder: Any, state: Sequence[Any], words: list[Any]) -> list[Any]:
    """Return the state after a block of 16 words, each of all messages."""
    add, (a, b, c, d, e, f, g, h) = builder.add, state
    for t, constant in enumerate(ROUNDS):
        if t >= len(words):
            old, recent = words[t - 15], words[t - 2]
            mixed = add(words[t - 16], _rotations(builder, old, 7, 18, 3, shifted=True))
            words.append(add(add(mixed, words[t - 7]), _rotations(builder, recent, 17, 19, 10, shifted=True)))
        choice = builder.xor(g, builder.and_(e, builder.xor(f, g)))
        keyed = add(add(h, words[t]), _constant(constant))
        first = add(add(keyed, choice), _rotations(builder, e, 6, 11, 25))
        majority = builder.or_(builder.and_(a, b), builder.and_(c, builder.or_(a, b)))
        second = add(_rotations(builder, a, 2, 13, 22), majority)
        a, b, c, d, e, f, g, h = add(first, second), a, b, c, add(d, first), e, f, g
    return [add(old, new) for old, new in zip(state, (a, b, c, d, e, f, g, h), strict=True)]


@intrinsic
def _hash_blocks(typing_context, state, messages, count):
    """Take blocks of 16 messages, rows of words (16, m), into the state (8, 16)."""

    def generate(context, builder, signature, args):
        held, rows = (context.make_array(kind)(context, builder, args[k]) for k, kind in enumerate((state, messages)))
        to_vector, stride = _VECTOR.as_pointer(), builder.extract_value(rows.shape, 1)
        places = [builder.gep(held.data, [ir.IntType(64)(k * LANES)]) for k in range(len(START))]
        loaded = [builder.load(builder.bitcast(place, to_vector), align=4) for place in places]
        kept = [cgutils.alloca_once_value(builder, value) for value in loaded]
        with cgutils.for_range(builder, args[2], intp=args[2].type) as loop:
            first = builder.mul(loop.index, args[2].type(LANES))
            starts = [builder.add(builder.mul(stride, args[2].type(k)), first) for k in range(LANES)]
            found = [builder.load(builder.bitcast(builder.gep(rows.data, [at]), to_vector), align=4) for at in starts]
            words = [_call(builder, "bswap", column) for column in _transpose(builder, found)]
            after = _rounds(builder, [builder.load(place) for place in kept], words)
            for place, value in zip(kept, after, strict=True):
                builder.store(value, place)
        for place, value in zip(places, kept, strict=True):
            builder.store(builder.load(value), builder.bitcast(place, to_vector), align=4)
        return context.get_dummy_value()

    return types.none(state, messages, types.intp), generate


@entry_point
def hash_blocks(state, messages, count):
    """Take the first `count` blocks of messages (16, m), 32-bit words, into their state (8, 16)."""
    use_wide_vectors()
    _hash_blocks(state, messages, count)


def hexdigests_in_lanes(messages: npt.NDArray[Any]) -> list[str]:
    """Return the SHA-256 of 16 messages, the rows of a contiguous array (16, ...), each of whole words of 4 bytes."""
    words = messages.reshape(LANES, -1).view(np.uint32)
    size, whole = 4 * words.shape[1], words.shape[1] // LANES
    last = np.ascontiguousarray(words[:, LANES * whole :]).view(np.uint8)
    rest = np.zeros((LANES, -(-(last.shape[1] + 9) // BLOCK) * BLOCK), np.uint8)
    rest[:, : last.shape[1]], rest[:, last.shape[1]] = last, 0x80
    rest[:, -8:] = np.frombuffer((8 * size).to_bytes(8, "big"), np.uint8)
    state = np.repeat(START[:, None], LANES, axis=1)
    hash_blocks(state, words, whole)
    hash_blocks(state, rest.view(np.uint32), rest.shape[1] // BLOCK)
    return [digest.tobytes().hex() for digest in state.T.astype(">u4")]


def hexdigests(messages: npt.NDArray[Any]) -> list[str]:
    """Return the SHA-256 of messages, the rows of a contiguous array (n, ...), each of whole words of 4 bytes."""
    if IS_WIDE and len(messages) == LANES:
        return hexdigests_in_lanes(messages)
    return [hashlib.sha256(message).hexdigest() for message in messages]
