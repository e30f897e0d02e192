"""MuJoCo: its own Runge-Kutta method and its first-order ones, stepped by its C loop.

Contacts, constraints and checks that the cranes do not need are switched off. Inputs are
activations that its own method integrates. A fall is a spatial tendon whose spring pulls only
beyond its length; its damper acts on a slack one, too, which no parameter of a tendon changes:
scenes whose falls go slack need another model.
"""

import time
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.speed.engine import EngineUnavailable, Run, RunResult, sweep_values
from crane_bench.speed.peers.joints import model_joints, step_sizes, tension
from crane_bench.speed.peers.mechanism import (
    Body,
    Drive,
    Fall,
    Mechanism,
    initial_state,
    load_pose,
    mechanism_of_problem,
    segments,
)
from crane_bench.speed.problem import Problem

Array = npt.NDArray[np.float64]
NAME = "MuJoCo"
_POINT = 2e-15
"""kg m², the inertia of a point mass: MuJoCo demands more than 1e-15. It is 5e-10 m l² for m = 1e-4
kg, l = 0.2 m."""
_OFF = (
    "contact",
    "constraint",
    "warmstart",
    "eulerdamp",
    "autoreset",
    "sensor",
    "nativeccd",
    "island",
)
METHODS = {"RK4": 4, "implicitfast": 1, "Euler": 1, "discrete": 1}
"""Its integrators, and how often each evaluates the equations in a step."""
STEPS = sweep_values(0.2, 2e-4, 4)  # s, of rigid loads


class _Sweep(NamedTuple):
    """Step sizes of an integrator, relative to 1 / highest frequency."""

    method: str
    first: float
    last: float
    per_decade: int


_SWEEPS = (
    _Sweep("RK4", 2.7, 0.005, 6),
    _Sweep("Euler", 1.0, 3e-3, 3),
    _Sweep("implicitfast", 1.0, 3e-3, 3),
    _Sweep("discrete", 10.0, 3e-3, 3),
)


class MuJoCo:
    """The engine: models every Problem class; `unsupported_scenes` are left out."""

    name = NAME
    unsupported_scenes: ClassVar[dict[str, str]] = {
        "overhead_spatial": "its loop holds forces through each step, so that a sine force is of "
        "first order, "
        "unless Python is called in every stage",
        "overhead_hoist": "a prescribed length needs an equality constraint, whose forces are "
        "soft: the length lags",
        "overhead_coulomb": "friction is smoothed: a sticking trolley creeps, and no step ends "
        "where it breaks loose",
    }

    def __init__(self) -> None:
        """Find the package.

        Raises:
            EngineUnavailable: it is not installed.
        """
        self.version: str = find_version()

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps of steps with all methods."""
        joints, mechanism, found = model_joints(problem), mechanism_of_problem(problem), list[Run]()
        for method, first, last, per_decade in _SWEEPS:
            model = compile_model(mechanism, method)
            for step in step_sizes(problem, first, last, per_decade):
                execute = make_run(mechanism, model, method, step, lambda q: tension(joints, q))
                found.append(Run(NAME, method, step, execute))
        return found


def find_version() -> str:
    """Return the version.

    Raises:
        EngineUnavailable: it is not installed.
    """
    return str(find_package().__version__)


def runs(mechanism: Mechanism, method: str) -> list[Run]:
    """Return the sweep of steps of a rigid load, coarsest first."""
    model = compile_model(mechanism, method)
    return [Run(NAME, method, step, make_run(mechanism, model, method, step)) for step in STEPS]


def make_run(
    mechanism: Mechanism,
    model: Any,
    method: str,
    step: float,
    tension_at: Callable[[Array], float | None] = lambda q: None,
) -> Callable[[int], RunResult]:
    """Return an integration with at most this step [s], which divides each of the segments."""
    mujoco, (first, pieces), (q, v) = find_package(), segments(mechanism), initial_state(mechanism)
    data, counts = (
        mujoco.MjData(model),
        [int(np.ceil(piece.duration / step - 1e-9)) for piece in pieces],
    )

    def execute(repetitions: int) -> RunResult:
        for _ in range(repetitions):
            data.qpos[:], data.qvel[:], data.act[:], data.time = q, v, first, 0.0
            for piece, count in zip(pieces, counts, strict=True):
                model.opt.timestep, data.ctrl[:] = piece.duration / count, piece.rates
                mujoco.mj_step(model, data, count)
        at, turn = load_pose(mechanism, data.qpos)
        return RunResult(
            at, METHODS[method] * sum(counts), sum(counts), tension_at(data.qpos), turn
        )

    return execute


def batch(problem: Problem, starts: Array | int, step: float, threads: int) -> tuple[Array, float]:
    """Integrate many cranes by RK4 in `mujoco.rollout`, its own pool of threads.

    Args:
        problem: common to all.
        starts: (n, nq) initial coordinates of `model_joints(problem)`, or the number of copies of
            the problem's own.
        step: s.
        threads: size of the pool.

    Returns:
        (final payload positions (n, 3) [m], world; wall time [s]).

    Raises:
        EngineUnavailable: the package is not installed.
    """
    mujoco, rollout = find_package(), import_module("mujoco.rollout")
    mechanism, count = mechanism_of_problem(problem), round(problem.duration / step)
    initial, n = initial_state(mechanism)[0], len(mechanism.bodies)
    q = np.tile(initial, (starts, 1)) if isinstance(starts, int) else starts
    model = compile_model(mechanism, "RK4")
    model.opt.timestep = problem.duration / count
    state = np.zeros((len(q), mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    state[:, 1 : 1 + n] = q  # the time stands first, the velocities behind
    data = [mujoco.MjData(model) for _ in range(threads)]
    start = time.perf_counter()
    with rollout.Rollout(nthread=threads) as pool:
        ends = _roll_out(pool, model, data, state, count)
    seconds = time.perf_counter() - start
    return np.array([load_pose(mechanism, end[1 : 1 + n])[0] for end in ends]), seconds


def _roll_out(
    pool: Any, model: Any, data: list[Any], state: Array, count: int, piece: int = 50
) -> Array:
    """Return the states after `count` steps.

    A rollout keeps all intermediate states, so it is done in pieces.
    """
    while count:
        states, _ = pool.rollout(model, data, state, nstep=min(piece, count))
        state, count = states[:, -1], count - states.shape[1]
    return state


def compile_model(mechanism: Mechanism, method: str) -> Any:
    """Return the compiled model of a mechanism, all that it does not need switched off."""
    flags = " ".join(f'{name}="disable"' for name in _OFF)
    option = (
        f'<option integrator="{method}" gravity="0 0 {-mechanism.gravity!r}"><flag '
        f"{flags}/></option>"
    )
    tendons, motors = (
        map(_tendon, range(len(mechanism.falls)), mechanism.falls),
        map(_motor, mechanism.drives),
    )
    text = (
        f'<mujoco><compiler angle="radian"/>{option}<worldbody>{_tree(mechanism)}</worldbody>'
        f"<tendon>{''.join(tendons)}</tendon><actuator>{''.join(motors)}</actuator></mujoco>"
    )
    return find_package().MjModel.from_xml_string(text)


def _tree(mechanism: Mechanism) -> str:
    """Return the bodies; massless joints move the next body, in the frame of the last one."""
    text, moving, open_bodies = "", list[int](), 0
    for i, body in enumerate(mechanism.bodies):
        if body.parent == -1:
            text, open_bodies = text + "</body>" * open_bodies, 0
        moving.append(i)
        if body.joint.mass:
            text, open_bodies, moving = text + _body(mechanism, moving), open_bodies + 1, []
    return text + "</body>" * open_bodies


def _body(mechanism: Mechanism, moving: list[int]) -> str:
    """Return the opening of a body that these joints move, with the ends of its falls."""
    joints = [mechanism.bodies[i].joint for i in moving]
    # while all angles and lengths are zero
    places = np.cumsum([joint.offset for joint in joints], axis=0)
    last, inertia = joints[-1], _numbers(max(value, _POINT) for value in joints[-1].inertia)
    text = f'<body pos="{_numbers(places[-1])}">'
    text += "".join(
        _joint(i, mechanism.bodies[i], place - places[-1])
        for i, place in zip(moving, places, strict=True)
    )
    text += (
        f'<inertial pos="{_numbers(last.com)}" mass="{float(last.mass)!r}" '
        f'diaginertia="{inertia}"/>'
    )
    for k, fall in enumerate(mechanism.falls):
        for which, (number, point) in (("upper", fall.upper), ("lower", fall.lower)):
            if number == moving[-1]:
                text += f'<site name="{which} {k}" pos="{_numbers(point)}"/>'
    return text


def _joint(i: int, body: Body, place: Any) -> str:
    joint, axis = body.joint, _numbers(float(k == body.joint.axis) for k in range(3))
    terms = f'armature="{float(body.armature)!r}" damping="{float(body.damping)!r}"'
    if joint.spring is not None:
        terms += (
            f' stiffness="{float(joint.spring.stiffness)!r}" '
            f'springref="{float(joint.spring.neutral)!r}"'
        )
    kind = "slide" if joint.prismatic else "hinge"
    return f'<joint name="{i}" type="{kind}" axis="{axis}" pos="{_numbers(place)}" {terms}/>'


def _tendon(k: int, fall: Fall) -> str:
    spring = (
        f'springlength="0 {fall.length!r}" stiffness="{fall.stiffness!r}" '
        f'damping="{fall.damping!r}"'
    )
    return f'<spatial {spring}><site site="upper {k}"/><site site="lower {k}"/></spatial>'


def _motor(drive: Drive) -> str:
    return f'<general joint="{drive.body}" dyntype="integrator" gainprm="{float(drive.gain)!r}"/>'


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def find_package() -> Any:
    """Return the package, its log switched off.

    A run that diverges stays in the table, not in a file.

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
