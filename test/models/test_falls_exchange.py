"""Pick-up and release of loads on falls, against point masses, and on the ground in whole runs."""

from typing import Any

import numpy as np
import pytest
from falls_reference import SUPPORTS, mapped, places, strain_energy
from point_masses import Extras, accelerations, body_points, mpf, on_base, plus
from test_falls import falls
from test_suspended import INERTIA, SEA, base, turn

import crane_sim
from crane_sim import system
from crane_sim.models.contact.surface import PointChanges, RigidContact, Surface
from crane_sim.models.energy_meter import Meter
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.guards import Guard, encode
from crane_sim.models.loads import RigidLoad
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.support import Support
from crane_sim.scenes.schema.exchange import LoadEvent, exchange_of
from crane_sim.scenes.schema.rigging import Payload

OWN = {"mass": 10.0, "inertia": INERTIA.tolist(), "attachment": [0.1, 0.05, 0.6]}
# kg, m from the first load's centre of mass
TAKEN_MASS, TAKEN_CENTRE = 25.0, np.array([0.3, -0.2, -1.4])
# kg m², about its centre
TAKEN_INERTIA = np.array([[6.0, 0.3, -0.2], [0.3, 8.0, 0.5], [-0.2, 0.5, 9.0]])
VELOCITY = (0.4, -0.3, 0.5)  # m/s
CORNERS = np.array([[1.0, 0.8, -2.0], [1.0, -0.8, -2.0], [-1.0, 0.8, -2.0], [-1.0, -0.8, -2.0]])
Q = {
    "bridge": (0.8, 1.1, 2.0, 1.1, 1.3, -2.9, 0.35, 0.05, -0.04),
    "tower": (0.3, 6, 2, 6.03, 1.97, -2.9, 0.35, 0.05, -0.04),
}
V = (0.2, -0.1, 0.15, 0.3, -0.2, 0.1, 0.25, -0.3, 0.2)


def composite() -> dict[str, Any]:
    """Return the payload of both bodies, by the theorem of parallel axes."""
    mass = OWN["mass"] + TAKEN_MASS
    centre = TAKEN_MASS * TAKEN_CENTRE / mass
    inertia = np.zeros((3, 3))
    for m, c, own in (
        (OWN["mass"], np.zeros(3), INERTIA),
        (TAKEN_MASS, TAKEN_CENTRE, TAKEN_INERTIA),
    ):
        r = c - centre
        inertia += own + m * (r @ r * np.eye(3) - np.outer(r, r))
    return {
        "mass": mass,
        "inertia": inertia.tolist(),
        "attachment": (np.array(OWN["attachment"]) - centre).tolist(),
    }


def crane(name: str, sea: bool = False, velocity: Any = VELOCITY) -> FallsCrane:
    """Return a crane that picks a body up at 1 s and releases it at 2 s."""
    events = [
        {"at": 1.0, "set": {"payload": composite()}, "velocity": velocity},
        {"at": 2.0, "set": {"payload": OWN}},
    ]
    load, exchange = exchange_of(
        Payload.model_validate(OWN), [LoadEvent.model_validate(event) for event in events]
    )
    hoist, moved = ForceHoist(1.5), base() if sea else None
    assert isinstance(load, RigidLoad)
    support = Support(SUPPORTS[name])
    return FallsCrane(
        support, falls(0.02), load, hoist, energy_meter=Meter(), base=moved, exchange=exchange
    )


def exchange_now(p: FallsCrane, x: Any, k: int, t: float = 1.0) -> Any:
    """Return the state after exchange k."""
    y, event, continues = system.apply_reset_map(p, t, x, (0.0, 0.0, 0.0), encode(Guard.PAYLOAD, k))
    assert continues and event == encode(Guard.PAYLOAD, k, 1)
    return y


def state_of(p: FallsCrane, name: str, t: float) -> Any:
    """Return the state at Q and V, in the coordinates of the joints."""
    joints, rates, _ = mapped(Q[name], V, np.zeros(9))
    return system.state(p, t, joints, rates)


@pytest.mark.parametrize(("name", "sea"), [("tower", False), ("bridge", True)])
def test_accelerations_of_the_load_that_hangs_now(name: str, sea: bool) -> None:
    """With what was taken up, the first load's point accelerates as point masses of both bodies."""
    taken = [
        (m, plus(tuple(map(mpf, TAKEN_CENTRE.tolist())), r))
        for m, r in body_points(TAKEN_MASS, TAKEN_INERTIA)
    ]

    def both(t: Any, q: Any) -> Any:
        added = [(m, plus(tuple(q[3:6]), turn(q[6:], r))) for m, r in taken]
        return places(name, sea)(t, q) + [(m, on_base(SEA, t, r) if sea else r) for m, r in added]

    efforts, added = np.zeros(9), np.zeros(9)
    efforts[:3], added[2] = (15.0, -8.0, -120.0), 1.5
    expected = accelerations(both, 1.5, Q[name], V, efforts, Extras(added, strain_energy(name)))
    p = crane(name, sea)
    p = p._replace(falls=p.falls._replace(relaxation=np.zeros(4)))
    joints, rates, second = mapped(Q[name], V, expected)
    state = system.state(p, 1.5, joints, rates)
    got = system.acceleration(p, 1.5, state, (15.0, -8.0, -120.0))
    # rounding of stiff springs
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-11 * abs(second).max())


def momentum(q: Any, v: Any, bodies: Any) -> Any:
    """Return the momenta (6,) about the origin of bodies that move as the load at joints q, v.

    They are momentum and angular momentum.

    Args:
        q, v: joint coordinates and rates, of which those of the load are used.
        bodies: (mass, centre from the coordinates' point (3,), inertia (3, 3)), in the axes of the
            load.
    """
    (w, a, b, c), quaternion_rates = q[6:10], v[6:10]
    skew = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
    rotation = np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew
    omega = 2.0 * np.array([[-a, w, c, -b], [-b, -c, w, a], [-c, b, -a, w]]) @ quaternion_rates
    total = np.zeros(6)
    for mass, centre, inertia in bodies:
        place, velocity = q[3:6] + rotation @ centre, v[3:6] + rotation @ np.cross(omega, centre)
        total += np.concatenate(
            [mass * velocity, mass * np.cross(place, velocity) + rotation @ (inertia @ omega)]
        )
    return total


@pytest.mark.parametrize("name", ["tower", "bridge"])
def test_momentum_of_both_bodies_is_that_of_the_one(name: str) -> None:
    """Pick-up and release conserve both momenta; only the load's velocities jump.

    They are momentum and angular momentum.
    """
    p = crane(name)
    x = state_of(p, name, 0.0)
    laden = exchange_now(p, x, 0)
    own, taken = (OWN["mass"], np.zeros(3), INERTIA), (TAKEN_MASS, TAKEN_CENTRE, TAKEN_INERTIA)
    (q, v), (_, after) = system.joints(p, x), system.joints(p, laden)
    still = np.concatenate([np.zeros(3), VELOCITY, np.zeros(4)])
    before = momentum(q, v, [own]) + momentum(q, still, [taken])
    np.testing.assert_allclose(
        momentum(q, after, [own, taken]), before, rtol=1e-12, atol=1e-12 * abs(before).max()
    )
    # all positions, the rates of support and hoist
    np.testing.assert_array_equal(laden[:13], x[:13])
    np.testing.assert_array_equal(exchange_now(p, laden, 1, 2.0)[:20], laden[:20])


@pytest.mark.parametrize(
    "velocity", [VELOCITY, "hook", None], ids=["moving", "with the spreader", "at rest"]
)
def test_the_energy_meter_jumps_as_the_energy_does(velocity: Any) -> None:
    """At pick-up and release the meter jumps as the crane's energy does; an impact dissipates."""
    p = crane("bridge", velocity=velocity)
    x = state_of(p, "bridge", 0.0)
    laden = exchange_now(p, x, 0)
    scale = system.kinetic(p, x) + abs(system.potential(p, x)) + 25.0 * 9.81 * 3.0
    for before, after in ((x, laden), (laden, exchange_now(p, laden, 1, 2.0))):
        gained = system.kinetic(p, after) + system.potential(p, after)
        gained -= system.kinetic(p, before) + system.potential(p, before)
        supplied = system.energy_supplied(p, after) - system.energy_supplied(p, before)
        assert supplied == pytest.approx(gained, abs=1e-12 * scale)
    if velocity == "hook":
        np.testing.assert_array_equal(laden[:20], x[:20])
    else:
        own = 0.5 * TAKEN_MASS * sum(a * a for a in (velocity or (0.0, 0.0, 0.0)))
        assert system.kinetic(p, laden) < system.kinetic(p, x) + own


@pytest.mark.parametrize(("height", "allowed"), [(-5.0, True), (-3.9, False)])
def test_points_of_the_new_load(height: float, allowed: bool) -> None:
    """From the exchange on the new load's points touch at their own height.

    Below it the run ends, and says why.
    """
    changes = PointChanges(
        np.stack([CORNERS, CORNERS - (0.0, 0.0, 0.1), CORNERS]), np.array([-9.0, height, -9.0])
    )
    p = crane("bridge")._replace(
        contact=RigidContact(CORNERS, Surface(-9.0, 0.1, 1e-3), 0.0, 0.01, changes)
    )
    x = system.state(p, 0.0, np.array([0, 0, 2.0, 0, 0, -2.9, 1, 0, 0, 0]), np.zeros(10))
    y, event, continues = system.apply_reset_map(
        p, 1.0, x, (0.0, 0.0, 0.0), encode(Guard.PAYLOAD, 0)
    )
    assert continues == allowed
    landed = system.state(p, 1.5, system.joints(p, y)[0], np.zeros(10))
    assert landed[-5:-1].tolist() == [1.0] * 4  # the old ones are far above theirs
    text, change = system.describe_event(p, event if allowed else encode(Guard.PAYLOAD, 0))
    assert text.startswith("payload of 25 kg taken up, 35 kg hang now")
    assert ("below the surface" in text) != allowed and (
        "events[0].set.contact" in change
    ) != allowed


@pytest.mark.parametrize("stands", [(1.0, 1.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0)])
def test_a_load_that_stands_on_fewer_than_three_points_does_not_stick(stands: Any) -> None:
    """A load that sticks still sticks after an exchange if it stands on three points or more.

    Otherwise it slips.
    """
    # m: those that do not stand are higher
    points = CORNERS + np.outer(1.0 - np.array(stands), (0.0, 0.0, 0.1))
    changes = PointChanges(np.stack([CORNERS, points, CORNERS]), np.full(3, -4.9))
    surface = Surface(-4.9, 0.4, 1e-3)
    p = crane("bridge", velocity=(0.0, 0.0, 0.0))._replace(
        contact=RigidContact(CORNERS, surface, 0.0, 0.01, changes)
    )
    x = system.state(p, 0.0, np.array([0, 0, 3.5, 0, 0, -2.9, 1, 0, 0, 0]), np.zeros(10))
    assert x[-5:].tolist() == [1.0] * 5
    assert exchange_now(p, x, 0)[-5:].tolist() == [*stands, float(all(stands))]


@pytest.mark.slow
def test_a_container_is_set_down_and_left() -> None:
    """A spreader lands on a container, lifts it off the heaving deck, sets it down, leaves it."""
    run = crane_sim.simulate("spreader_pick_up")
    assert run.summary["energy_audit_max"] < 1e-9
    tension, weight = (
        run.tensions.sum(axis=1),
        {k: 9.81 * m for k, m in (("spreader", 18e3), ("all", 48.48e3))},
    )
    on_roof, carried, left = (np.argmin(abs(run.t - t)) for t in (24.0, 40.0, 74.0))
    assert tension[on_roof] == 0.0  # falls are slack
    # of a load that still swings up and down
    assert tension[carried] == pytest.approx(weight["all"], rel=0.05)
    assert tension[left] == pytest.approx(weight["spreader"], rel=0.05)
    deck = 0.2 * np.sin(0.7 * run.t)
    bottom, roof = run.q[:, 5] + 1.0 - 4.05 + 34.0 - deck, run.q[:, 5] + 1.0 - 1.46 + 31.41 - deck
    laden = (run.t > 25.0) & (run.t <= 58.0)
    assert min(bottom[laden].min(), roof[~laden].min()) > -1e-6  # m, of the middle of the corners
    standing = (run.t > 20.0) & (run.t < 26.0) | (run.t > 54.0) & (run.t < 60.0)
    assert np.where(laden, bottom, roof)[standing].max() < 1e-6
    # no coordinate jumps, at 10 ms and 0.5 m/s
    np.testing.assert_allclose(np.diff(run.q[:, 5]), 0.0, atol=0.02)


SQUARE = [[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]]
SCENE: dict[str, Any] = {
    "crane": "gantry",
    "duration": 1.0,
    "trolley": {"mass": 2e4},
    "bridge": {"mass": 1e5},
    "falls": {"top": SQUARE, "bottom": SQUARE, "axial_stiffness": 2e6},
    "payload": {"mass": 1000.0, "inertia": [1500, 900, 2000], "attachment": [0, 0, 1.0]},
    "contact": {"points": [[1, 1, -2], [1, -1, -2], [-1, 1, -2]], "height": -20.0},
    "initial": {"length": 10.0},
}
HEAVY = {"mass": 3000.0, "inertia": [4500, 2700, 6000], "attachment": [0, 0, 1.0]}
POINTS = {"points": [[1, 1, -4], [1, -1, -4], [-1, 1, -4]]}


@pytest.mark.parametrize(
    ("change", "contact", "message"),
    [
        (
            {"payload": HEAVY},
            {},
            "events[0].set.contact: is missing; with contact, say which points of the new",
        ),
        (
            {"payload": HEAVY, "contact": POINTS},
            {"contact": None},
            "events[0].set.contact: needs contact, the surface",
        ),
        (
            {"payload": HEAVY, "contact": {"points": [[1, 1, -4]]}},
            {},
            "events[0].set.contact.points: has 1 points, contact.points has 3",
        ),
        (
            {"payload": HEAVY, "contact": {"points": [[1, 1, -4], [0, 1, -4], [-1, 1, -4]]}},
            {},
            "events[0].set.contact.points: 1, 2 and 3 are in a line",
        ),
        (
            {"payload": {"mass": 3000.0}, "contact": POINTS},
            {},
            "events[0].set.payload.inertia: is missing",
        ),
    ],
    ids=lambda case: str(case)[:40],
)
def test_exchanges_that_cannot_be_are_refused(change: Any, contact: Any, message: str) -> None:
    """Each contradiction is one line with its keys."""
    with pytest.raises(crane_sim.SceneError) as error:
        crane_sim.load_scene(SCENE, {"events": [{"at": 0.5, "set": change}], **contact})
    assert message in str(error.value) and "\n" not in str(error.value)
