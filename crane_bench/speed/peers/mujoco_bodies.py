"""MuJoCo with a rigid load: joints, spatial tendons as falls, and inputs as activations that its own method integrates.

A fall is a tendon whose spring pulls only beyond its length. Its damper acts on a slack one, too, which no parameter of
a tendon changes: scenes whose falls go slack need another model.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from crane_bench.speed.engine import Run, RunResult, sweep_values
from crane_bench.speed.peers.joints import Vector
from crane_bench.speed.peers.mechanism import Body, Drive, Fall, Mechanism, initial_state, load_pose, segments
from crane_bench.speed.peers.mujoco_engine import find_package

NAME = "MuJoCo"
METHODS = {"RK4": 4, "implicitfast": 1}
"""Its integrators, and how often each evaluates the equations in a step."""
STEPS = sweep_values(0.2, 2e-4, 4)  # s
_LEAST = 2e-15  # kg m², an inertia that MuJoCo takes


def find_version() -> str:
    """Return the version.

    Raises:
        EngineUnavailable: it is not installed.
    """
    return str(find_package().__version__)


def runs(mechanism: Mechanism, method: str) -> list[Run]:
    """Return the sweep of steps of one of METHODS, coarsest first."""
    model = find_package().MjModel.from_xml_string(write_model(mechanism, method))
    return [Run(NAME, method, step, make_run(mechanism, model, method, step)) for step in STEPS]


def make_run(mechanism: Mechanism, model: Any, method: str, step: float) -> Callable[[int], RunResult]:
    """Return an integration with at most this step [s], which divides each of the segments."""
    mujoco, (first, pieces), (q, v) = find_package(), segments(mechanism), initial_state(mechanism)
    data, counts = mujoco.MjData(model), [int(np.ceil(piece.duration / step - 1e-9)) for piece in pieces]

    def execute(repetitions: int) -> RunResult:
        for _ in range(repetitions):
            data.qpos[:], data.qvel[:], data.act[:], data.time = q, v, first, 0.0
            for piece, count in zip(pieces, counts, strict=True):
                model.opt.timestep, data.ctrl[:] = piece.duration / count, piece.rates
                mujoco.mj_step(model, data, count)
        at, turn = load_pose(mechanism, data.qpos)
        return RunResult(at, METHODS[method] * sum(counts), sum(counts), attitude=turn)

    return execute


def write_model(mechanism: Mechanism, method: str) -> str:
    """Return the model in MuJoCo's XML; without contacts, and with nothing else that the crane does not need."""
    flags = " ".join(f'{name}="disable"' for name in ("contact", "constraint", "warmstart", "eulerdamp", "autoreset"))
    option = f'<option integrator="{method}" gravity="0 0 {-mechanism.gravity!r}"><flag {flags}/></option>'
    tendons, motors = map(_tendon, range(len(mechanism.falls)), mechanism.falls), map(_motor, mechanism.drives)
    return (
        f'<mujoco><compiler angle="radian"/>{option}<worldbody>{_tree(mechanism)}</worldbody>'
        f"<tendon>{''.join(tendons)}</tendon><actuator>{''.join(motors)}</actuator></mujoco>"
    )


def _tree(mechanism: Mechanism) -> str:
    """Return the bodies; joints without a mass move the next body, in the frame of the last of them."""
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
    places = np.cumsum([joint.offset for joint in joints], axis=0)  # while all angles and lengths are zero
    last, inertia = joints[-1], _numbers(max(value, _LEAST) for value in joints[-1].inertia)
    text = f'<body pos="{_numbers(places[-1])}">'
    text += "".join(_joint(i, mechanism.bodies[i], place - places[-1]) for i, place in zip(moving, places, strict=True))
    text += f'<inertial pos="{_numbers(last.com)}" mass="{float(last.mass)!r}" diaginertia="{inertia}"/>'
    for k, fall in enumerate(mechanism.falls):
        for which, (number, point) in (("upper", fall.upper), ("lower", fall.lower)):
            if number == moving[-1]:
                text += f'<site name="{which} {k}" pos="{_numbers(point)}"/>'
    return text


def _joint(i: int, body: Body, place: Any) -> str:
    kind, axis = "slide" if body.joint.prismatic else "hinge", _numbers(float(k == body.joint.axis) for k in range(3))
    inertia = f'armature="{float(body.armature)!r}" damping="{float(body.damping)!r}"'
    return f'<joint name="{i}" type="{kind}" axis="{axis}" pos="{_numbers(place)}" {inertia}/>'


def _tendon(k: int, fall: Fall) -> str:
    spring = f'springlength="0 {fall.length!r}" stiffness="{fall.stiffness!r}" damping="{fall.damping!r}"'
    return f'<spatial {spring}><site site="upper {k}"/><site site="lower {k}"/></spatial>'


def _motor(drive: Drive) -> str:
    return f'<general joint="{drive.body}" dyntype="integrator" gainprm="{float(drive.gain)!r}"/>'


def _numbers(values: Any | Vector) -> str:
    return " ".join(repr(float(value)) for value in values)
