"""Breakpoints: instants where a function of time is not smooth; no adaptive step passes one.

A crane at rest has no error, so its steps grow: without breakpoints one of them would pass a motion
that begins later without a stage in it. Where efforts are held over a period, steps end with it,
and have no breakpoints within.
"""

from math import inf
from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.trajectories.base_motion import SplineBase
from crane_sim.trajectories.inputs import Delayed, Table
from crane_sim.trajectories.piecewise import find_piece
from crane_sim.trajectories.profiles import Motion
from crane_sim.trajectories.trajectory import Trajectory

_CLOSEST = 1e-9  # s, between two breakpoints
# s, between those of a base's spline, which is smooth, but may be at rest for long
_BASE_INTERVAL = 1.0
_ULPS = 1e-15  # of a breakpoint: a few of its last digits


class PiecewiseSource(NamedTuple):
    """A source of efforts that is smooth between breakpoints, as are prescribed motions.

    The motions are those that are prescribed to the crane.
    """

    source: Any
    breakpoints: Any  # (n,) s, increasing, n > 0


@system.effort.register(PiecewiseSource)
def piecewise_effort(u, p, t, x):
    """Return the efforts of the source."""
    return system.effort(u.source, p, t, x)


@system.demand.register(PiecewiseSource)
def piecewise_demand(u, p, t, x):
    """Return the demand of the source."""
    return system.demand(u.source, p, t, x)


def next_breakpoint(u, t):
    """Return the first breakpoint [s] of a `PiecewiseSource` after time t, else infinity."""
    count = len(u.breakpoints)
    if t < u.breakpoints[0]:
        return u.breakpoints[0]
    i = find_piece(u.breakpoints, count, t) + 1
    return u.breakpoints[i] if i < count else inf


def last_instant_before(instant, t):
    """Return the end [s] of a step from t up to a breakpoint.

    Stages at its end must not see what begins there.
    """
    end = instant - _ULPS * instant
    return end if end > t else instant  # of an infinite one `end` is no number


def unwrap(source: Any) -> Any:
    """Return a source without its breakpoints."""
    return source.source if isinstance(source, PiecewiseSource) else source


def with_breakpoints(source: Any, model: Any) -> Any:
    """Return a source with its and the model's breakpoints.

    It is the source itself where none is after t = 0.
    """
    found = _collect((source, model))
    if not found:  # as in most scenes, of which a batch makes thousands
        return source
    instants = np.unique(np.concatenate(found))
    instants = instants[instants > 0.0]
    kept = instants[np.diff(instants, prepend=-inf) > _CLOSEST]
    return PiecewiseSource(source, kept) if kept.size else source


def _collect(tree: Any) -> list[Any]:
    """Return the breakpoints [s] of all functions of time in a tree of tuples."""
    if isinstance(tree, Motion | Trajectory):
        return [np.asarray(tree.starts, dtype=float)[1:]]
    if isinstance(tree, Delayed):
        return [tree.delay + np.concatenate([[0.0], *_collect(tree.channel)])]
    if isinstance(tree, Table):
        return [np.asarray(tree.times, dtype=float)]
    if isinstance(tree, SplineBase):
        return [np.arange(tree.knots[0], tree.knots[-1], _BASE_INTERVAL)]
    return [instants for part in tree if isinstance(part, tuple) for instants in _collect(part)]
