"""Drake: a continuous MultibodyPlant in its own Simulator, with the integrators that come with it.

Left out: `cenic`, made for contacts, which is of first order, stays above a centimetre and takes no sliding joint
behind a massless body; and Radau methods with fixed steps, slower than those with error control.
"""

from collections.abc import Callable
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any, NamedTuple

import numpy as np

from crane_sim.evaluation.bench.engine import Missing, Outcome, Run, sweep_values
from crane_sim.evaluation.bench.peers.joints import Joint, centre, fastest, model_joints, steps, tension
from crane_sim.evaluation.bench.problem import Problem


class _Method(NamedTuple):
    """One of Drake's integrators, with fixed steps or with error control."""

    scheme: str
    fixed: bool
    first: float  # step relative to the fastest motion, or accuracy
    last: float
    per_decade: int


_METHODS = (
    _Method("runge_kutta3", True, 1.7, 0.01, 6),
    _Method("runge_kutta5", True, 3.0, 0.03, 6),
    _Method("runge_kutta3", False, 1e-1, 1e-12, 2),
    _Method("runge_kutta5", False, 1e-3, 1e-13, 2),
    _Method("radau3", False, 1e-2, 1e-9, 2),
    _Method("implicit_euler", False, 1e-1, 1e-6, 2),
)
MAX_STEP = 0.1  # s, of an error-controlled step: Drake's default


class Drake:
    """The engine; it models every problem of the benchmark."""

    name = "Drake"
    cannot = {
        "overhead_spatial": "a link in space takes two angles, singular where it lies along the first axis: a ball "
        "joint would spin without inertia, which stops the algorithm",
        "overhead_hoist": "no joint follows a prescribed length: a locked one of a discrete plant is at rest",
        "overhead_coulomb": "joints have no Coulomb friction, and that of contacts is smoothed",
    }

    def __init__(self) -> None:
        """Import its parts.

        Raises:
            Missing: it is not installed.
        """
        try:
            self._analysis = import_module("pydrake.systems.analysis")
            self.version = version("drake")
        except (ImportError, PackageNotFoundError) as error:
            raise Missing(f"Drake is not installed: {error}") from None

    def refuses(self, problem: Problem) -> str | None:
        """Refuse nothing."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps of steps, and those of accuracies where a method controls its error."""
        row = model_joints(problem)
        plant = _plant(row, problem.gravity)
        return [run for method in _METHODS for run in self._sweep(problem, row, plant, method)]

    def _sweep(self, problem: Problem, row: list[Joint], plant: Any, method: _Method) -> list[Run]:
        bounds = method.first, method.last, method.per_decade
        settings = steps(problem, *bounds) if method.fixed else sweep_values(*bounds)
        name = f"{method.scheme}, {'fixed step' if method.fixed else 'error control'}"
        begin = 0.1 / fastest(problem)
        return [
            Run(self.name, name, setting, self._goer(row, plant, problem.duration, method, setting, begin))
            for setting in settings
        ]

    def _goer(
        self, row: list[Joint], plant: Any, duration: float, method: _Method, setting: float, begin: float
    ) -> Callable[[int], Outcome]:
        analysis, start = self._analysis, np.array([joint.start for joint in row] + [0.0] * len(row))
        simulator = analysis.Simulator(plant)
        context, config = simulator.get_mutable_context(), analysis.SimulatorConfig()
        config.integration_scheme, config.use_error_control = method.scheme, not method.fixed
        config.max_step_size = setting if method.fixed else MAX_STEP
        if not method.fixed:
            config.accuracy = setting

        def go(times: int) -> Outcome:
            for _ in range(times):
                analysis.ApplySimulatorConfig(config, simulator)  # a new integrator: the old one knows the end's steps
                if not method.fixed:  # a first step that is far too long hangs Runge-Kutta of order 5
                    simulator.get_mutable_integrator().request_initial_step_size_target(begin)
                context.SetTime(0.0)
                context.SetContinuousState(start)
                try:
                    simulator.Initialize()
                    simulator.AdvanceTo(duration)
                except RuntimeError:  # the step has become too small, or the state is no number any more
                    return Outcome(np.full(3, np.nan), None, None)
            integrator, q = simulator.get_integrator(), plant.GetPositions(context)
            counts = integrator.get_num_derivative_evaluations(), integrator.get_num_steps_taken()
            return Outcome(centre(row, q), *counts, tension(row, q))

        return go


def _plant(row: list[Joint], gravity: float) -> Any:
    """Return the plant of a row of joints, its springs as force elements."""
    tree, place = import_module("pydrake.multibody.tree"), import_module("pydrake.math").RigidTransform
    plant = import_module("pydrake.multibody.plant").MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -gravity])
    turning, sliding = (tree.RevoluteJoint, tree.RevoluteSpring), (tree.PrismaticJoint, tree.PrismaticSpring)
    before = plant.world_body()
    for i, joint in enumerate(row):
        body = plant.AddRigidBody(f"body {i}", _inertia(tree, joint))
        at = plant.AddFrame(tree.FixedOffsetFrame(f"at {i}", before.body_frame(), place(np.array(joint.offset))))
        kind, spring = sliding if joint.slides else turning
        made = plant.AddJoint(kind(f"joint {i}", at, body.body_frame(), np.eye(3)[joint.axis]))
        if joint.spring:
            plant.AddForceElement(spring(made, joint.spring.rest, joint.spring.stiffness))
        before = body
    plant.Finalize()
    return plant


def _inertia(tree: Any, joint: Joint) -> Any:
    if joint.mass == 0.0:
        return tree.SpatialInertia.Zero()
    turning = tree.RotationalInertia(*joint.inertia)
    return tree.SpatialInertia.MakeFromCentralInertia(joint.mass, joint.centre, turning)
