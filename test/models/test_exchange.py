"""Pick-up and release of loads by the hook, against momentum of point masses, and in runs."""

from typing import Any

import numpy as np
import pytest
from point_masses import Point, body_points, mp, mpf, mpmath, plus, ring_points, rod_points, rotate

import crane_sim
from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.carrier.exchange import Exchange
from crane_sim.models.effects import BoomSpring
from crane_sim.models.energy_meter import Meter
from crane_sim.models.guards import Guard, encode
from crane_sim.models.loads import RigidLoad
from crane_sim.models.stops import Stops
from crane_sim.models.supports.bridge import Bridge, BridgeAxis
from crane_sim.models.supports.driven_point import DrivenPoint, Lift, Servo
from crane_sim.models.supports.hoist import ForceHoist, MasslessHoist, MotionHoist
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.models.supports.support import Support
from crane_sim.models.supports.tower_crane import JibTrolley, Slew, TowerCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.schema.exchange import LoadEvent, exchange_of
from crane_sim.scenes.schema.rigging import Payload

STEP = mpf(10) ** -18  # of central differences in 60 digits: an error of 36 digits
SUPPORTS = {
    "tower": TowerCrane(Slew(900.0), JibTrolley(8.0)),
    "bridge": Bridge(BridgeAxis(8.0), BridgeAxis(30.0)),
    "knuckle": Knuckle(
        Rod(5.0, 2.0, 4.2, 0.0), Rod(4.0, 3.0, 4.0, 0.0), Tower(8.0), BoomSpring(900.0, 0.2)
    ),
    "point": DrivenPoint(Servo(4.0, 3.0), Lift()),
}
SWINGING = {
    "crane": "pendulum",
    "duration": 0.6,
    "rope": {"length": 4.0},
    "payload": {"mass": 100.0},
    "initial": {"direction": [0.3, 0.0, -np.sqrt(0.91)]},
}
HOISTS = {"force": ForceHoist(1.5), "rate": MotionHoist(), "massless": MasslessHoist(1.0)}
NODES, LENGTHS = (2.0, 1.5), (2.5, 1.2, 0.8)  # kg, m
HOOK = {
    "mass": 3.0,
    "inertia": [[0.5, 0.02, -0.01], [0.02, 0.6, 0.03], [-0.01, 0.03, 0.7]],
    "attachment": [0.1, 0, 0.3],
}
# kg, m from the attachment, in the body's axes
TAKEN_MASS, TAKEN_CENTER = 20.0, np.array([0.3, -0.2, -1.4])
# kg m², about its centre
TAKEN_INERTIA = np.array([[6.0, 0.3, -0.2], [0.3, 8.0, 0.5], [-0.2, 0.5, 9.0]])
VELOCITY = (0.4, -0.3, 0.5)  # m/s
START = {
    "tower": (0.4, 6.0),
    "bridge": (0.4, 6.0),
    "knuckle": (0.4, 0.6, -0.2),
    "point": (0.4, 6.0, 1.0),
}
RATES = {name: (0.3, -0.2, 0.25)[: len(start)] for name, start in START.items()}
Q = (
    2.5,
    0.7,
    0.4,
    -1.1,
    0.5,
    2.0,
    0.3,
    0.5,
    -0.4,
    0.8,
)  # length, (azimuth, inclination) of links, body
V = (0.15, 0.4, -0.3, 0.2, 0.5, -0.4, 0.1, 0.3, -0.2, 0.4)


def composite() -> dict[str, Any]:
    """Return the payload of hook and load that is picked up, by the theorem of parallel axes."""
    mass, hook = HOOK["mass"] + TAKEN_MASS, -np.array(HOOK["attachment"])
    centre = (HOOK["mass"] * hook + TAKEN_MASS * TAKEN_CENTER) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in (
        (HOOK["mass"], hook, HOOK["inertia"]),
        (TAKEN_MASS, TAKEN_CENTER, TAKEN_INERTIA),
    ):
        r = c - centre
        inertia += np.array(own) + m * (r @ r * np.eye(3) - np.outer(r, r))
    return {"mass": mass, "inertia": inertia.tolist(), "attachment": (-centre).tolist()}


def loads(rigid: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the payloads before and after the pick-up, as groups of a scene."""
    return (
        (HOOK, composite())
        if rigid
        else ({"mass": HOOK["mass"]}, {"mass": HOOK["mass"] + TAKEN_MASS})
    )


def crane(name: str, hoist: str, rigid: bool, *events: dict[str, Any]) -> SuspendedCrane:
    """Return the crane with a schedule of pick-ups and releases."""
    schedule = [LoadEvent.model_validate(event) for event in events]
    load, exchange = exchange_of(Payload.model_validate(loads(rigid)[0]), schedule)
    chain = Chain(np.array([*NODES, load.mass]), np.array(LENGTHS))
    return SuspendedCrane(
        Support(SUPPORTS[name]),
        chain,
        load,
        HOISTS[hoist],
        energy_meter=Meter(),
        stops=Stops(),
        exchange=exchange,
    )


def direction(angles: Any) -> Point:
    """Return the unit vector with azimuth and inclination from the downward vertical."""
    s = mpmath.sin(angles[1])
    return s * mpmath.cos(angles[0]), s * mpmath.sin(angles[0]), -mpmath.cos(angles[1])


def turn(angles: Any, r: Any) -> Point:
    """Return a vector of the body, turned by yaw, pitch and roll."""
    return rotate(2, angles[0], rotate(1, angles[1], rotate(0, angles[2], tuple(map(mpf, r)))))


def quaternion(angles: Any) -> list[Any]:
    """Return the quaternion of yaw, pitch and roll."""
    (sa, ca), (sb, cb), (sc, cc) = ((mpmath.sin(a / 2), mpmath.cos(a / 2)) for a in angles)
    first = [ca * cb * cc + sa * sb * sc, ca * cb * sc - sa * sb * cc, ca * sb * cc + sa * cb * sc]
    return [*first, sa * cb * cc - ca * sb * sc]


def places(
    name: str, q: Any, rigid: bool
) -> tuple[list[tuple[Any, Point]], list[tuple[Any, Point]], list[Any]]:
    """Return (points of crane and hook, of the load it picks up, joint coordinates) at q.

    Bridge: the bridge's own mass is a point at x = 0, which only y moves.
    """
    points, tip = support_places(name, q)
    ns = len(START[name])
    node, n = tip, [direction(q[ns + 1 + 2 * k : ns + 3 + 2 * k]) for k in range(3)]
    for k in range(3):
        length = q[ns] if k == 0 else mpf(LENGTHS[k])
        node = plus(node, tuple(length * a for a in n[k]))
        if k < 2:
            points.append((mpf(NODES[k]), node))
    x, y, z = rotate(2, -q[0], n[0]) if name in ("tower", "knuckle") else n[0]
    first = (x, y, z) if name == "point" else (mpmath.atan2(y, -z), mpmath.asin(x))
    joints = [*q[: ns + 1], *first, *n[1], *n[2]]
    if not rigid:
        return [*points, (mpf(HOOK["mass"]), node)], [(mpf(TAKEN_MASS), node)], joints
    angles = q[ns + 7 :]
    hook = plus(node, turn(angles, tuple(-a for a in HOOK["attachment"])))
    centre = plus(node, turn(angles, TAKEN_CENTER))
    points += [
        (m, plus(hook, turn(angles, r)))
        for m, r in body_points(HOOK["mass"], np.array(HOOK["inertia"]))
    ]
    taken = [(m, plus(centre, turn(angles, r))) for m, r in body_points(TAKEN_MASS, TAKEN_INERTIA)]
    return points, taken, [*joints, *quaternion(angles)]


def support_places(name: str, q: Any) -> tuple[list[tuple[Any, Point]], Point]:
    """Return (points of the support, its tip) at coordinates q; a driven point has no mass."""
    if name == "tower":
        tip = rotate(2, q[0], (q[1], mpf(0), mpf(0)))
        return [*ring_points(900.0, q[0]), (mpf(8), tip)], tip
    if name == "point":
        return [], (q[0], q[1], q[2])
    if name == "bridge":
        return [(mpf(8), (q[0], q[1], mpf(0))), (mpf(30), (mpf(0), q[1], mpf(0)))], (
            q[0],
            q[1],
            mpf(0),
        )
    elbow = along(q[1], mpf(5))
    points = [(m, along(q[1], s)) for m, s in rod_points(2.0, 4.2, mpf("2.5"))]
    points += [(m, plus(elbow, along(q[2], s))) for m, s in rod_points(3.0, 4.0, mpf(2))]
    tip = plus(elbow, along(q[2], mpf(4)))
    return [*ring_points(8.0, q[0]), *((m, rotate(2, q[0], r)) for m, r in points)], rotate(
        2, q[0], tip
    )


def along(elevation: Any, distance: Any) -> Point:
    """Return the point at a distance along a rod of this elevation, at yaw 0."""
    return distance * mpmath.cos(elevation), mpf(0), distance * mpmath.sin(elevation)


def start(name: str, rigid: bool) -> tuple[list[Any], list[Any]]:
    """Return the coordinates before the pick-up, and their rates."""
    n = 10 if rigid else 7
    return [mpf(a) for a in (*START[name], *Q[:n])], [mpf(a) for a in (*RATES[name], *V[:n])]


class Reference:
    """Masses, Jacobians and joints of the point masses at Q, in 60 digits."""

    def __init__(self, name: str, hoist: str, rigid: bool) -> None:
        """Differentiate the places."""
        q, _ = start(name, rigid)
        self.n = len(q)
        own, taken, joints = places(name, q, rigid)
        self.count, self.joints = len(own), joints
        self.masses, self.places = [m for m, _ in own + taken], [r for _, r in own + taken]
        columns, self.joint_columns = [], []
        for i in range(self.n):
            low, high = (
                places(name, [a + s * (k == i) for k, a in enumerate(q)], rigid)
                for s in (-STEP, STEP)
            )
            ends = [[a for _, r in side[0] + side[1] for a in r] for side in (low, high)]
            columns.append([(b - a) / (2 * STEP) for a, b in zip(*ends, strict=True)])
            self.joint_columns.append(
                [(b - a) / (2 * STEP) for a, b in zip(low[2], high[2], strict=True)]
            )
        self.jacobian = mpmath.matrix(columns).T
        self.drum, self.length = mpf(1.5) if hoist == "force" else mpf(0), len(START[name])
        self.held = [
            *(range(self.length) if name == "point" else ()),
            *([self.length] if hoist == "rate" else ()),
        ]

    def velocities(self, v: Any) -> Any:
        """Return the velocities of all points (3 n, 1)."""
        return self.jacobian * mpmath.matrix(list(v))

    def jumped(self, v: Any, velocity: Any) -> Any:
        """Return the rates after the load, at `velocity`, was picked up.

        They solve M v = J' m (velocities before).
        """
        before, size = self.velocities(v), len(self.masses)
        for k in range(self.count, size):
            for c in range(3):
                before[3 * k + c] = mpf(velocity[c])
        weighted = mpmath.matrix(3 * size, self.n)
        for i in range(3 * size):
            for j in range(self.n):
                weighted[i, j] = self.masses[i // 3] * self.jacobian[i, j]
        matrix, right = weighted.T * self.jacobian, weighted.T * before
        matrix[self.length, self.length] += self.drum
        right[self.length] += self.drum * v[self.length]
        for i in self.held:
            for j in range(self.n):
                matrix[i, j] = mpf(j == i)
            right[i] = v[i]
        return mpmath.lu_solve(matrix, right)

    def joint_rates(self, v: Any) -> Any:
        """Return (joints, their rates) as floats."""
        rates = [
            mpmath.fdot([c[i] for c in self.joint_columns], v) for i in range(len(self.joints))
        ]
        return np.array([float(a) for a in self.joints]), np.array([float(a) for a in rates])


def exchange_now(p: SuspendedCrane, x: Any, k: int = 0) -> Any:
    """Return the state after exchange k, a pick-up or a release."""
    y, event, continues = system.apply_reset_map(
        p, 1.0, x, (0.0, 0.0, 0.0), encode(Guard.PAYLOAD, k)
    )
    assert continues and event == encode(Guard.PAYLOAD, k, 1)
    return y


def pick_up(rigid: bool, **more: Any) -> dict[str, Any]:
    """Return the event of the load's pick-up."""
    return {"at": 1.0, "set": {"payload": loads(rigid)[1]}, "velocity": VELOCITY} | more


def release(rigid: bool) -> dict[str, Any]:
    """Return the event of its release."""
    return {"at": 2.0, "set": {"payload": loads(rigid)[0]}}


CASES = [
    ("tower", "force", True),
    ("bridge", "massless", False),
    ("knuckle", "rate", True),
    ("point", "force", True),
    ("knuckle", "massless", False),
]


@pytest.mark.parametrize(("name", "hoist", "rigid"), CASES)
def test_jumps_are_those_of_point_masses(name: str, hoist: str, rigid: bool) -> None:
    """After a pick-up all velocities follow from the projected momentum of point masses."""
    with mp.workdps(60):
        reference, p = Reference(name, hoist, rigid), crane(name, hoist, rigid, pick_up(rigid))
        v = start(name, rigid)[1]
        q, rates = reference.joint_rates(v)
        expected = reference.joint_rates(reference.jumped(v, VELOCITY))[1]
    x = system.state(p, 0.0, q, rates)
    after = system.joints(p, exchange_now(p, x))
    np.testing.assert_allclose(after[0], q, rtol=0.0, atol=1e-15)
    # rounding of some 100 terms of size 1
    np.testing.assert_allclose(after[1], expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("name", "rigid"), [("tower", True), ("bridge", False)])
def test_momentum_from_the_free_hook_to_the_load_and_back(name: str, rigid: bool) -> None:
    """Pick-up and release conserve the momentum that no rail takes.

    It is linear momentum on a bridge, angular momentum on a tower.
    """
    with mp.workdps(60):
        reference, p = (
            Reference(name, "force", rigid),
            crane(name, "force", rigid, pick_up(rigid), release(rigid)),
        )
        q, rates = reference.joint_rates(start(name, rigid)[1])
        x = system.state(p, 0.0, q, rates)
        laden = exchange_now(p, x)
        free = exchange_now(p, laden, 1)
        given = [
            (mpf(a), mpf(b), mpf(c))
            for a, b, c in (VELOCITY,) * (len(reference.masses) - reference.count)
        ]
        before = momentum(
            name, reference, [*velocities_of(p, x, reference)[: reference.count], *given]
        )
        joined = momentum(name, reference, velocities_of(p, laden, reference))
        apart = momentum(name, reference, velocities_of(p, free, reference))
    np.testing.assert_array_equal(free[:-2], laden[:-2])  # release: nothing that stays jumps
    np.testing.assert_allclose(joined, before, rtol=1e-12)
    np.testing.assert_allclose(apart, before, rtol=1e-12)


def velocities_of(p: SuspendedCrane, x: Any, reference: Reference) -> Any:
    """Return the velocities of all points in the model's state x.

    Its rates in Q's coordinates are solved for.
    """
    rates, columns = system.joints(p, x)[1], mpmath.matrix(reference.joint_columns).T
    v = mpmath.lu_solve(columns, mpmath.matrix([mpf(float(a)) for a in rates]))  # least squares
    moved = reference.velocities(v)
    return [
        (moved[3 * k], moved[3 * k + 1], moved[3 * k + 2]) for k in range(len(reference.masses))
    ]


def momentum(name: str, reference: Reference, velocities: Any) -> list[float]:
    """Return the momentum that the support does not take.

    On a bridge that along x, in which the bridge itself does not move, and y; on a tower that about
    its axis.
    """
    terms = list(zip(reference.masses, reference.places, velocities, strict=True))
    if name == "tower":
        return [float(mpmath.fsum(m * (r[0] * v[1] - r[1] * v[0]) for m, r, v in terms))]
    return [float(mpmath.fsum(m * v[c] for m, _, v in terms)) for c in (0, 1)]


@pytest.mark.parametrize(
    "velocity", [VELOCITY, "hook", None], ids=["moving", "with the hook", "at rest"]
)
@pytest.mark.parametrize(("name", "hoist", "rigid"), CASES)
def test_the_energy_meter_jumps_as_the_energy_does(
    name: str, hoist: str, rigid: bool, velocity: Any
) -> None:
    """At pick-up and release the meter jumps as the crane's energy does; an impact dissipates.

    The jump is the work of the impulses.
    """
    p = crane(name, hoist, rigid, pick_up(rigid, velocity=velocity), release(rigid))
    with mp.workdps(60):
        reference = Reference(name, hoist, rigid)
        q, rates = reference.joint_rates(start(name, rigid)[1])
    x = system.state(p, 0.0, q, rates)
    laden = exchange_now(p, x)
    for before, after in ((x, laden), (laden, exchange_now(p, laden, 1))):
        gained = energy(p, after) - energy(p, before)
        supplied = system.energy_supplied(p, after) - system.energy_supplied(p, before)
        assert supplied == pytest.approx(gained, abs=1e-12 * energy_scale(p, x))
    if velocity == "hook":
        np.testing.assert_array_equal(laden[:-2], x[:-2])
    elif not reference.held:  # a drive that imposes its motion does work in an impact
        own = 0.5 * TAKEN_MASS * sum(a * a for a in (velocity or (0.0, 0.0, 0.0)))
        assert system.kinetic(p, laden) < system.kinetic(p, x) + own


def energy(p: SuspendedCrane, x: Any) -> float:
    """Return the crane's energy [J]."""
    return system.kinetic(p, x) + system.potential(p, x)


def energy_scale(p: SuspendedCrane, x: Any) -> float:
    """Return the size of energies in play [J]."""
    return (
        abs(system.kinetic(p, x))
        + abs(system.potential(p, x))
        + TAKEN_MASS * p.gravity * sum(LENGTHS)
    )


def test_an_impact_in_the_line_of_the_cable_in_numbers() -> None:
    """A point of 3 kg moving up at 2 m/s on a free rope picks up 1 kg at rest: both at 1.5 m/s."""
    schedule = [LoadEvent.model_validate({"at": 1.0, "set": {"payload": {"mass": 4.0}}})]
    load, exchange = exchange_of(Payload(mass=3.0), schedule)
    chain = Chain(np.array([3.0]), np.array([5.0]))
    p = SuspendedCrane(
        Support(SUPPORTS["bridge"]),
        chain,
        load,
        MasslessHoist(),
        energy_meter=Meter(),
        stops=Stops(),
        exchange=exchange,
    )
    y = exchange_now(
        p,
        system.state(
            p, 0.0, np.array([0.0, 0.0, 5.0, 0.0, 0.0]), np.array([0.0, 0.0, -2.0, 0.0, 0.0])
        ),
    )
    assert system.joints(p, y)[1][2] == pytest.approx(-1.5, rel=1e-15)
    assert system.energy_supplied(p, y) == pytest.approx(4.5 - 6.0 - 5.0 * 9.81, rel=1e-14)
    assert system.describe_event(p, encode(Guard.PAYLOAD, 0, 1)) == (
        "payload of 1 kg taken up, 4 kg hang now",
        "",
    )


def test_a_state_has_the_load_of_its_time() -> None:
    """A state made of joints has the hook alone up to the pick-up, and the load after it."""
    p = crane("bridge", "rate", True, pick_up(True))
    q, v = np.array([0.0, 0.0, 2.5, 0.1, 0.2, 0, 0, -1, 0, 0, -1, 1, 0, 0, 0]), np.zeros(15)
    before, after = (system.potential(p, system.state(p, t, q, v)) for t in (1.0, 1.0 + 1e-12))
    assert isinstance(p.load, RigidLoad) and isinstance(p.exchange, Exchange)
    z = -2.5 * np.cos(0.1) * np.cos(0.2) - LENGTHS[1] - LENGTHS[2]
    assert after - before == pytest.approx(TAKEN_MASS * 9.81 * (z + TAKEN_CENTER[2]), rel=1e-13)


def test_a_rope_that_would_push_ends_the_run() -> None:
    """Where ropes cannot push, picking up a body that moves up from below ends the run.

    The text says why.
    """
    event = {"at": 1.0, "set": {"payload": {"mass": 4.0}}, "velocity": (0.0, 0.0, 2.0)}
    load, exchange = exchange_of(Payload(mass=3.0), [LoadEvent.model_validate(event)])
    chain = Chain(np.array([3.0]), np.array([5.0]))
    for taut in (0.0, 1.0):
        support, stops = Support(SUPPORTS["bridge"]), Stops(taut=taut)
        p = SuspendedCrane(support, chain, load, MotionHoist(), stops=stops, exchange=exchange)
        x = system.state(p, 0.0, np.array([0.0, 0.0, 5.0, 0.0, 0.0]), np.zeros(5))
        assert system.apply_reset_map(p, 1.0, x, (0.0, 0.0, 0.0), encode(Guard.PAYLOAD, 0))[2] == (
            taut == 0.0
        )
    assert "a link would push" in system.describe_event(p, encode(Guard.PAYLOAD, 0))[0]


RUN = {
    "crane": "tower",
    "duration": 6.0,
    "slew": {"drive": "force", "inertia": 1.0e4},
    "trolley": {"mass": 300.0},
    "rope": {"drive": "rate", "time_constant": 0.3},
    "links": [{"mass": 60.0, "length": 2.0}],
    "payload": HOOK | {"mass": 30.0, "windage": {"area": 0.5, "drag_coefficient": 1.2}},
    "events": [],
    "wind": {"speed": 8.0},
    "initial": {"q": [0.0, 10.0, 5.0, 0.1, 0.05], "v": [0.05, 0.1, 0.0, 0.0, 0.0]},
    "inputs": {"slew": {"kind": "constant", "value": 500.0}},
}
HEAVY = {"mass": 530.0, "inertia": [300.0, 350.0, 250.0], "attachment": [0.1, 0.0, 1.0]}


def test_a_run_with_exchanges_keeps_its_energy() -> None:
    """A crane slews in the wind, picks a body up, releases it; the energy balance closes.

    The texts name both exchanges.
    """
    events = [
        {"at": 2.0, "set": {"payload": HEAVY}, "velocity": [0.2, 0.0, 0.1]},
        {"at": 4.5, "set": {"payload": HOOK | {"mass": 30.0}}},
    ]
    run = crane_sim.simulate(
        RUN | {"events": events, "integrator": {"method": "dop853", "rtol": 1e-11, "atol": 1e-11}}
    )
    summary = run.summary
    assert summary["energy_audit_max"] < 1e-9
    texts = [event["what"] for event in summary["events"]]
    assert texts == [
        "payload of 500 kg taken up, 530 kg hang now",
        "payload of 500 kg let go, 30 kg hang now",
    ]
    before, laden = (
        run.derived.tension[run.t <= 2.0],
        run.derived.tension[(run.t > 2.0) & (run.t <= 4.5)],
    )
    assert before.max() < 2000.0 < 4000.0 < laden.min()  # weights of 883 and 5788 N, which swing


REJECTED = [
    (
        {"velocity": [0, 0, 1]},
        HOOK | {"mass": 20.0, "inertia": [0.3, 0.4, 0.5]},
        "events[0].velocity: belongs to what is",
    ),
    (
        {},
        {"mass": 530.0},
        "events[0].set.payload.inertia: is missing; the payloads of a run are all point masses, or "
        "all",
    ),
    (
        {},
        HEAVY | {"inertia": [40.0, 40.0, 0.5]},
        "events[0].set.payload.inertia: the 500 kg by which the payload changes",
    ),
]


@pytest.mark.parametrize(("event", "payload", "line"), REJECTED)
def test_exchanges_that_cannot_be_are_refused(
    event: dict[str, Any], payload: dict[str, Any], line: str
) -> None:
    """Each contradiction is one line that begins with the key."""
    events = [{"at": 1.0, "set": {"payload": payload}} | event]
    with pytest.raises(crane_sim.SceneError) as error:
        crane_sim.load_scene(RUN | {"events": events})
    assert line in str(error.value) and "\n" not in str(error.value)


def test_the_instant_of_an_exchange_is_the_one_before_it() -> None:
    """At its own instant, inside a run or at its end, the state is that before the exchange.

    The next state is after it.
    """
    taken = {"events": [{"at": 0.5, "set": {"payload": {"mass": 300.0}}}]}
    free, run = crane_sim.simulate(SWINGING), crane_sim.simulate(SWINGING | taken)
    # other steps, of rtol 1e-9
    assert run.v[:51] == pytest.approx(free.v[:51], abs=1e-9) and run.t[50] == 0.5
    # 300 kg with the momentum of 100 kg, and what 10 ms of gravity add
    assert run.v[51, 3] == pytest.approx(free.v[50, 3] / 3.0, abs=0.01 * 9.81 * 0.4)
    ended = crane_sim.simulate(SWINGING | taken, duration=0.5)
    assert ended.v[-1] == pytest.approx(free.v[50], abs=1e-9) and not ended.events
