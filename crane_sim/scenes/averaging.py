"""Disturbances of a crane at their mean over time, for the linearisation of its equations.

A base rests at the mean of its motion: the offsets of sinusoids, the mean of a record. A given
force is its mean: a constant, the offset of a sine, the mean of a table over its times. A
polynomial that varies has no mean, since it grows without bound, and counts as no force. Wind is
without its gusts. A prescribed motion rests at its initial position. Types are kept, so that
compiled equations serve both scenes.
"""

from dataclasses import replace
from functools import singledispatch
from math import sin
from typing import Any

import numpy as np

from crane_sim.models.supports.hoist import PrescribedHoist
from crane_sim.models.supports.rails import PrescribedAxis
from crane_sim.scenes.scene import Scene
from crane_sim.tracing.trees import rebuilt
from crane_sim.trajectories.base_motion import Base, SplineBase
from crane_sim.trajectories.inputs import Polynomial, Sine, Table
from crane_sim.trajectories.profiles import Motion
from crane_sim.trajectories.wind import Gust

REST = Motion(np.zeros(1), np.zeros((1, 1)))
"""Zero acceleration: all the equations take from a prescribed motion; its position is part of the
state."""


def average_scene(scene: Scene) -> Scene:
    """Return the scene with every disturbance of its model replaced by its mean."""
    model = average(scene.model)
    return scene if model is scene.model else replace(scene, model=model)


@singledispatch
def average(part: Any) -> Any:
    """Return a part of a model with its time-varying quantities, if any, at their mean."""
    if not isinstance(part, tuple):
        return part
    means = [average(each) if isinstance(each, tuple) else each for each in part]
    if all(mean is each for mean, each in zip(means, part, strict=True)):
        return part
    return rebuilt(part, means)


@average.register
def _average_base(part: Base) -> Base:
    constant_part = np.where(part.frequencies == 0.0, part.amplitudes * np.sin(part.phases), 0.0)
    return Base(part.offsets + constant_part.sum(axis=1), *np.zeros((3, len(part.offsets), 1)))


@average.register
def _average_spline(part: SplineBase) -> SplineBase:
    spans, powers = np.diff(part.knots), np.arange(1, part.coefficients.shape[2] + 1)
    areas = np.sum(part.coefficients * spans[:, None] ** powers / powers, axis=(1, 2))
    return SplineBase(part.knots[[0, -1]], (areas / spans.sum()).reshape(-1, 1, 1))


@average.register
def _average_gust(part: Gust) -> Gust:
    return Gust(part.rate, np.zeros((1, part.nodes.shape[1])))


@average.register
def _average_sine(part: Sine) -> Sine:
    constant_part = part.amplitude * sin(part.phase) if part.frequency == 0.0 else 0.0
    return Sine(0.0, 0.0, part.offset + constant_part)


@average.register
def _average_polynomial(part: Polynomial) -> Polynomial:
    return part if not any(part.coefficients[1:]) else Polynomial((0.0,) * len(part.coefficients))


@average.register
def _average_table(part: Table) -> Table:
    if len(set(part.values)) == 1:
        return part
    mean = float(np.trapezoid(part.values, part.times)) / (part.times[-1] - part.times[0])
    return Table(part.times, (mean,) * len(part.values))


@average.register
def _rest_axis(part: PrescribedAxis) -> PrescribedAxis:
    return PrescribedAxis(REST)


@average.register
def _rest_hoist(part: PrescribedHoist) -> PrescribedHoist:
    return PrescribedHoist(REST)
