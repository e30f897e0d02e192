"""Breakpoints: instants at which a function of time is not smooth, which no step with error control may pass.

A crane at rest has no error, so its steps grow: without breakpoints one of them would pass a motion that begins later
without a stage in it.
"""

from math import inf
from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.numerics.jit import lean_generic
from crane_sim.trajectories.base_motion import SplineBase
from crane_sim.trajectories.inputs import Table
from crane_sim.trajectories.piecewise import find_piece
from crane_sim.trajectories.profiles import Motion
from crane_sim.trajectories.trajectory import Trajectory

_CLOSEST = 1e-9  # s, between two breakpoints


class PiecewiseSource(NamedTuple):
    """A source of efforts; it, and the motions that are prescribed to the crane, are smooth between breakpoints."""

    source: Any
    breakpoints: Any  # (n,) s, increasing, n > 0


@system.effort.register(PiecewiseSource)
def _(u, p, t, x):
    return system.effort(u.source, p, t, x)


@lean_generic
def next_breakpoint(u, t):
    """Return the first breakpoint [s] of a source after time t, infinite where there is none."""
    return inf


@next_breakpoint.register(PiecewiseSource)
def _(u, t):
    count = len(u.breakpoints)
    if t < u.breakpoints[0]:
        return u.breakpoints[0]
    i = find_piece(u.breakpoints, count, t) + 1
    return u.breakpoints[i] if i < count else inf


def with_breakpoints(source: Any, model: Any) -> Any:
    """Return a source with its breakpoints and those of the model; the source itself where none is after t = 0."""
    instants = np.unique(np.concatenate([np.empty(0), *_collect((source, model))]))
    instants = instants[instants > 0.0]
    kept = instants[np.diff(instants, prepend=-inf) > _CLOSEST]
    return PiecewiseSource(source, kept) if kept.size else source


def _collect(tree: Any) -> list[Any]:
    """Return the breakpoints [s] of all functions of time in a tree of tuples."""
    if isinstance(tree, Motion | Trajectory):
        return [np.asarray(tree.starts, dtype=float)[1:]]
    if isinstance(tree, Table):
        return [np.asarray(tree.times, dtype=float)]
    if isinstance(tree, SplineBase):
        return [np.asarray(tree.knots, dtype=float)]
    return [instants for part in tree for instants in _collect(part)] if isinstance(tree, tuple) else []
