"""Files that are damaged at random places, as disks, power cuts and copies damage them."""

import random
from pathlib import Path

KINDS = ("flip a bit", "flip bytes", "zero 64 bytes", "zero a block", "swap blocks", "cut")
_BLOCK = 512  # bytes: of a sector


def damage(data: bytes, seed: int) -> tuple[str, bytes]:
    """Return (kind of damage, the damaged bytes) that follow from a seed."""
    draw, changed = random.Random(seed), bytearray(data)
    kind = KINDS[seed % len(KINDS)]
    at = draw.randrange(len(data))
    if kind == "flip a bit":
        changed[at] ^= 1 << draw.randrange(8)
    elif kind == "flip bytes":
        for _ in range(draw.randint(1, 8)):
            changed[draw.randrange(len(data))] ^= draw.randint(1, 255)
    elif kind in ("zero 64 bytes", "zero a block"):
        size = 64 if kind == "zero 64 bytes" else _BLOCK
        changed[at : at + size] = bytes(len(changed[at : at + size]))
    elif kind == "swap blocks":
        blocks = [changed[i : i + _BLOCK] for i in range(0, len(changed), _BLOCK)]
        i, j = draw.randrange(len(blocks)), draw.randrange(len(blocks))
        blocks[i], blocks[j] = blocks[j], blocks[i]
        changed = bytearray().join(blocks)
    else:
        del changed[at:]
    return kind, bytes(changed)


def write_damaged(source: Path, target: Path, seed: int) -> str:
    """Write a damaged copy of a file; return the kind of damage."""
    kind, data = damage(source.read_bytes(), seed)
    target.write_bytes(data)
    return kind
