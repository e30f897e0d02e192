"""MuJoCo: its own Runge-Kutta method and its first-order ones, stepped by its C loop.

Contacts, constraints, dampers, actuators, sensors and checks that the cranes do not need are switched off.
"""

import time
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.speed.engine import EngineUnavailable, Run, RunResult
from crane_bench.speed.peers.joints import Joint, model_joints, payload_position, step_sizes, tension
from crane_bench.speed.problem import Problem

Array = npt.NDArray[np.float64]
_POINT = 2e-15
"""kg m², the inertia of a point mass: MuJoCo demands more than 1e-15. It is 5e-10 m l² for m = 1e-4 kg, l = 0.2 m."""
_OFF = """CONSTRAINT EQUALITY FRICTIONLOSS LIMIT CONTACT DAMPER CLAMPCTRL WARMSTART FILTERPARENT ACTUATION REFSAFE
SENSOR MIDPHASE EULERDAMP AUTORESET NATIVECCD ISLAND""".split()


class _Method(NamedTuple):
    """One of MuJoCo's integrators and its sweep of step sizes, relative to 1 / highest frequency."""

    name: str
    evaluations: int  # of the equations, per step
    first: float
    last: float
    per_decade: int


_METHODS = (
    _Method("RK4", 4, 2.7, 0.005, 6),
    _Method("Euler", 1, 1.0, 3e-3, 3),
    _Method("implicitfast", 1, 1.0, 3e-3, 3),
    _Method("discrete", 1, 10.0, 3e-3, 3),
)


class MuJoCo:
    """The engine: models every Problem class; of the benchmark's scenes, `unsupported_scenes` are left out."""

    name = "MuJoCo"
    unsupported_scenes: ClassVar[dict[str, str]] = {
        "overhead_spatial": "its loop holds forces through each step, so that a sine force is of first order, "
        "unless Python is called in every stage",
        "overhead_hoist": "a prescribed length needs an equality constraint, whose forces are soft: the length lags",
        "overhead_coulomb": "friction is smoothed: a sticking trolley creeps, and no step ends where it breaks loose",
    }

    def __init__(self) -> None:
        """Find the package.

        Raises:
            EngineUnavailable: it is not installed.
        """
        self._mujoco = find_package()
        self.version: str = self._mujoco.__version__

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps of steps with all methods."""
        return [run for method in _METHODS for run in self._sweep(problem, method)]

    def _sweep(self, problem: Problem, method: _Method) -> list[Run]:
        joints = model_joints(problem)
        model = compile_model(self._mujoco, joints, problem.gravity, method.name)
        sizes = step_sizes(problem, method.first, method.last, method.per_decade)
        return [
            Run(self.name, method.name, step, self._make_run(problem, joints, model, method, step)) for step in sizes
        ]

    def _make_run(
        self, problem: Problem, joints: list[Joint], model: Any, method: _Method, step: float
    ) -> Callable[[int], RunResult]:
        data, advance = self._mujoco.MjData(model), self._mujoco.mj_step
        start, count = np.array([joint.initial for joint in joints]), round(problem.duration / step)

        def execute(repetitions: int) -> RunResult:
            model.opt.timestep = step
            for _ in range(repetitions):
                data.qpos[:], data.qvel[:], data.time = start, 0.0, 0.0
                advance(model, data, count)
            return RunResult(
                payload_position(joints, data.qpos), method.evaluations * count, count, tension(joints, data.qpos)
            )

        return execute


def batch(problem: Problem, starts: Array | int, step: float, threads: int) -> tuple[Array, float]:
    """Integrate many cranes by RK4 in `mujoco.rollout`, its own pool of threads.

    Args:
        problem: common to all.
        starts: (n, nq) initial coordinates of `model_joints(problem)`, or the number of copies of the problem's own.
        step: s.
        threads: size of the pool.

    Returns:
        (final payload positions (n, 3) [m], world; wall time [s]).

    Raises:
        EngineUnavailable: the package is not installed.
    """
    mujoco, rollout = find_package(), import_module("mujoco.rollout")
    joints, count = model_joints(problem), round(problem.duration / step)
    initial, n = np.array([joint.initial for joint in joints]), len(joints)
    q = np.tile(initial, (starts, 1)) if isinstance(starts, int) else starts
    model = compile_model(mujoco, joints, problem.gravity, "RK4")
    model.opt.timestep = problem.duration / count
    state = np.zeros((len(q), mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    state[:, 1 : 1 + n] = q  # the time stands first, the velocities behind
    data = [mujoco.MjData(model) for _ in range(threads)]
    start = time.perf_counter()
    with rollout.Rollout(nthread=threads) as pool:
        ends = _roll_out(pool, model, data, state, count)
    seconds = time.perf_counter() - start
    return np.array([payload_position(joints, end[1 : 1 + n]) for end in ends]), seconds


def _roll_out(pool: Any, model: Any, data: list[Any], state: Array, count: int, piece: int = 50) -> Array:
    """Return the states after `count` steps; a rollout keeps all intermediate states, so it is done in pieces."""
    while count:
        states, _ = pool.rollout(model, data, state, nstep=min(piece, count))
        state, count = states[:, -1], count - states.shape[1]
    return state


def compile_model(mujoco: Any, joints: list[Joint], gravity: float, method: str) -> Any:
    """Return the compiled model of a chain of joints, all that it does not need switched off."""
    bodies: list[str] = []
    moving: list[Joint] = []
    for joint in joints:
        moving.append(joint)
        if joint.mass:  # else the next joint moves the same body: MuJoCo has no massless ones
            bodies.append(_body(moving))
            moving = []
    option = f'<option integrator="{method}" gravity="0 0 {-gravity!r}"/>'
    text = f'<mujoco><compiler angle="radian"/>{option}<worldbody>{"".join(bodies)}'
    model = mujoco.MjModel.from_xml_string(text + "</body>" * len(bodies) + "</worldbody></mujoco>")
    for name in _OFF:
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}", 0))
    return model


def _body(moving: list[Joint]) -> str:
    """Return the opening of a body that several joints move, only the first of them with an offset."""
    last = moving[-1]
    inertia = _format_numbers(max(value, _POINT) for value in last.inertia)
    inertial = f'<inertial pos="{_format_numbers(last.com)}" mass="{last.mass!r}" diaginertia="{inertia}"/>'
    return f'<body pos="{_format_numbers(moving[0].offset)}">' + "".join(map(_joint, moving)) + inertial


def _joint(joint: Joint) -> str:
    kind, axis = "slide" if joint.prismatic else "hinge", _format_numbers(float(i == joint.axis) for i in range(3))
    spring = f' stiffness="{joint.spring.stiffness!r}" springref="{joint.spring.neutral!r}"' if joint.spring else ""
    return f'<joint type="{kind}" axis="{axis}"{spring}/>'


def _format_numbers(values: Iterable[float]) -> str:
    return " ".join(map(repr, values))


def find_package() -> Any:
    """Return the package, its log switched off: a run that diverges stays in the table, not in a file.

    Raises:
        EngineUnavailable: it is not installed.
    """
    try:
        mujoco = import_module("mujoco")
    except ImportError as error:
        raise EngineUnavailable(f"MuJoCo is not installed: {error}") from None
    quiet = mujoco.MjLogConfig.get()
    quiet.logto_file = quiet.logto_console = False
    mujoco.MjLogConfig.set(quiet)
    return mujoco
