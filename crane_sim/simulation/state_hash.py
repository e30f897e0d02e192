"""The hash of a run's states, taken block by block, which a copy of the run goes on with."""

import hashlib
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class StateHash:
    """SHA-256 of the little-endian float64 bytes of rows.

    A copy goes on by itself. OpenSSL's hash cannot be pickled: one that shall be `picklable` keeps
    all rows.
    """

    def __init__(self, picklable: bool = False) -> None:
        """Begin with no rows."""
        self._sha = hashlib.sha256()
        self._blocks: list[bytes] | None = [] if picklable else None

    def extend(self, rows: Array) -> None:
        """Take rows (K, n)."""
        block = rows.astype("<f8").tobytes()
        self._sha.update(block)
        if self._blocks is not None:
            self._blocks.append(block)

    def hexdigest(self, last: Array) -> str:
        """Return the hash of the rows and of a last one (n,), which is not kept."""
        sha = self._sha.copy()
        sha.update(last.astype("<f8").tobytes())
        return sha.hexdigest()

    def __deepcopy__(self, memo: dict[int, Any]) -> "StateHash":
        """Return a hash of the same rows."""
        copy = StateHash(self._blocks is not None)
        copy._sha, copy._blocks = (
            self._sha.copy(),
            None if self._blocks is None else [*self._blocks],
        )
        return copy

    def __getstate__(self) -> list[bytes]:
        """Return what it has taken; raises TypeError where that is not kept."""
        if self._blocks is None:
            raise TypeError(
                "the hash of a run's states is pickled only where they are kept: Plant(scene, "
                "picklable=True)"
            )
        return self._blocks

    def __setstate__(self, blocks: list[bytes]) -> None:
        """Take what another one had taken."""
        self._sha, self._blocks = hashlib.sha256(b"".join(blocks)), blocks
