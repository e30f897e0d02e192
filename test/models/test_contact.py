"""Contact of a load on falls: equations and impacts, against virtual work and closed forms.

Virtual work is that of point masses.
"""

from math import atan, cos, pi, sin
from typing import Any

import numpy as np
import pytest
from falls_reference import SUPPORTS, mapped, places, strain_energy
from point_masses import Extras, accelerations, mp, mpf, on_base, plus
from test_falls import falls, rigid
from test_suspended import INERTIA, SEA, base, turn

from crane_sim import system
from crane_sim.models.carrier.layout import contact_index
from crane_sim.models.contact.forces import slipping_forces
from crane_sim.models.contact.impacts import collide, impulse_work
from crane_sim.models.contact.rigid import holding_forces, is_closed, normal_force_on
from crane_sim.models.contact.surface import (
    ZERO,
    RigidContact,
    Surface,
    contact_point,
    displacement_at,
)
from crane_sim.models.falls.contact_events import load_alone
from crane_sim.models.falls.crane import FallsCrane, body_state
from crane_sim.models.loads import BodyState
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.support import Support
from crane_sim.trajectories.base_motion import Base

T, FRICTION, SLIP = 0.9, 0.4, 1e-3
CORNERS = np.array([[0.8, 0.6, -1.0], [0.8, -0.6, -1.0], [-0.7, 0.6, -1.0], [-0.7, -0.6, -1.0]])
HEAVE = {"heave": {"amplitude": 0.3, "frequency": 0.8, "phase": 0.5}}
# rad, that leave so many corners closed
TILTS = {1: (0.12, 0.08), 2: (0.12, 0.0), 3: (0.0, 0.0), 4: (0.0, 0.0)}
EFFORTS = (15.0, -8.0, -120.0)


def heaving() -> Base:
    """Return the motion HEAVE of a surface."""
    rows = np.zeros((3, 6, 1))
    rows[:, 2, 0] = 0.3, 0.8, 0.5
    return Base(np.zeros(6), *rows)


def place(q: Any, point: Any) -> Any:
    """Return a point of the load relative to the base; q: support, length, centre, angles."""
    return plus(tuple(q[3:6]), turn(q[6:], tuple(map(mpf, point.tolist()))))


def along(function: Any, t: float, q: Any, v: Any, a: Any) -> tuple[float, float, float]:
    """Return a function of (t, q) and its two derivatives at these rates and accelerations."""
    with mp.workdps(60):
        h, (q, v, a) = mpf(10) ** -18, ([mpf(float(x)) for x in row] for row in (q, v, a))
        values = []
        for s in (-h, mpf(0), h):
            values.append(
                function(
                    mpf(t) + s, [x + s * y + s * s * z / 2 for x, y, z in zip(q, v, a, strict=True)]
                )
            )
        low, middle, high = values
        return float(middle), float((high - low) / (2 * h)), float((high - 2 * middle + low) / h**2)


def gap_of(point: Any) -> Any:
    """Return the height of a corner above the heaving plane z = 0, a function of (t, q)."""
    return lambda t, q: place(q, point)[2] - on_base(HEAVE, t, (mpf(0), mpf(0), mpf(0)))[2]


class Resting:
    """A load that slides on some corners: coordinates, rates, corners, and surface height."""

    def __init__(self, count: int) -> None:
        """Choose a posture on `count` closed corners of four, or of the three that there are."""
        pitch, roll = TILTS[count]
        self.corners = CORNERS[:3] if count == 3 else CORNERS
        self.q = np.array([0.8, 1.1, 2.0, 1.1, 1.3, -2.9, 0.3, pitch, roll])
        self.v = np.random.default_rng(count).uniform(-0.3, 0.3, 9)
        heights = [along(gap_of(c), T, self.q, self.v, 0.0 * self.v)[0] for c in self.corners]
        self.height = min(heights)
        self.closed = [i for i, z in enumerate(heights) if z - self.height < 1e-12]
        assert len(self.closed) == count
        self.v[[5, 7, 8]] -= np.linalg.lstsq(*self._rates(), rcond=None)[0]

    def _rates(self) -> Any:
        """Return (Jacobian of closed corners' heights in z and tilts, rates of the heights)."""
        rows, rates = [], []
        for i in self.closed:
            gap = gap_of(self.corners[i])
            rows.append([along(gap, T, self.q, np.eye(9)[k], np.zeros(9))[1] for k in (5, 7, 8)])
            rows[-1] = [r - along(gap, T, self.q, np.zeros(9), np.zeros(9))[1] for r in rows[-1]]
            rates.append(along(gap, T, self.q, self.v, np.zeros(9))[1])
        return np.array(rows), np.array(rates)

    def crane(self, sea: bool) -> FallsCrane:
        """Return the crane above the surface."""
        surface = Surface(self.height, FRICTION, SLIP, heaving())
        contact = RigidContact(self.corners, surface, 0.0, 0.01)
        hoist = ForceHoist(1.5)
        support, moved = Support(SUPPORTS["bridge"]), base() if sea else None
        return FallsCrane(support, falls(), rigid(), hoist, base=moved, contact=contact)


def normal_forces_of(crane: FallsCrane, x: Any) -> Any:
    """Return (normal force on each closed corner, wrench) of a load that slips."""
    contact, first, load = crane.contact, contact_index(crane), body_state(crane, x)
    assert isinstance(contact, RigidContact)
    scene = displacement_at(contact.surface.motion, T), load
    normal_forces = slipping_forces(contact, crane.load, x, first, scene, load_alone(crane, T, x))
    closed = [i for i in range(len(contact.points)) if is_closed(x, first, i)]
    levers = [contact_point(contact, i, *scene).lever for i in closed]
    return (
        np.array([normal_force_on(normal_forces, k, r) for k, r in enumerate(levers)]),
        normal_forces.wrench,
        np.array(levers),
    )


def unit_push(corner: Any, q: Any, v: Any, sea: bool) -> Extras:
    """Return a newton of normal force on a corner with its friction, and the falls' springs."""
    slip = [along(lambda _, at, k=k: place(at, corner)[k], T, q, v, 0.0 * v)[1] for k in (0, 1)]
    size = np.sqrt(slip[0] ** 2 + slip[1] ** 2 + SLIP**2)
    force = tuple(
        mpf(float(x)) for x in (-FRICTION * slip[0] / size, -FRICTION * slip[1] / size, 1.0)
    )
    group, origin = (SEA if sea else {}), (mpf(0), mpf(0), mpf(0))
    pairs = zip(on_base(group, mpf(T), force), on_base(group, mpf(T), origin), strict=True)
    world = [a - b for a, b in pairs]
    added = np.zeros(9)
    added[2] = 1.5
    return Extras(
        added,
        strain_energy("bridge"),
        lambda t, at: on_base(group, t, place(at, corner)),
        lambda _: world,
    )


@pytest.mark.parametrize(("count", "sea"), [(1, True), (2, True), (3, False), (4, True)])
def test_closed_corners_follow_the_surface(count: int, sea: bool) -> None:
    """A sliding load accelerates as point masses under contact; closed corners as the deck.

    Contact is by normal forces and friction.
    """
    load = Resting(count)
    q, v, efforts, added = load.q, load.v, np.zeros(9), np.zeros(9)
    efforts[:3], added[2] = EFFORTS, 1.5
    free = accelerations(
        places("bridge", sea), T, q, v, efforts, Extras(added, strain_energy("bridge"))
    )
    crane = load.crane(sea)
    joints, rates, _ = mapped(q, v, free)
    x = system.state(crane, T, joints, rates)
    normal_forces, _, _ = normal_forces_of(crane, x)
    assert len(normal_forces) == count and x[-1] == 0.0
    expected = free.copy()
    for normal_force, i in zip(normal_forces, load.closed, strict=True):
        pushed = accelerations(
            places("bridge", sea), T, q, v, efforts, unit_push(load.corners[i], q, v, sea)
        )
        expected += normal_force * (pushed - free)
    got = system.acceleration(crane, T, x, EFFORTS)
    second = mapped(q, v, expected)[2]
    # rounding of stiff springs
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-11 * abs(second).max())
    parting = [along(gap_of(load.corners[i]), T, q, v, expected)[2] for i in load.closed]
    # rounding of gaps, times the rate of their correction
    np.testing.assert_allclose(parting, 0.0, atol=1e-9)


def test_indeterminate_normal_forces_are_the_least_squares() -> None:
    """Of all normal forces on four corners with the same sums the model takes the least squares.

    The sums are those of force and of tilting moment.
    """
    load = Resting(4)
    crane = load.crane(False)
    contact: Any = crane.contact
    frictionless = crane._replace(
        contact=contact._replace(surface=contact.surface._replace(friction=0.0))
    )
    joints, rates, _ = mapped(load.q, load.v, 0.0 * load.v)
    normal_forces, wrench, levers = normal_forces_of(
        frictionless, system.state(frictionless, T, joints, rates)
    )
    rows = np.array([np.ones(4), levers[:, 1], -levers[:, 0]])
    least = np.linalg.lstsq(rows, [wrench.force[2], *wrench.moment[:2]], rcond=None)[0]
    np.testing.assert_allclose(normal_forces, least, rtol=1e-12)  # rounding of the solution


def heeled(axis: int, angle: float) -> Base:
    """Return a base at rest that is turned by an angle [rad] about x (axis 3) or y (axis 4)."""
    offsets, still = np.zeros(6), np.zeros((6, 1))
    offsets[axis] = angle
    return Base(offsets, still, still, still)


def sticking(contact: RigidContact, moved: Base, yaw: float = 0.0) -> tuple[FallsCrane, Any]:
    """Return (crane, state) of a load that sticks to a surface below.

    The surface is 10 m below the base's origin, the load's centre 1 m above it.
    """
    loose, load = falls()._replace(length=20.0), rigid(np.diag([3.0, 4.0, 5.0]))
    crane = FallsCrane(Support(SUPPORTS["bridge"]), loose, load, None, base=moved, contact=contact)
    q = np.array([0.0, 0.0, 0.0, 0.0, -9.0, cos(0.5 * yaw), 0.0, 0.0, sin(0.5 * yaw)])
    x = system.state(crane, 0.0, q, np.zeros(9))
    x[-1] = 1.0
    return crane, x


@pytest.mark.parametrize(("part", "holds"), [(0.9999, True), (1.0001, False)])
def test_a_load_slips_on_a_base_that_heels_beyond_friction(part: float, holds: bool) -> None:
    """On a base that heels by φ a load at rest is held while tan φ < μ, not accelerated."""
    contact = RigidContact(CORNERS, Surface(-10.0, FRICTION, SLIP), 0.0, 0.01)
    crane, x = sticking(contact, heeled(3, atan(part * FRICTION)))
    assert not system.acceleration(crane, 0.0, x, (0.0, 0.0))[2:].any()
    value, _, _ = system.guard(crane, 0.0, x, (0.0, 0.0), None)
    assert (value > 0.0) == holds
    assert abs(value) == pytest.approx(1e-4, rel=1e-8)  # rounding, relative to 1


@pytest.mark.parametrize("part", [0.9999, 1.0001])
@pytest.mark.parametrize(
    ("axis", "side", "reach"), [(3, 1, 0.6), (3, -1, 0.6), (4, 1, 0.75), (4, -1, 0.75)]
)
def test_a_load_tips_on_a_base_that_heels_beyond_its_edge(
    axis: int, side: int, reach: float, part: float
) -> None:
    """A load that friction holds tips beyond tan φ = way to the edge over height.

    Then the upper corners lift off.
    """
    # a rectangle about the centre
    heel, points = side * atan(part * reach), CORNERS - (0.05, 0.0, 0.0)
    crane, x = sticking(
        RigidContact(points, Surface(-10.0, 5.0, SLIP), 0.0, 0.01), heeled(axis, heel)
    )
    value, _, _ = system.guard(crane, 0.0, x, (0.0, 0.0), None)
    weight = crane.load.mass * 9.81 * cos(heel)
    # rounding, relative to the weight
    assert value == pytest.approx(0.25 * weight * (1.0 - part), rel=1e-8)


def test_forces_at_the_corners_hold_a_load_that_sticks() -> None:
    """Normal forces and their friction add up to the force and tilting moment of the hold."""
    amplitudes, ones = np.zeros((6, 1)), np.ones((6, 1))
    amplitudes[:2, 0] = 1.5, -0.8
    # which is not moving at t = 0, but accelerates
    deck = Base(np.zeros(6), amplitudes, ones, 0.5 * pi * ones)
    contact = RigidContact(CORNERS, Surface(-10.0, FRICTION, SLIP, deck), 0.0, 0.01)
    crane, x = sticking(contact, base(), yaw=0.6)
    scene = displacement_at(deck, 0.0), body_state(crane, x)
    held = holding_forces(
        contact, crane.load, x, contact_index(crane), scene, load_alone(crane, 0.0, x)
    )
    levers = np.array([contact_point(contact, i, *scene).lever for i in range(4)])
    normal_forces = np.array([normal_force_on(held, i, lever) for i, lever in enumerate(levers)])
    force, moment = held.wrench
    assert min(map(abs, (*force, *moment))) > 0.01  # N and N m, in all directions
    # with friction in proportion; more of it turns about z alone
    forces = np.outer(normal_forces / force[2], force)
    forces[:, 2] = normal_forces
    np.testing.assert_allclose(forces.sum(axis=0), force, rtol=1e-12)  # rounding of the solution
    tilting = np.cross(levers, forces).sum(axis=0)[:2]
    np.testing.assert_allclose(tilting, moment[:2], atol=1e-12 * force[2])  # the same, at a metre


def body_at(lever: Any, velocity: Any, omega: Any) -> BodyState:
    """Return the kinematics of a body that is not turned."""
    rows = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    return BodyState(tuple(lever), tuple(velocity), rows, tuple(omega), (1.0, 0.0, 0.0, 0.0))


def test_a_rocking_block_loses_what_housner_says() -> None:
    """A block rocking onto its other edge keeps 1 - 3/2 sin² α of its rate (Housner).

    It neither bounces nor slips.
    """
    half, tall, depth, mass = 0.3, 1.0, 0.2, 7.0
    # half is along y, tall along z, depth along x
    sizes = (half, tall), (depth, tall), (half, depth)
    moments = [mass / 3.0 * (a * a + b * b) for a, b in sizes]
    points = np.array([[x, y, -tall] for y in (-half, half) for x in (-depth, depth)])
    contact = RigidContact(points, Surface(0.0, 1e3, SLIP), 0.0, 0.01)
    rate = 0.8  # about x, on the edge at -half: the other one comes down with a negative rate
    state = body_at(
        (0.0, 0.0, tall), np.cross([-rate, 0.0, 0.0], [0.0, half, tall]), (-rate, 0.0, 0.0)
    )
    after, _ = collide(
        contact, rigid(np.diag(moments), mass), displacement_at(None, 0.0), state, np.ones(4)
    )
    kept = 1.0 - 1.5 * sin(atan(half / tall)) ** 2
    np.testing.assert_allclose(after.omega, (-rate * kept, 0.0, 0.0), atol=1e-12)  # of the sweeps
    lifted = contact_point(contact, 0, displacement_at(None, 0.0), after).velocity
    assert lifted[2] > 0.0


def impacts() -> Any:
    """Return random impacts, each (contact, velocity, angular velocity, touching corners)."""
    rng = np.random.default_rng(5)
    for _ in range(60):
        restitution, friction = rng.choice([0.0, 0.3, 0.8, 1.0]), rng.choice([0.0, 0.2, 0.7])
        contact = RigidContact(CORNERS, Surface(-1.0, friction, SLIP), restitution, 1e-6)
        touching = (rng.random(4) < 0.6).astype(float)
        touching[rng.integers(4)] = 1.0
        velocity = rng.uniform(-1.0, 1.0, 3) - (0.0, 0.0, 1.0)
        yield contact, velocity, rng.uniform(-0.5, 0.5, 3), touching


def test_impacts_give_no_energy_and_leave_no_approach() -> None:
    """After an impact no touching corner approaches and no impulse pulls.

    The work done is the energy's change.
    """
    load, resting = rigid(), displacement_at(None, 0.0)
    for contact, velocity, omega, touching in impacts():
        before = body_at(ZERO, velocity, omega)
        after, impulse = collide(contact, load, resting, before, touching)
        speeds = [
            contact_point(contact, i, resting, after).velocity[2] for i in range(4) if touching[i]
        ]
        assert min(speeds) > -1e-12  # of the sweeps
        change = 0.5 * load.mass * (np.dot(after.velocity, after.velocity) - velocity @ velocity)
        change += 0.5 * (np.array(after.omega) @ INERTIA @ after.omega - omega @ INERTIA @ omega)
        work = impulse_work(impulse, before, after, ZERO)
        # rounding of tens of joules
        assert work == pytest.approx(change, rel=0.0, abs=1e-12) and work < 1e-12
        assert impulse.force[2] >= 0.0
        drag = np.hypot(*impulse.force[:2])
        assert drag <= contact.surface.friction * impulse.force[2] * (1.0 + 1e-12)
