"""Multiple shooting: predictions of a measured run, segment by segment, and their sensitivities.

Every segment begins with a state of its own, which is an unknown. Parameters are searched by the
logarithm of their ratio to the first guess: each keeps its sign, and none comes to the 0 that most
of them may not pass.

Sensitivities of a smooth prediction are its derivatives (`derivatives`). Where equations switch,
drives have states, or parameters move instants at which a motion is not smooth, which the steps as
they were taken do not see, they are central differences of order 6 of the same simulation. Steps
end at every instant and are far below their tolerance there, so a prediction is a smooth function
of its unknowns down to rounding: with `STEP` the truncation is some 1e-15 and rounding 1e-12 of the
scale. The search for the minimum has the outermost pair alone, a third of the simulations: it
converges as quickly, and errors of 1e-4 move its end by less than its stopping criterion does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from crane_sim.files.document import get_value
from crane_sim.files.errors import SceneError
from crane_sim.identification.derivatives import (
    Start,
    fill_derivatives,
    is_smooth,
    slopes_of_models,
)
from crane_sim.identification.measurements import Measurements
from crane_sim.numerics.derivatives import DIRECTIONS
from crane_sim.scenes.hardware_settings import is_nonideal
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.scenes.schema.hardware import ActuatorGroup, merge_groups
from crane_sim.simulation.hardware import HardwareRun
from crane_sim.simulation.initial_demands import initial_demands
from crane_sim.simulation.linearisation import tangent_basis
from crane_sim.stepping.excitation import Excitation, integrate_held, integrate_with_drives
from crane_sim.trajectories.breakpoints import with_breakpoints

Array = npt.NDArray[np.float64]
STEP = 2e-4  # of differences: of a logarithm, or m, rad and their rates of an initial state
# weights of central differences, by multiples of the step
ORDER_6 = {1: 3.0 / 4.0, 2: -3.0 / 20.0, 3: 1.0 / 60.0}
# over the same span: where it is finite, so are the outermost runs of order 6
ORDER_2 = {3: 1.0 / 6.0}
OMITTED = ("control", "sensors", "faults", "imu", "camera", "uncertain", "inputs")
"""Groups of a scene that say nothing on how the crane answers its commands, or that are not
constant."""
SAME_INSTANT = 1e-9  # s
# m or rad, or of a joint's range, whichever is more: by how far a prediction may leave the data
ROOM = 1.0
# samples at the start of a segment, through which a cubic gives the first guess of its initial
# state
FITTED = 15
TOLERANCES = {"rtol": 1e-10, "atol": 1e-12}  # the loosest ones of methods that control their error


class Segment(NamedTuple):
    """A part of a run with an initial state of its own."""

    first: int  # sample
    end: int  # the sample after its last
    q: Array  # (nq,) initial state about which deviations are
    v: Array  # (nq,)
    basis: Array  # (nq, n) of the deviations of positions, and of velocities


class Unknowns(NamedTuple):
    """Values of all unknowns."""

    logarithms: Array  # (p,) natural, of parameters by their nominal values
    deviations: Array  # (segments, 2 n) of the initial states: coordinates in the basis, and their
    # rates


# joint positions (nq,) and velocities (nq,) by number of a sample
States: TypeAlias = dict[int, tuple[Array, Array]]


class Shooting:
    """Predictions of the measured positions.

    Attributes:
        nominal: values (p,) of the parameters in the scene.
        segments: of the run.
    """

    def __init__(
        self,
        scene: Scene,
        data: Measurements,
        parameters: Sequence[str],
        segment: float,
        known: States | None = None,
    ) -> None:
        """Prepare the segments.

        Args:
            scene: the crane; its law, inputs, sensors and faults do not matter.
            data: the run.
            parameters: dotted keys (p,) of numbers in the scene.
            segment: length [s].
            known: states from which deviations count, by the sample at which they are; others come
                from the data.

        Raises:
            SceneError: a parameter is not one, or the run is too short.
        """
        document = {key: value for key, value in scene.to_dict().items() if key not in OMITTED}
        self.data, self.parameters, self._document = data, tuple(parameters), document
        self.nominal = np.array([nominal_value(document, key) for key in parameters])
        self.scene = load_scene(document)
        self._columns = [self.scene.joint_names.index(name) for name in data.joints]
        if self.scene.hardware is not None and self.scene.hardware.servos is not None:
            segment = np.inf  # the state of a servo is known at the start only
        self.segments = [
            _segment(self.scene, data, *span, known or {}) for span in _spans(data, segment)
        ]
        self._low, self._high = _bounds(self.scene, data)

    @property
    def start(self) -> Unknowns:
        """The scene's parameters, and initial states from the data."""
        deviations = np.zeros((len(self.segments), 2 * self.segments[0].basis.shape[1]))
        return Unknowns(np.zeros(len(self.parameters)), deviations)

    def states(self, point: Unknowns) -> States:
        """Return the initial states of the segments at a point, by their first samples."""
        halves = np.split(point.deviations, 2, axis=1)
        return {
            each.first: (each.q + each.basis @ q, each.v + each.basis @ v)
            for each, q, v in zip(self.segments, *halves, strict=True)
        }

    def values(self, logarithms: Array) -> Array:
        """Return the parameters (p,) of these logarithms."""
        return np.exp(logarithms) * self.nominal

    def scene_of(self, logarithms: Array) -> Scene:
        """Return the scene with parameters (p,) given by their logarithms.

        Raises SceneError where it is invalid.
        """
        return load_scene(
            self._document,
            dict(zip(self.parameters, self.values(logarithms).tolist(), strict=True)),
        )

    def predict(self, point: Unknowns) -> Array:
        """Return the positions (K, m) of measured joints, NaN from where the integration failed.

        Raises:
            SceneError: the parameters are not possible.
        """
        scene = self.scene_of(point.logarithms)
        times, commands = excitation_of(scene, self.data)
        samples = np.searchsorted(times, self.data.t - SAME_INSTANT)
        out = np.full((len(times), len(scene.joint_names)), np.nan)
        integrate = _integrator(scene)
        for segment, state in zip(self.segments, self.states(point).values(), strict=True):
            span = int(samples[segment.first]), int(samples[segment.end - 1])
            integrate(Excitation(times, commands, *span, self._low, self._high), *state, out)
        return np.ascontiguousarray(out[samples][:, self._columns])

    @cached_property
    def _is_smooth(self) -> bool:
        """Whether predictions have derivatives.

        No parameter may move a breakpoint of a prescribed motion.
        """
        nominal = np.zeros(len(self.parameters))
        scenes = [
            self.scene,
            *(self.scene_of(_shift(nominal, i, STEP)) for i in range(len(nominal))),
        ]
        first, *others = (
            getattr(with_breakpoints((), scene.model), "breakpoints", np.empty(0))
            for scene in scenes
        )
        return is_smooth(self.scene) and all(np.array_equal(first, each) for each in others)

    def _derivatives(self, point: Unknowns) -> tuple[Array, Array]:
        """Return the result of `sensitivities` of a smooth prediction."""
        logarithms, n = point.logarithms, self.segments[0].basis.shape[1]
        scene = self.scene_of(logarithms)
        p, unknowns = len(logarithms), -(-(len(logarithms) + 2 * n) // DIRECTIONS) * DIRECTIONS
        times, commands = excitation_of(scene, self.data)
        samples = np.searchsorted(times, self.data.t - SAME_INSTANT)
        excitations, starts = list[Excitation](), list[Start]()
        for segment, state in zip(self.segments, self.states(point).values(), strict=True):
            span = int(samples[segment.first]), int(samples[segment.end - 1])
            excitations.append(Excitation(times, commands, *span, self._low, self._high))
            of_q, of_v = np.zeros((2, len(segment.q), unknowns))
            of_q[:, p : p + n] = of_v[:, p + n : p + 2 * n] = segment.basis
            starts.append(Start(*state, of_q, of_v))
        nearby = [
            _shift(logarithms, i, k * STEP) for i in range(p) for m in ORDER_6 for k in (m, -m)
        ]
        weights = np.array(
            [sign * weight / STEP for weight in ORDER_6.values() for sign in (1.0, -1.0)]
        )
        models = [self.scene_of(each).model for each in nearby]
        of_model = slopes_of_models(models, weights, unknowns)
        out = np.empty((len(times), len(scene.joint_names), unknowns))
        fill_derivatives(strict_method(scene), scene.model, of_model, excitations, starts, out)
        slopes = out[samples][:, self._columns]
        return slopes[..., :p], slopes[..., p : p + 2 * n]

    def sensitivities(
        self, point: Unknowns, weights: Mapping[int, float] = ORDER_6
    ) -> tuple[Array, Array]:
        """Return the derivatives of `predict` by logarithms and by deviations of segments.

        Their shapes are (K, m, p) and (K, m, 2 n): each instant has the deviations of its own
        segment.

        Args:
            point: where.
            weights: of the differences, `ORDER_6` or `ORDER_2`, where the prediction is not smooth.

        Raises:
            SceneError: parameters that near are not possible.
        """
        if self._is_smooth:
            return self._derivatives(point)
        logarithms, deviations = point
        by_parameter = [
            _central_difference(
                lambda h, i=i: self.predict(Unknowns(_shift(logarithms, i, h), deviations)), weights
            )
            for i in range(len(logarithms))
        ]
        by_state = [
            _central_difference(
                lambda h, j=j: self.predict(
                    Unknowns(logarithms, _shift(deviations, (slice(None), j), h))
                ),
                weights,
            )
            for j in range(deviations.shape[1])
        ]
        return np.stack(by_parameter, axis=2), np.stack(by_state, axis=2)


def _shift(values: Array, index: Any, h: float) -> Array:
    """Return the values with h added at an index."""
    shifted = values.copy()
    shifted[index] += h
    return shifted


def _central_difference(function: Callable[[float], Array], weights: Mapping[int, float]) -> Array:
    """Return the derivative of a function at 0 by differences over multiples of `STEP`."""
    pairs = ((weight, function(k * STEP) - function(-k * STEP)) for k, weight in weights.items())
    return sum((weight * difference for weight, difference in pairs), np.zeros(())) / STEP


def nominal_value(document: Mapping[str, Any], key: str) -> float:
    """Return the number at a dotted key of a scene.

    Raises:
        SceneError: there is none, or it is 0, which gives no scale.
    """
    found, value = get_value(document, key)
    if key.split(".")[0] in OMITTED:
        raise SceneError(
            f"parameter {key}: group {key.split('.')[0]} is not part of the crane that answers "
            "commands"
        )
    if not found:
        raise SceneError(
            f"parameter {key}: the scene has no {key} of its own; give a first guess, --set "
            f"{key}=VALUE"
        )
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SceneError(f"parameter {key}: is {value!r} in the scene, not a number")
    if value == 0.0 or not np.isfinite(value):
        raise SceneError(
            f"parameter {key}: is {value:g} in the scene, which gives no scale; --set {key}=VALUE"
        )
    return float(value)


def _spans(data: Measurements, length: float) -> list[tuple[int, int]]:
    """Return (first sample, the one after the last) of equal segments of at most `length` [s]."""
    if len(data.t) < 2 * FITTED:
        raise SceneError(
            f"run: has {len(data.t)} measured positions, {2 * FITTED} are the least to fit"
        )
    count = max(1, int(np.ceil((data.t[-1] - data.t[0]) / length * (1.0 - 1e-9))))
    bounds = np.searchsorted(data.t, np.linspace(data.t[0], data.t[-1], count + 1) - SAME_INSTANT)
    bounds[-1] = len(data.t)
    if min(np.diff(bounds)) < 2 * FITTED:
        raise SceneError(f"segment = {length:g} s: has fewer than {2 * FITTED} measured positions")
    return list(zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True))


def _bounds(scene: Scene, data: Measurements) -> tuple[Array, Array]:
    """Return the bounds (nq,) of joints beyond which a prediction has lost the run."""
    low, high = np.full((2, len(scene.joint_names)), np.inf) * [[-1.0], [1.0]]
    for name, values in zip(data.joints, data.q.T, strict=True):
        i, (least, greatest) = scene.joint_names.index(name), (np.nanmin(values), np.nanmax(values))
        margin = ROOM * max(1.0, greatest - least)
        low[i], high[i] = least - margin, greatest + margin
    return low, high


def _segment(scene: Scene, data: Measurements, first: int, end: int, known: States) -> Segment:
    """Return a segment that begins with a known state, or by a cubic through its first samples.

    A joint that is not measured then rests where the scene's begins.
    """
    if first in known:
        return Segment(first, end, *known[first], tangent_basis(scene, known[first][0]))
    q, v = np.array(scene.initial_q), np.zeros(len(scene.joint_names))
    for name, values in zip(data.joints, data.q[first:end].T, strict=True):
        i, there = scene.joint_names.index(name), np.flatnonzero(np.isfinite(values))[:FITTED]
        if len(there) < FITTED:
            raise SceneError(
                f"run: {name} has {len(there)} positions from {data.t[first]:g} s on; {FITTED} are "
                "needed"
            )
        q[i], v[i] = np.polynomial.polynomial.polyfit(
            data.t[first + there] - data.t[first], values[there], 3
        )[:2]
    return Segment(first, end, q, v, tangent_basis(scene, q))


def excitation_of(scene: Scene, data: Measurements) -> tuple[Array, Array]:
    """Return (instants (n,) [s] of samples and of delayed commands, commands (n, nu)).

    The delay is that of the drive.

    A delay is exact, not rounded to periods. Before its first command a drive has that command, or
    its initial demand where the data begin with the run and it has a delay, lag or rate limit.
    """
    groups = scene.file.actuators if scene.hardware is not None else {}
    initial = (
        initial_demands(scene, scene.hardware)
        if scene.hardware is not None and data.from_start
        else {}
    )
    delays = [merge_groups(groups, name, ActuatorGroup).delay for name in scene.actuated]
    changes = [data.command_times + delay for delay in delays]
    times = np.sort(np.concatenate([data.t, *changes]))
    times = times[(times >= data.t[0] - SAME_INSTANT) & (times <= data.t[-1] + SAME_INSTANT)]
    times = times[np.concatenate([[True], np.diff(times) > SAME_INSTANT])]
    commands = np.empty((len(times), len(delays)))
    for j, instants in enumerate(changes):
        latest = np.searchsorted(instants, times + SAME_INSTANT, side="right") - 1
        before = initial.get(scene.actuated[j], data.commands[0, j])
        commands[:, j] = np.where(latest < 0, before, data.commands[latest, j])
    return times, commands


def _integrator(scene: Scene) -> Callable[[Excitation, Array, Array, Array], object]:
    """Return the function of (part, q, v, out) that fills `out` (n, nq) until it fails."""
    method, model = strict_method(scene), scene.model
    if not is_nonideal(scene.hardware):
        return lambda part, q, v, out: integrate_held(method, model, part, q, v, out)
    hardware = HardwareRun(scene).state
    # of one segment: with servos there is no second
    drives, servos = hardware.drives, hardware.servos
    drives.delay = 0  # it is in the instants
    return lambda part, q, v, out: integrate_with_drives(
        method, model, drives.copy(), servos, part, q, v, out
    )


def strict_method(scene: Scene) -> Any:
    """Return the scene's method, with `TOLERANCES` in place of looser ones of its own."""
    tolerances = {
        key: min(getattr(scene.method, key, value), value) for key, value in TOLERANCES.items()
    }
    return scene.method._replace(**tolerances) if hasattr(scene.method, "rtol") else scene.method
