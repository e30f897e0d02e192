"""A winch with ropes over sheaves to elastic falls: what it turns and loses, and slack falls."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import SceneError, load_scene, system
from crane_sim.models.falls.crane import Falls, FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.supports.bridge import Bridge, BridgeAxis
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import MotionHoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.reeving import Drum, Reeving, SheaveLoss
from crane_sim.models.supports.support import Support

G, MASS, STIFFNESS = 9.81, 8000.0, 2e6
ENDS = [[x, y, 0.0] for x in (0.5, -0.5) for y in (0.4, -0.4)]
LOSSY = Reeving(4, 1, 12.0, SheaveLoss(1.03), Drum(0.4, 35.0))
SHEAVES = {"radius": 0.2, "inertia": 0.4, "loss": {"kind": "efficiency", "efficiency": 0.98}}
REEVED: dict[str, Any] = {"falls": 4, "sheaves": SHEAVES, "drum": {"radius": 0.25, "inertia": 30.0}}
SCENE: dict[str, Any] = {
    "crane": "gantry",
    "duration": 1.0,
    "trolley": {"mass": 1200.0},
    "bridge": {"mass": 1e4},
    "hoist": {"drive": "force", "reeving": REEVED},
    "falls": {"top": ENDS, "bottom": ENDS, "axial_stiffness": STIFFNESS, "parts": 4},
    "payload": {"mass": MASS, "inertia": [4e3, 4e3, 6e3], "attachment": [0.0, 0.0, 1.0]},
    "initial": {"length": 4.0},
    "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-13},
}
WEIGHT = MASS * G


def table(*points: tuple[float, float]) -> dict[str, Any]:
    """Return an input of a scene, (time [s], value) by corners."""
    return {
        "kind": "table",
        "times": [t for t, _ in points],
        "values": [value for _, value in points],
    }


def crane(hoist: Any) -> FallsCrane:
    """Return a gantry whose load hangs on four falls that are not parallel, under this hoist."""
    inertia = ((4e3, 0.0, 0.0), (0.0, 4e3, 0.0), (0.0, 0.0, 6e3))
    inverse = tuple(tuple(1.0 / v if v else 0.0 for v in row) for row in inertia)
    top = np.array(ENDS)
    falls = Falls(
        top, 0.8 * top + [0.0, 0.0, 1.0], 4.0, np.zeros(4), np.full(4, 8e6), np.full(4, 0.02)
    )
    bridge = Support(Bridge(BridgeAxis(100.0), BridgeAxis(200.0)))
    return FallsCrane(bridge, falls, RigidLoad(MASS, inertia, inverse, (0.0, 0.0, 1.0)), hoist)


def state(p: FallsCrane, rate: float, depth: float = 5.02) -> Any:
    """Return a state of a load that swings and turns, at a depth [m]; falls lengthen at a rate."""
    q = [0.1, 0.2, 4.0, 0.15, 0.22, -depth, 1.0, 0.0, 0.0, 0.0]
    return system.state(p, 0.0, q, [0.1, 0.2, rate, 0.05, -0.1, -0.2, 0.0, 0.01, 0.02, 0.03])


def answers(hoist: Any, rate: float, u: tuple[float, ...]) -> np.ndarray:
    """Return joint accelerations, tensions of the falls and power of `crane` under this hoist."""
    p = crane(hoist)
    x, tensions = state(p, rate), np.empty((1, 4))
    system.tensions(p, 0.0, x, u, tensions, 0, 0)
    return np.array([*system.acceleration(p, 0.0, x, u), *tensions[0], system.power(p, 0.0, x, u)])


def test_a_reeving_without_strength_is_none() -> None:
    """A reeving changes no imposed motion, and zero friction no winch of a mass, bit for bit."""
    rates = [
        answers(MotionHoist(0.4, reeving), 0.3, (10.0, -20.0, 0.1)) for reeving in (None, LOSSY)
    ]
    assert rates[0].tobytes() == rates[1].tobytes()
    plain = SCENE | {
        "hoist": {"drive": "force", "mass": 5e3},
        "inputs": {"hoist": table((0, -WEIGHT), (1, -9e4))},
    }
    none = {"hoist.friction": {"coulomb": 0.0, "static": 0.0}}
    hashes = {crane_sim.simulate(plain, overrides=o).summary["state_sha256"] for o in (None, none)}
    assert len(hashes) == 1


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_power_is_what_the_drive_gives_and_friction_takes(direction: float) -> None:
    """Energy changes by the power, with losses of sheaves, winch and falls counted in."""
    hoist = ReevedHoist(LOSSY, Friction(80.0, 120.0, 30.0, 0.2))
    p, u, h = crane(hoist), (10.0, -20.0, -7e4), 1e-5
    x = state(p, 0.3 * direction)
    derivative = system.rhs(p, 0.0, x, u)
    ends = [x + s * h * derivative for s in (-2.0, -1.0, 1.0, 2.0)]
    low, before, after, high = (system.kinetic(p, y) + system.potential(p, y) for y in ends)
    change = (8.0 * (after - before) - (high - low)) / (12.0 * h)
    # rounding of energies of 4e5 J over h
    assert change == pytest.approx(system.power(p, 0.0, x, u), rel=1e-7)


def test_a_winch_holds_until_its_pull_exceeds_friction() -> None:
    """Hauling in begins where the drive exceeds what sheaves and winch hold, not before."""
    high, static, rise = 0.98 * (1 - 0.98**4) / (4 * 0.02), 900.0, 1e4
    hoist = SCENE["hoist"] | {"friction": {"coulomb": 500.0, "static": static}}
    run = crane_sim.simulate(
        SCENE | {"hoist": hoist, "inputs": {"hoist": table((0, -WEIGHT), (1, -WEIGHT - rise))}}
    )
    (instant, what), *_ = run.events
    # with the strain that goes with the rope
    pull = 4 * (tension := WEIGHT / 4) + 4 * tension**2 / (2 * 4 * STIFFNESS)
    assert what == "the winch slips backwards"
    assert WEIGHT + rise * instant == pytest.approx(pull / high + static, rel=1e-9)
    assert np.all(run.q[run.t < instant, 2] == 4.0)


def test_a_load_is_set_down_and_picked_up_by_the_torque_of_a_drum() -> None:
    """Falls slack on the ground and pull again, the winch sticks and slips, and energy is kept."""
    corners = [[x, y, -2.0] for x in (0.6, -0.6) for y in (0.5, -0.5)]
    down, up = (-0.25 * share * WEIGHT / 4 for share in (0.25, 1.3))  # N m, on the drum
    changes = {
        "duration": 4.0,
        "falls": SCENE["falls"] | {"relaxation": 0.02},
        "hoist": {
            "drive": "torque",
            "reeving": REEVED,
            "friction": {"coulomb": 2e3, "static": 3e3, "viscous": 2e5, "stribeck": 0.01},
        },
        "contact": {"points": corners, "height": -6.2, "friction": 0.3},
        "inputs": {"hoist": table((0, down), (1.5, down), (1.7, 500.0), (2.0, up), (4.0, up))},
        "integrator": {"method": "dop853", "rtol": 1e-10, "atol": 1e-12},
    }
    run = crane_sim.simulate(SCENE | changes)
    what = [text for _, text in run.events]
    assert "the winch slips forwards" in what and "the winch slips backwards" in what
    assert (
        any(text.endswith("touches the surface") for text in what) and "fall 1 went slack" in what
    )
    assert what.index("fall 1 went slack") < len(what) - 1 - what[::-1].index("fall 1 pulls")
    assert run.tensions.min() >= 0.0 and run.q[-1, 5] > -5.2  # lifted off again
    assert run.summary["energy_audit_max"] < 1e-9


BAD = [
    (
        {"falls.parts": 1}
        | {f"hoist.reeving.{key}": 0 for key in ("drum.inertia", "lead_sheaves")}
        | {"hoist.reeving.falls": 1},
        "hoist.reeving.drum.inertia: is missing",
    ),
    (
        {"hoist.reeving.falls": 2},
        "hoist.reeving.falls = 2: each fall has falls.parts = 4 parts of rope; make them",
    ),
    (
        {"hoist.mass": 3.0},
        "hoist.mass: is what hoist.reeving says of sheaves and drum; leave out one of the two",
    ),
    (
        {"hoist.reeving": None},
        "hoist.mass: is missing; a force drive needs it, or a hoist.reeving with a drum",
    ),
    (
        {"hoist.drive": "torque", "hoist.reeving.drum": None},
        "hoist.drive = 'torque': is that of a drum; give hoist.",
    ),
    (
        {"hoist.drive": "rate", "hoist.friction": {"coulomb": 1, "static": 1}},
        "hoist.friction: belongs to a winch driven",
    ),
    (
        {"hoist.reeving.mass_per_length": 1.0},
        "hoist.reeving.mass_per_length: the rope of elastic falls weighs nothing",
    ),
    (
        {"hoist.reeving.length": 12.0},
        "hoist.reeving.length = 12: too short, 4 falls of 4 m take 16 m",
    ),
    (
        {"hoist.reeving.drum": None, "hoist.reeving.sheaves.inertia": 0.0},
        "hoist.reeving.drum.inertia: is missing; elastic falls would turn a winch driven by "
        "'force' without inertia",
    ),
    (
        {"hoist.friction": {"coulomb": 2, "static": 1}},
        "hoist.friction.static = 1.0: must be at least coulomb = 2.0",
    ),
]


@pytest.mark.parametrize(("changes", "message"), BAD, ids=lambda case: str(case)[:60])
def test_a_bad_winch_is_a_single_line_error(changes: Any, message: str) -> None:
    """What contradicts itself or cannot be is refused in one line with its keys and values."""
    with pytest.raises(SceneError) as error:
        load_scene(SCENE, changes)
    assert message in str(error.value) and "\n" not in str(error.value)
