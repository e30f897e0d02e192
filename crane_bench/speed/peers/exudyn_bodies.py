"""Exudyn with a rigid load: a kinematic tree, spring-dampers as falls, and inputs as coordinates of their own.

The joints' coordinates are minimal, so that explicit methods apply without constraints. An input that rises at a
constant rate is a coordinate without acceleration, which linear terms couple to its joint: no method then calls Python.
A spring-damper pushes where a fall would go slack: scenes whose falls go slack need another model.
"""

import sys
import warnings
from collections.abc import Callable
from contextlib import redirect_stdout
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any, NamedTuple

import numpy as np

from crane_bench.speed.engine import EngineUnavailable, Run, RunResult, sweep_values
from crane_bench.speed.peers.mechanism import Mechanism, initial_state, load_pose, segments

NAME = "Exudyn"


class Method(NamedTuple):
    """One of Exudyn's integrators."""

    solver: str  # its name in `DynamicSolverType`
    stages: int | None  # evaluations of the equations in a step; None: not counted


METHODS = {
    "RK44": Method("RK44", 4),
    "RK67": Method("RK67", 7),
    "DOPRI5": Method("DOPRI5", None),
    "generalized alpha": Method("GeneralizedAlpha", None),
}
STEPS = sweep_values(0.2, 2e-4, 4)  # s
TOLERANCES = sweep_values(1e-3, 1e-12, 2)  # relative and absolute
FIRST_STEP = 1e-3  # s, of DOPRI5: one that is far too long ends in no number


def find_version() -> str:
    """Return the version.

    Raises:
        EngineUnavailable: it is not installed.
    """
    try:
        _package()
        return version("exudyn")
    except (ImportError, PackageNotFoundError) as error:
        raise EngineUnavailable(f"Exudyn is not installed: {error}") from None


def runs(mechanism: Mechanism, method: str) -> list[Run]:
    """Return the sweep of steps, or of DOPRI5's tolerances, coarsest first."""
    system = build_system(mechanism)
    settings = TOLERANCES if method == "DOPRI5" else STEPS
    return [Run(NAME, method, value, make_run(mechanism, system, method, value)) for value in settings]


def make_run(mechanism: Mechanism, system: Any, method: str, setting: float) -> Callable[[int], RunResult]:
    """Return an integration with at most this step [s], which divides each of the segments, or at a tolerance."""
    exudyn, (first, pieces), (q, v) = _package(), segments(mechanism), initial_state(mechanism)
    n, adaptive = len(q), method == "DOPRI5"
    settings = _settings(exudyn, setting if adaptive else None)
    solver, initial = getattr(exudyn.DynamicSolverType, METHODS[method].solver), exudyn.ConfigurationType.Initial
    counts = [1 if adaptive else int(np.ceil(piece.duration / setting - 1e-9)) for piece in pieces]
    stages, data = METHODS[method].stages, system.systemData

    def execute(repetitions: int) -> RunResult:
        x = xd = np.empty(0)
        for _ in range(repetitions):
            x, xd = np.concatenate([q, first]), np.concatenate([v, 0.0 * first])
            for piece, count in zip(pieces, counts, strict=True):
                xd[n:] = piece.rates
                data.SetODE2Coordinates(x, initial)
                data.SetODE2Coordinates_t(xd, initial)
                settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = count, piece.duration
                if not system.SolveDynamic(settings, solverType=solver, storeSolver=False, showHints=False):
                    return RunResult(np.full(3, np.nan), None, None)
                x, xd = np.array(data.GetODE2Coordinates()), np.array(data.GetODE2Coordinates_t())
        at, turn = load_pose(mechanism, x[:n])
        steps = None if adaptive else sum(counts)
        return RunResult(at, None if stages is None or steps is None else stages * steps, steps, attitude=turn)

    return execute


def build_system(mechanism: Mechanism) -> Any:
    """Return the assembled system; its coordinates are those of the joints, then the inputs."""
    exudyn, items = _package(), import_module("exudyn.itemInterface")
    container = exudyn.SystemContainer()
    system, (q, _) = container.AddSystem(), initial_state(mechanism)
    system.variables["container"] = container  # which owns the system
    joints, count = _add_node(system, items, len(q)), len(mechanism.drives)
    tree = system.AddObject(items.ObjectKinematicTree(nodeNumber=joints, **_tree(exudyn, mechanism)))
    inputs = [_add_node(system, items, count)] if count else []
    mass, damping, stiffness = _linear_terms(mechanism)
    terms = {"massMatrix": mass, "dampingMatrix": damping, "stiffnessMatrix": stiffness}
    system.AddObject(items.ObjectGenericODE2(nodeNumbers=[joints, *inputs], **terms))
    for fall in mechanism.falls:
        ends = [
            system.AddMarker(items.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=link, localPosition=point))
            for link, point in (fall.upper, fall.lower)
        ]
        values = {"referenceLength": fall.length, "stiffness": fall.stiffness, "damping": fall.damping}
        system.AddObject(items.ObjectConnectorSpringDamper(markerNumbers=ends, **values))
    system.Assemble()
    return system


def _add_node(system: Any, items: Any, count: int) -> Any:
    zero = [0.0] * count
    rows = {"referenceCoordinates": zero, "initialCoordinates": zero, "initialCoordinates_t": zero}
    return system.AddNode(items.NodeGenericODE2(numberOfODE2Coordinates=count, **rows))


def _tree(exudyn: Any, mechanism: Mechanism) -> dict[str, Any]:
    """Return the settings of the kinematic tree."""
    joints = [body.joint for body in mechanism.bodies]
    kinds = [f"{'Prismatic' if joint.prismatic else 'Revolute'}{'XYZ'[joint.axis]}" for joint in joints]
    return {
        "jointTypes": [getattr(exudyn.JointType, kind) for kind in kinds],
        "linkParents": [body.parent for body in mechanism.bodies],
        "jointTransformations": exudyn.Matrix3DList([np.eye(3)] * len(joints)),
        "jointOffsets": exudyn.Vector3DList([list(joint.offset) for joint in joints]),
        "linkInertiasCOM": exudyn.Matrix3DList([np.diag(joint.inertia) for joint in joints]),
        "linkCOMs": exudyn.Vector3DList([list(joint.com) for joint in joints]),
        "linkMasses": [joint.mass for joint in joints],
        "gravity": [0.0, 0.0, -mechanism.gravity],
    }


def _linear_terms(mechanism: Mechanism) -> tuple[Any, Any, Any]:
    """Return matrices of mass, damping and stiffness (n + m, n + m) of n joints and m inputs, beside the tree's."""
    n, drives = len(mechanism.bodies), mechanism.drives
    mass = np.diag([*(body.armature for body in mechanism.bodies), *(1.0 for _ in drives)])
    damping = np.diag([*(body.damping for body in mechanism.bodies), *(0.0 for _ in drives)])
    stiffness = np.zeros_like(mass)
    for k, drive in enumerate(drives):
        stiffness[drive.body, n + k] = -drive.gain
    return mass, damping, stiffness


def _settings(exudyn: Any, tolerance: float | None) -> Any:
    """Return settings without files and messages; tolerance: of control of the error, None for fixed steps."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = settings.solution.sensors.active = False
    settings.timeIntegration.verboseMode, settings.timeIntegration.explicit.computeEndOfStepAccelerations = 0, False
    settings.timeIntegration.initialStepSize = FIRST_STEP
    settings.timeIntegration.automaticStepSize = tolerance is not None
    if tolerance is not None:
        settings.timeIntegration.relativeTolerance = settings.timeIntegration.absoluteTolerance = tolerance
    newton = settings.timeIntegration.newton
    newton.relativeTolerance = newton.absoluteTolerance = 1e-14  # the heavy winch is most of its residual
    return settings


def _package() -> Any:
    sys.__dict__.setdefault("exudynFast", True)  # its own switch for the build without checks of ranges
    with warnings.catch_warnings(), redirect_stdout(None):
        warnings.simplefilter("ignore")
        exudyn = import_module("exudyn")
    exudyn.config.printToConsole, exudyn.config.suppressWarnings = False, True  # a failed run stays in the table
    return exudyn
