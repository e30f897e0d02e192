"""Ranges of which a bound or the step is a symbol."""

from typing import Any

from crane_sim.tracing.arithmetic import choose, combine, is_natural, least_of
from crane_sim.tracing.graph import Value
from crane_sim.tracing.trace_error import TraceError


class Range:
    """The numbers of a range; the index of a turn is the number itself."""

    def __init__(self, *bounds: Any) -> None:
        """Take what `range` takes.

        Raises:
            TraceError: the step is zero.
        """
        self.first, self.last, self.step = (
            (0, bounds[0], 1) if len(bounds) == 1 else (*bounds, 1)[:3]
        )
        if not isinstance(self.step, Value) and self.step == 0:
            raise TraceError("a range with a step of 0")

    @property
    def least(self) -> int | None:
        """Return what no index is known to be less than, None where nothing is known."""
        return least_of(self.first) if is_natural(self.step) else None

    def includes(self, index: Any) -> Any:
        """Return whether an index that a turn may begin with is one of the range."""
        if not isinstance(self.step, Value):
            return combine("less" if self.step > 0 else "greater", index, self.last)
        rises = combine("greater", self.step, 0)
        return choose(
            rises, combine("less", index, self.last), combine("greater", index, self.last)
        )

    def value(self, index: Any) -> Any:
        """Return what the loop's variable is at an index."""
        return index


class SimdRange(Range):
    """The numbers of a `vectors.simd_range`."""
