"""A rope reeved over sheaves and a drum: tensions, reflected inertia, friction, energy.

Friction sticks and slips.
"""

from math import exp, pi
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import SceneError, load_scene, system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.loads import PointLoad
from crane_sim.models.supports.bridge import Bridge, BridgeAxis
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import MasslessHoist, MotionHoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.reeving import (
    Drum,
    Layers,
    Reeving,
    SheaveLoss,
    follow_rope,
    reeved_acceleration,
    reeving_energy,
)
from crane_sim.models.supports.support import Support
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.schema.reeving import RopeSlip, SheaveBearing, SheaveEfficiency

G = 9.81
AT_REST = (5.0, 0.0, 0.0)  # m, m/s, m/s²: length of the falls, its rate, its acceleration
LAYERS = Layers(np.array([30.0, 66.0]), np.array([3.0, 3.6]), 0.05)
FULL_REEVING = Reeving(4, 1, 12.0, SheaveLoss(1.03), Drum(0.4, 35.0, LAYERS), 2.5, 90.0)
TIGHT_INTEGRATOR = {"method": "dop853", "rtol": 1e-12, "atol": 1e-13}
SCENE: dict[str, Any] = {
    "crane": "bridge",
    "duration": 3.0,
    "trolley": {"mass": 1200.0},
    "bridge": {"mass": 1e4},
    "rope": {"drive": "force", "slack": "stop"},
    "payload": {"mass": 8000.0},
    "initial": {"q": [0.0, 0.0, 4.0, 0, 0]},
    "integrator": TIGHT_INTEGRATOR,
}
WEIGHT = 8000.0 * G
REEVED: dict[str, Any] = {
    "falls": 4,
    "sheaves": {"radius": 0.2, "inertia": 0.4, "loss": {"kind": "efficiency", "efficiency": 0.98}},
    "drum": {"radius": 0.25, "inertia": 30.0},
}


def table(*points: tuple[float, float]) -> dict[str, Any]:
    """Return a piecewise linear input of a scene, through points (time [s], value)."""
    return {
        "kind": "table",
        "times": [t for t, _ in points],
        "values": [value for _, value in points],
    }


SHEAVES = {"radius": 0.2, "inertia": 0.05, "loss": {"kind": "efficiency", "efficiency": 0.97}}
LOWERED_LOAD: dict[str, Any] = {
    "crane": "bridge",
    "duration": 1.0,
    "trolley": {"mass": 100.0},
    "bridge": {"mass": 200.0},
    "rope": {"drive": "rate", "slack": "stop", "reeving": {"falls": 4, "sheaves": SHEAVES}},
    "payload": {"mass": 1000.0},
    "initial": {"q": [0.0, 0.0, 5.0, 0.0, 0.0]},
}


def crane(hoist: Any) -> SuspendedCrane:
    """Return a bridge crane with hook and sling under this hoist."""
    cable = Chain(np.array([50.0, 1000.0]), np.array([5.0, 2.0]))
    return SuspendedCrane(
        Support(Bridge(BridgeAxis(100.0), BridgeAxis(200.0))), cable, PointLoad(1000.0), hoist
    )


def posture(rate: float) -> tuple[list[float], list[float]]:
    """Return joint positions and velocities of a swinging crane whose rope lengthens.

    `rate` is in m/s.
    """
    unit = np.array([0.1, 0.2, -1.0]) / np.sqrt(1.05)
    return [0.0, 0.0, 5.0, 0.1, -0.05, *unit.tolist()], [0.1, 0.2, rate, 0.1, 0.05, 0.0, 0.0, 0.0]


def compute_responses(hoist: Any, rate: float, u: tuple[float, ...]) -> np.ndarray:
    """Return joint accelerations, tensions of the links and power of `crane` under this hoist."""
    p = crane(hoist)
    x, tensions = system.state(p, 0.0, *posture(rate)), np.empty((1, 2))
    system.tensions(p, 0.0, x, u, tensions, 0, 0)
    return np.array([*system.acceleration(p, 0.0, x, u), *tensions[0], system.power(p, 0.0, x, u)])


@pytest.mark.parametrize("falls", [1, 2, 12])
def test_falls_without_friction_share_the_load(falls: int) -> None:
    """Each of n falls carries what the lead line does, however many sheaves lead it to the drum."""
    for lead_sheaves in (0, 1, 3):
        pull, lead, smallest, lost = follow_rope(
            Reeving(falls, lead_sheaves), 1.0, 700.0, AT_REST, G
        )
        assert pull == pytest.approx(falls * lead, rel=1e-12)  # rounding of twelve sums
        assert (lead, smallest, lost) == (700.0, 700.0, 0.0)


@pytest.mark.parametrize("falls", [2, 7])
def test_a_rope_that_slips_over_fixed_sheaves_follows_euler(falls: int) -> None:
    """A sheave that does not turn raises the tension by exp(μ θ) (Euler, capstan).

    On paying out it lowers the tension by this factor.
    """
    friction, wrap = 0.12, 0.8 * pi
    ratio = RopeSlip(friction, wrap).ratio(0.2)
    expected = exp(friction * wrap * (falls - 1 + 2))
    assert follow_rope(Reeving(falls, 2), ratio, 1.0, AT_REST, G)[1] == pytest.approx(
        expected, rel=1e-9
    )
    assert follow_rope(Reeving(falls, 2), 1.0 / ratio, 1.0, AT_REST, G)[1] == pytest.approx(
        1.0 / expected, rel=1e-9
    )


@pytest.mark.parametrize("falls", [5])
def test_a_block_has_the_efficiency_of_the_standard(falls: int) -> None:
    """Load over n times the lead line is η_lead (1 - η^n) / (n (1 - η)), as in DIN 15020-1."""
    eta = 0.97
    pull, lead, _, _ = follow_rope(
        Reeving(falls, 0), SheaveEfficiency(eta).ratio(0.2), 1.0, AT_REST, G
    )
    # rounding
    assert pull / (falls * lead) == pytest.approx((1 - eta**falls) / (falls * (1 - eta)), rel=1e-12)


def test_a_bearing_takes_the_moment_of_the_resultant() -> None:
    """The ratio by a plain bearing is that of the moments on a sheave under two parallel falls."""
    friction, pin, radius, low = 0.15, 0.03, 0.2, 500.0
    high = SheaveBearing(friction, pin).ratio(radius) * low
    # rounding
    assert (high - low) * radius == pytest.approx(friction * (high + low) * pin, rel=1e-12)


def rope_point_depth(s: float, length: float) -> float:
    """Return the depth [m] below the upper block of a rope's point s [m] from its dead end."""
    fall, remainder = int(s // length), s % length
    return remainder if fall % 2 == 0 else length - remainder


def explicit_energy(length: float, rate: float) -> tuple[float, float]:
    """Return (kinetic, potential) energy [J] of `FULL_REEVING`, summed over its parts.

    They are points of the rope, sheaves and the drum.

    Points of the rope keep their distance from the dead end along it, which gives their speeds.
    """
    n, density, step = FULL_REEVING.falls, 2.5, 1e-5
    nodes, weights = np.polynomial.legendre.leggauss(3)
    kinetic = potential = 0.0
    for fall in range(n):
        for node, weight in zip(nodes, weights, strict=True):
            s, mass = (fall + 0.5 + 0.5 * node) * length, density * 0.5 * weight * length
            speed = (
                rate
                * (rope_point_depth(s, length + step) - rope_point_depth(s, length - step))
                / (2.0 * step)
            )
            kinetic, potential = (
                kinetic + 0.5 * mass * speed**2,
                potential - mass * G * rope_point_depth(s, length),
            )
    wound = FULL_REEVING.length - n * length
    kinetic += 0.5 * density * wound * (n * rate) ** 2
    for speed in [
        *range(1, n),
        n,
    ]:  # of sheaves of the blocks and of the lead sheave, over the rate of the length
        kinetic += 0.5 * FULL_REEVING.sheave_mass * (speed * rate) ** 2
    radius = 0.4 + sum(
        0.05 * smootherstep((wound - full) / turn + 0.5)
        for full, turn in ((30.0, 3.0), (66.0, 3.6))
    )
    return kinetic + 0.5 * 35.0 * (n * rate / radius) ** 2, potential


def smootherstep(s: float) -> float:
    """Return the polynomial of degree 5 from 0 to 1 over 0 .. 1, at rest at both ends.

    Its first and second derivatives are zero there.
    """
    s = min(max(s, 0.0), 1.0)
    return 6.0 * s**5 - 15.0 * s**4 + 10.0 * s**3


@pytest.mark.parametrize("length", [6.1, 12.0])
def test_the_length_obeys_lagranges_equation(length: float) -> None:
    """Inverse mass and bias of the length are those of Lagrange's equation.

    Its energies are those of the explicit bodies.

    At 6.1 m the rope climbs onto a layer, where the drum's inertia changes with the length.
    """
    rate, force, pull, h = -1.3, -700.0, 3.1e4, 1e-3
    assert explicit_energy(length, rate) == pytest.approx(
        reeving_energy(FULL_REEVING, length, rate, G), rel=1e-10
    )
    kinetic = {i: explicit_energy(length + i * h, 1.0)[0] for i in range(-3, 4)}
    potential = {i: explicit_energy(length + i * h, 1.0)[1] for i in range(-3, 4)}

    def slope(
        f: dict[int, float],
    ) -> float:  # of sixth order: its error and the rounding are below 1e-10
        return float((45.0 * (f[1] - f[-1]) - 9.0 * (f[2] - f[-2]) + (f[3] - f[-3])) / (60.0 * h))

    mass = 2.0 * kinetic[0]
    expected = (
        FULL_REEVING.falls * force + pull - slope(potential) - slope(kinetic) * rate**2
    ) / mass
    inv_mass, bias = reeved_acceleration(
        FULL_REEVING._replace(loss=None), 1.0, force, length, rate, G
    )
    assert inv_mass == pytest.approx(1.0 / mass, rel=1e-9)
    assert bias + inv_mass * pull == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_friction_of_every_sheave_is_in_the_equations(direction: float) -> None:
    """Acceleration and tensions solve moment balances of sheaves, drum and block.

    All sheaves have bearings.
    """
    n, lead, mass, loss_share, inertia, radius = 5, 2, 40.0, 0.02, 60.0, 0.4
    # of the sheaves from the drum on, over the length's rate
    speeds = [*[n] * lead, *range(n - 1, 0, -1)]
    force, pull, size = -900.0, 5200.0, len(speeds) + 2
    # unknown: tensions from the drum on, acceleration
    a, b = np.zeros((size, size)), np.zeros(size)
    for i, speed in enumerate(speeds):
        a[i, i], a[i, i + 1], a[i, -1] = (
            -1 - direction * loss_share,
            1 - direction * loss_share,
            -mass * speed,
        )
    a[-2, 0], a[-2, -1], b[-2] = 1.0, -inertia / radius**2 * n, -force
    a[-1, lead:-1], b[-1] = 1.0, pull
    solved = np.linalg.solve(a, b)
    loss = SheaveLoss((1 + loss_share) / (1 - loss_share))
    reeving = Reeving(n, lead, mass, loss, Drum(radius, inertia))
    factor = loss.ratio**-direction
    inv_mass, bias = reeved_acceleration(reeving, factor, force, 5.0, 0.7 * direction, G)
    assert bias + inv_mass * pull == pytest.approx(solved[-1], rel=1e-9)
    found = follow_rope(reeving, factor, solved[-2], (5.0, 0.7 * direction, solved[-1]), G)
    assert found[:2] == pytest.approx((pull, solved[0]), rel=1e-9)
    moments = [
        direction * loss_share * (x + y) * s
        for x, y, s in zip(solved, solved[1:], speeds, strict=False)
    ]
    assert found[3] == pytest.approx(sum(moments), rel=1e-9)


def test_a_reeving_without_inertia_and_loss_changes_nothing() -> None:
    """One fall without inertia and loss is the plain winch bit for bit, n falls to rounding."""
    u = (10.0, -20.0, -9000.0)
    plain = compute_responses(MasslessHoist(), 0.3, u)
    assert compute_responses(ReevedHoist(Reeving(1, 1)), 0.3, u).tobytes() == plain.tobytes()
    np.testing.assert_allclose(
        compute_responses(ReevedHoist(Reeving(12, 1)), 0.3, u), plain, rtol=1e-12
    )
    rates = [
        compute_responses(MotionHoist(0.4, reeving), 0.3, u) for reeving in (None, FULL_REEVING)
    ]
    assert rates[0].tobytes() == rates[1].tobytes()


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_power_is_what_the_drive_gives_and_friction_takes(direction: float) -> None:
    """Energy changes by the power: the drive's less moments times speeds of all sheaves."""
    hoist = ReevedHoist(FULL_REEVING._replace(mass=None), Friction(80.0, 120.0, 30.0, 0.2))
    p, u, rate, h = crane(hoist), (10.0, -20.0, -9000.0), 0.3 * direction, 1e-4
    x = system.state(p, 0.0, *posture(rate))
    derivative, work = system.rhs(p, 0.0, x, u), system.power(p, 0.0, x, u)
    ends = [x + s * h * derivative for s in (-2.0, -1.0, 1.0, 2.0)]
    low, before, after, high = (system.kinetic(p, y) + system.potential(p, y) for y in ends)
    change = (8.0 * (after - before) - (high - low)) / (12.0 * h)
    driven = sum(force * speed for force, speed in zip(u, (0.1, 0.2, rate), strict=True))
    assert change == pytest.approx(work, rel=1e-8)  # rounding of energies of 1e4 J over h
    rows, acceleration = np.empty((1, 6)), system.acceleration(p, 0.0, x, u)[2]
    system.fall_tensions(p, 0.0, x, u, rows, 0)
    tensions, share, taken = rows[0, :5], 0.03 / 2.03, 0.0  # of the ratio 1.03
    for k, speed in enumerate([4, 3, 2, 1]):
        taken += share * (tensions[k] + tensions[k + 1]) * speed * abs(rate)
        assert (
            tensions[k + 1] - tensions[k] - 12.0 * speed * acceleration
        ) * direction == pytest.approx(share * (tensions[k] + tensions[k + 1]), rel=1e-9)
    winch = 80.0 + 40.0 * exp(-((0.3 / 0.2) ** 2)) + 30.0 * abs(rate)
    assert work == pytest.approx(driven - taken - winch * abs(rate), rel=1e-9)


def test_energy_balances_over_layers_stick_and_slip() -> None:
    """In a run over layers, with a heavy rope, losses, events and swing, energy is kept."""
    drum = {"radius": 0.25, "inertia": 30.0, "turns": 10, "layers": 8, "layer_height": 0.02}
    reeving = REEVED | {"drum": drum, "mass_per_length": 1.5, "length": 85.8}
    friction = {"coulomb": 1000.0, "static": 1500.0, "viscous": 2e4, "stribeck": 0.01}
    pulls = ((0, -9.6e4), (1.2, -9.6e4), (1.3, -7.6e4), (2.2, -7.6e4), (2.3, -6e4))
    inputs = {"trolley": table((0, 0), (0.5, 800), (1, 0)), "rope": table(*pulls)}
    rope = SCENE["rope"] | {"reeving": reeving, "friction": friction}
    run = crane_sim.simulate(SCENE | {"rope": rope, "inputs": inputs})
    assert [what.split()[-1] for _, what in run.events] == ["backwards", "sticks", "forwards"]
    # ten times the method's tolerance over the run's steps
    assert run.summary["energy_audit_max"] < 1e-9
    wound = 85.8 - 4.0 * run.q[:, 2]
    # m, in four layers; it climbs half a turn to either side of it
    full = 2 * pi * 10 * (0.25 + 0.27 + 0.29 + 0.31)
    assert wound[0] < full - pi * 0.31 / 2 and wound.max() > full + pi * 0.31


def test_a_load_at_rest_neither_creeps_nor_breaks_loose_early() -> None:
    """The winch holds up to the effort where hauling in begins, by what friction can hold."""
    efficiency = 0.98 * (1 - 0.98**4) / (4 * 0.02)  # of the falls while hauling in
    static, slope = 900.0, 1e4  # N, N/s
    rope = SCENE["rope"] | {"reeving": REEVED, "friction": {"coulomb": 500.0, "static": static}}
    inputs = {"rope": table((0, -WEIGHT), (3, -WEIGHT - 3 * slope))}
    run = crane_sim.simulate(SCENE | {"rope": rope, "inputs": inputs})
    (instant, what), *_ = run.events
    assert what == "the winch slips backwards"
    assert WEIGHT + slope * instant == pytest.approx(WEIGHT / efficiency + static, rel=1e-9)
    still = run.t < instant
    assert np.all(run.q[still, 2] == 4.0) and np.all(run.v[still, 2] == 0.0)
    assert run.lead_line[0] == pytest.approx(WEIGHT / 4, rel=1e-9)
    # at the drum's pull no friction is used
    assert run.falls[0] == pytest.approx(WEIGHT / 4 * np.ones(4), rel=1e-9)


def test_a_run_ends_where_a_fall_goes_slack() -> None:
    """A drum that is driven faster than the load falls ends the run, at the first tension of zero.

    With inertia that is the lead line's, before the falls are slack.
    """
    rope = SCENE["rope"] | {"reeving": REEVED}
    inputs = {"rope": table((0, -WEIGHT), (1, 4 * WEIGHT))}
    with pytest.raises(
        crane_sim.SimulationError, match="a fall of the reeving went slack"
    ) as error:
        crane_sim.simulate(SCENE | {"rope": rope, "inputs": inputs})
    run = error.value.run
    assert run.lead_line.min() > 0.0 and run.tension[-1] > run.lead_line[-1]


def test_no_reeved_rope_pushes() -> None:
    """Where a base falls away faster than the load, the run ends in one line."""
    falling = {"base_motion": {"heave": {"amplitude": 2.0, "frequency": 3.0}}}
    with pytest.raises(crane_sim.SimulationError) as error:
        crane_sim.simulate(crane_sim.load_scene(LOWERED_LOAD, falling))
    line = (
        "the rope over the sheaves went slack; change what moves rope or base, or take elastic "
        "`falls`"
    )
    assert line in str(error.value)


def test_a_winch_by_rate_has_tensions_and_torque() -> None:
    """At a given hauling acceleration the drum's power is that of load, inertia and losses.

    Its power is its torque times its speed.
    """
    rope = SCENE["rope"] | {"drive": "rate", "reeving": REEVED}
    p = load_scene(SCENE | {"rope": rope}).model
    rate, acceleration, rows = -0.4, -0.2, np.empty((1, 6))
    x = system.state(p, 0.0, [0.0, 0.0, 4.0, 0.0, 0.0], [0.0, 0.0, rate, 0.0, 0.0])
    system.fall_tensions(p, 0.0, x, (0.0, 0.0, acceleration), rows, 0)
    lead, *falls, torque = rows[0].tolist()
    pull, share = 8000.0 * (G - acceleration), 0.02 / 1.98
    assert sum(falls) == pytest.approx(pull, rel=1e-9)
    taken = sum(
        share * (a + b) * s for a, b, s in zip([lead, *falls], falls, [4, 3, 2, 1], strict=False)
    )
    inertia = 0.4 / 0.2**2 * (1 + 4 + 9 + 16) + 30.0 * (4 / 0.25) ** 2
    expected = -pull * rate - taken * rate + inertia * rate * acceleration
    assert torque * 4 * rate / 0.25 == pytest.approx(expected, rel=1e-9)


def test_a_torque_drives_the_drum_over_its_layers() -> None:
    """The same torque pulls with less force where the rope lies on more layers."""
    drum = {"radius": 0.25, "inertia": 30.0, "turns": 10, "layers": 8, "layer_height": 0.02}
    reeving = REEVED | {"drum": drum, "length": 90.0} | {"sheaves": None}
    p = load_scene(SCENE | {"rope": SCENE["rope"] | {"drive": "torque", "reeving": reeving}}).model
    rows, radii = np.empty((2, 6)), []
    for i, length in enumerate((3.0, 16.0)):
        x = system.state(p, 0.0, [0.0, 0.0, length, 0.0, 0.0], [0.0] * 5)
        system.fall_tensions(p, 0.0, x, (0.0, 0.0, -5000.0), rows, i)
        radii.append(p.hoist.reeving.drum.winding_radius(90.0 - 4 * length)[0])
    assert rows[:, -1] == pytest.approx(-5000.0, rel=1e-9)
    full = np.cumsum(2 * pi * 10 * (0.25 + 0.02 * np.arange(8)))
    assert radii == pytest.approx(
        [0.25 + 0.02 * np.searchsorted(full, w) for w in (78.0, 26.0)], rel=1e-12
    )


BAD = [
    ({"rope.slack": "allow"}, "rope.slack = 'allow': falls of a reeving cannot push; take 'stop'"),
    ({"rope.drive": "locked"}, "rope.reeving: belongs to a winch that moves the rope"),
    (
        {"rope.drive": "torque", "rope.reeving.drum": None},
        "rope.drive = 'torque': is that of a drum",
    ),
    (
        {"rope.drive": "rate", "rope.friction": {"coulomb": 1, "static": 1}},
        "rope.friction: belongs to a winch driven",
    ),
    (
        {"rope.reeving.mass_per_length": 2.0},
        "rope.reeving.length: is missing; a rope with a mass_per_length",
    ),
    (
        {"rope.reeving.drum.layers": 2},
        "rope.reeving.drum.turns: is missing; a drum with 2 layers needs it",
    ),
    (
        {"rope.reeving.drum.turns": 10, "rope.reeving.length": 90.0},
        "rope.reeving.drum: its layers hold 15.708 m of rope, and falls of 0.001 m leave 89.996 m "
        "to it",
    ),
    (
        {"rope.reeving.sheaves.loss": {"kind": "efficiency", "efficiency": 1.2}},
        "efficiency = 1.2: must be at most 1",
    ),
    (
        {"rope.reeving.sheaves.loss": {"kind": "bearing", "friction": 1.0, "pin_radius": 0.3}},
        "rope.reeving.sheaves.loss: one sheave holds inf times what pulls it; at most 1000",
    ),
    (
        {"rope.reeving.sheaves.loss": {"kind": "capstan", "friction": 0.1}},
        "rope.reeving.sheaves.inertia = 0.4: sheaves with the loss 'capstan' stand still; must be "
        "0",
    ),
    (
        {
            "actuators": {"rope": {"motor": {"ratio": 40.0, "inertia": 1.0}}},
            "rope.reeving.drum": None,
        },
        "actuators.rope.motor.inertia: belongs to a rope.reeving.drum with one layer",
    ),
    (
        {
            "rope.reeving": REEVED | {"mass_per_length": 1.0, "length": 50.0},
            "base_motion": {"roll": {"amplitude": 0.1, "frequency": 0.5}},
        },
        "rope.reeving.mass_per_length: belongs to a base that rests",
    ),
]


@pytest.mark.parametrize(("changes", "message"), BAD, ids=lambda case: str(case)[:60])
def test_a_bad_reeving_is_a_single_line_error(changes: Any, message: str) -> None:
    """What contradicts itself or cannot be is refused in one line with its keys and values."""
    with pytest.raises(SceneError) as error:
        load_scene(SCENE | {"rope": SCENE["rope"] | {"reeving": REEVED}}, changes)
    assert message in str(error.value) and "\n" not in str(error.value)
