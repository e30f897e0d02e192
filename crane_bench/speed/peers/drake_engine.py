"""Drake: a continuous MultibodyPlant in its own Simulator, with the integrators that come with it.

Left out: `cenic`, made for contacts, which is of first order, stays above a centimetre and takes no prismatic joint
below a massless body; and Radau methods with fixed steps, slower than those with error control.
"""

from collections.abc import Callable
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any, ClassVar, NamedTuple

import numpy as np

from crane_bench.speed.engine import EngineUnavailable, Run, RunResult, sweep_values
from crane_bench.speed.peers.joints import (
    Joint,
    highest_frequency,
    model_joints,
    payload_position,
    step_sizes,
    tension,
)
from crane_bench.speed.problem import Problem


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
    """The engine: models every Problem class; of the benchmark's scenes, `unsupported_scenes` are left out."""

    name = "Drake"
    unsupported_scenes: ClassVar[dict[str, str]] = {
        "overhead_spatial": "a link in space takes two angles, singular where it lies along the first axis: a ball "
        "joint would spin without inertia, which stops the algorithm",
        "overhead_hoist": "no joint follows a prescribed length: a locked one of a discrete plant is at rest",
        "overhead_coulomb": "joints have no Coulomb friction, and that of contacts is smoothed",
    }

    def __init__(self) -> None:
        """Import its parts.

        Raises:
            EngineUnavailable: it is not installed.
        """
        try:
            self._analysis = import_module("pydrake.systems.analysis")
            self.version = version("drake")
        except (ImportError, PackageNotFoundError) as error:
            raise EngineUnavailable(f"Drake is not installed: {error}") from None

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps of steps, and those of accuracies where a method controls its error."""
        joints = model_joints(problem)
        plant = _plant(joints, problem.gravity)
        return [run for method in _METHODS for run in self._sweep(problem, joints, plant, method)]

    def _sweep(self, problem: Problem, joints: list[Joint], plant: Any, method: _Method) -> list[Run]:
        bounds = method.first, method.last, method.per_decade
        settings = step_sizes(problem, *bounds) if method.fixed else sweep_values(*bounds)
        name = f"{method.scheme}, {'fixed step' if method.fixed else 'error control'}"
        first_step = 0.1 / highest_frequency(problem)
        return [
            Run(self.name, name, setting, self._make_run(joints, plant, problem.duration, method, setting, first_step))
            for setting in settings
        ]

    def _make_run(
        self, joints: list[Joint], plant: Any, duration: float, method: _Method, setting: float, first_step: float
    ) -> Callable[[int], RunResult]:
        analysis, start = self._analysis, np.array([joint.initial for joint in joints] + [0.0] * len(joints))
        simulator = analysis.Simulator(plant)
        context, config = simulator.get_mutable_context(), analysis.SimulatorConfig()
        config.integration_scheme, config.use_error_control = method.scheme, not method.fixed
        config.max_step_size = setting if method.fixed else MAX_STEP
        if not method.fixed:
            config.accuracy = setting

        def execute(repetitions: int) -> RunResult:
            for _ in range(repetitions):
                analysis.ApplySimulatorConfig(config, simulator)  # a new integrator, without the last step size
                if not method.fixed:  # a first step that is far too long hangs Runge-Kutta of order 5
                    simulator.get_mutable_integrator().request_initial_step_size_target(first_step)
                context.SetTime(0.0)
                context.SetContinuousState(start)
                try:
                    simulator.Initialize()
                    simulator.AdvanceTo(duration)
                except RuntimeError:  # the step has become too small, or the state is no number any more
                    return RunResult(np.full(3, np.nan), None, None)
            integrator, q = simulator.get_integrator(), plant.GetPositions(context)
            counts = integrator.get_num_derivative_evaluations(), integrator.get_num_steps_taken()
            return RunResult(payload_position(joints, q), *counts, tension(joints, q))

        return execute


def _plant(joints: list[Joint], gravity: float) -> Any:
    """Return the plant of a chain of joints, its springs as force elements."""
    tree, transform = import_module("pydrake.multibody.tree"), import_module("pydrake.math").RigidTransform
    plant = import_module("pydrake.multibody.plant").MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -gravity])
    revolute, prismatic = (tree.RevoluteJoint, tree.RevoluteSpring), (tree.PrismaticJoint, tree.PrismaticSpring)
    parent = plant.world_body()
    for i, joint in enumerate(joints):
        body = plant.AddRigidBody(f"body {i}", _inertia(tree, joint))
        frame = plant.AddFrame(
            tree.FixedOffsetFrame(f"frame {i}", parent.body_frame(), transform(np.array(joint.offset)))
        )
        kind, spring = prismatic if joint.prismatic else revolute
        added = plant.AddJoint(kind(f"joint {i}", frame, body.body_frame(), np.eye(3)[joint.axis]))
        if joint.spring:
            plant.AddForceElement(spring(added, joint.spring.neutral, joint.spring.stiffness))
        parent = body
    plant.Finalize()
    return plant


def _inertia(tree: Any, joint: Joint) -> Any:
    if joint.mass == 0.0:
        return tree.SpatialInertia.Zero()
    inertia = tree.RotationalInertia(*joint.inertia)
    return tree.SpatialInertia.MakeFromCentralInertia(joint.mass, joint.com, inertia)
