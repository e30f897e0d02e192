"""Knuckle-boom crane: a tower that slews, a boom and a jib that luff.

Model of Ambrosino, Dawans, Thierens, Garone, "Oscillation Reduction for Knuckle Cranes", with its
misprints corrected: A4 and A5 without the factor 2, d² in m55 and m66, and c12, c15, c16, c22, c24
.. c26, c35, c55, c61 .. c66 as the Lagrangian gives them. In the slewing frame (e_r, e_t, e_z),
turned about z by the slew angle alpha, neither alpha nor the swing angles appear, and the 6x6 solve
of the Lagrange form becomes one division (slew) and one 2x2 solve (boom, jib). beta and gamma are
the elevations of boom and jib, both from the horizontal. With length lB, mass mB and transverse
inertia IB of the boom, lJ, mJ, IJ of the jib, and the inertia It of the tower about the vertical

    K1 = lB² (mB/4 + mJ),   K2 = lJ² mJ/4,   K3 = lB lJ mJ/2,
    p1 = K1 cos β + K3 cos γ,   p2 = K2 cos γ + K3 cos β,
    hb = p1 sin β,   hg = p2 sin γ,   c = K3 cos(β - γ),   s = K3 sin(β - γ),

    (It + p1 cos β + p2 cos γ) α'' = u1 + r F_t + 2 α' (hb β' + hg γ')
    (IB + K1) β'' + c γ'' = u2 + lB (F_z cos β - F_r sin β) - g lB (mB/2 + mJ) cos β - s γ'² - hb
    α'² c β'' + (IJ + K2) γ'' = u3 + lJ (F_z cos γ - F_r sin γ) - g lJ mJ/2 cos γ + s β'² - hg α'²,

u1, u2, u3 the efforts tau on the joints, F the force on the tip (r, 0, h). Motors add their
inertias on the left, axial inertias of the rods add to the inertia of the slew, and so to hb and
hg, which are -½ its derivatives by β and γ.
"""

from math import cos, sin
from typing import Any, NamedTuple

from crane_sim.files.types import AngleRange, NonNegative, Positive
from crane_sim.models.effects import (
    BoomSpring,
    JibSpring,
    add_jib_spring,
    add_jib_spring_energy,
    add_spring,
    add_spring_energy,
)
from crane_sim.models.guards import Guard, encode, travel_guard
from crane_sim.models.supports.boom_loads import imposed_efforts, wind_moments, world_energies
from crane_sim.models.supports.support import Mechanism, Pressed, Spring
from crane_sim.models.wind_load import RodWindage
from crane_sim.multibody.tree import Body, Joint, Point, Tree, Y, Z
from crane_sim.multibody.vectors import add, diagonal
from crane_sim.numerics.elementary import sincos


class Rod(NamedTuple):
    """Boom or jib: a rod whose centre of mass is at its middle."""

    length: Positive  # m, between its joints
    mass: NonNegative  # kg, evenly spread or not: its centre is at the middle
    inertia: NonNegative  # kg m², about a transverse axis through the centre of mass
    axial_inertia: NonNegative | None = None  # kg m², about the rod, at most twice `inertia`; left
    # out: the inertia has no part in the slew's
    limits: AngleRange | None = None  # rad, of the elevation; a run ends where one is reached
    windage: RodWindage | None = None  # area and drag in the `wind`; left out: no wind acts on it

    def body(self) -> Body:
        """Return the rod in axes at its lower joint, along x.

        A thin one has inertia about its luffing axis alone.
        """
        axial, vertical = (
            (0, 0) if self.axial_inertia is None else (self.axial_inertia, self.inertia)
        )
        return Body(self.mass, (0.5 * self.length, 0, 0), diagonal(axial, self.inertia, vertical))

    def yaw_inertia(self, c, s):
        """Return (inertia about the vertical, -½ its derivative by the elevation).

        Both are 0 without an axial inertia.
        """
        axial, inertia = self.axial_inertia, self.inertia
        if axial is None:
            return 0.0, 0.0
        return inertia * c * c + axial * s * s, (inertia - axial) * s * c

    def inertia_tensor(self, c, s):
        """Return (a, b, d (3,)) of the tensor a 1 + b d dᵀ [kg m²]; I l lᵀ if thin."""
        if self.axial_inertia is None:
            return 0.0, self.inertia, (0.0, -1.0, 0.0)
        return self.inertia, self.axial_inertia - self.inertia, (c, 0.0, s)


class Tower(NamedTuple):
    """The tower, which slews with boom and jib."""

    inertia: Positive  # kg m², about the vertical
    limits: AngleRange | None = None  # rad, of the slew angle; a run ends where one is reached


class KnucklePosture(NamedTuple):
    """Kinematics of a state in the slewing frame, and inertia terms by the module's symbols."""

    tip: tuple[float, float, float]  # (r, 0, h)
    tip_velocity: tuple[float, float, float]  # (r', 0, h')
    yaw_rate: float  # alpha', of the slewing frame
    beta: float
    gamma: float
    beta_rate: float
    gamma_rate: float
    cb: float  # cos beta
    sb: float
    cg: float  # cos gamma
    sg: float
    c: float  # K3 cos(beta - gamma), inertia coupling of boom and jib
    s: float  # K3 sin(beta - gamma)
    slew_inertia: float  # kg m², of the tower, boom and jib about the vertical; this and the next
    # with the motors'
    hb: float  # -½ d(slew inertia)/d beta
    hg: float
    boom_inertia: float  # kg m², IB + K1
    jib_inertia: float  # kg m², IJ + K2
    free: Any = None  # (slew, boom, jib), which of them friction does not hold; None: all are free

    def free_moments(self, moments):
        """Return the moments (slew, boom, jib), without those on joints that friction holds."""
        if self.free is None:
            return moments
        slew, boom, jib = moments
        return (
            slew if self.free[0] else 0.0,
            boom if self.free[1] else 0.0,
            jib if self.free[2] else 0.0,
        )

    def free_coupling(self):
        """Return the inertia coupling of boom and jib: none where friction holds one of them."""
        if self.free is None:
            return self.c
        return self.c if self.free[1] and self.free[2] else 0.0

    def solve_luff(self, b2, b3):
        """Return accelerations of boom and jib for right-hand sides [N m] of their equations."""
        c = self.free_coupling()
        inverse = 1.0 / (self.boom_inertia * self.jib_inertia - c * c)
        return (self.jib_inertia * b2 - c * b3) * inverse, (
            self.boom_inertia * b3 - c * b2
        ) * inverse


class Knuckle(NamedTuple):
    """Parameters of the structure: tower, boom and jib, without what hangs on the tip."""

    boom: Rod
    jib: Rod
    tower: Tower
    boom_spring: BoomSpring | None = None
    jib_spring: JibSpring | None = None
    motors: tuple[float, float, float] | None = None  # kg m², of slew, boom and jib: motor inertia
    # times ratio squared

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("slew", "tower.limits"), ("boom", "boom.limits"), ("jib", "jib.limits"))[i]

    def mechanism(self) -> Mechanism:
        """Return joints and bodies: slew, boom, and jib with its elevation to the horizontal."""
        boom, jib = self.boom, self.jib
        slew = Joint(Z, ((0, 1),), bodies=(Body(0, inertia=diagonal(0, 0, self.tower.inertia)),))
        luff = Joint(Y, ((1, 1),), reverse=True, parent=0, bodies=(boom.body(),))
        head = boom.length, 0, 0
        fold = Joint(
            Y, ((2, 1), (1, -1)), reverse=True, parent=1, offset=head, bodies=(jib.body(),)
        )
        rods = (1, boom), (2, jib)
        return Mechanism(
            Tree((slew, luff, fold), Point(2, (jib.length, 0, 0))),
            limits=(self.tower.limits, boom.limits, jib.limits),
            actuated=(0, 1, 2),
            springs=self._springs(),
            outline=(Point(-1), Point(2)),
            pressed=tuple(
                Pressed(joint, rod.windage, rod.windage.centre * rod.length)
                for joint, rod in rods
                if rod.windage is not None
            ),
        )

    def _springs(self) -> tuple[Spring, ...]:
        boom, jib, springs = self.boom_spring, self.jib_spring, ()
        if boom is not None:
            springs = (Spring((0, 1, 0), boom.stiffness, boom.rest),)
        if jib is not None:
            springs = (
                *springs,
                Spring((0, -1.0 if jib.relative else 0.0, 1), jib.stiffness, jib.rest),
            )
        return springs

    def forward_kinematics(self, xs):
        """Return the KnucklePosture of state xs."""
        _, beta, gamma, yaw_rate, vb, vg = xs
        boom, jib, (sb, cb), (sg, cg) = (
            self.boom.length,
            self.jib.length,
            sincos(beta),
            sincos(gamma),
        )
        tip = boom * cb + jib * cg, 0.0, boom * sb + jib * sg
        tip_velocity = -boom * sb * vb - jib * sg * vg, 0.0, boom * cb * vb + jib * cg * vg
        directions, rates = (cb, sb, cg, sg), (vb, vg)
        terms = self._inertia_terms(*directions)
        return KnucklePosture(tip, tip_velocity, yaw_rate, beta, gamma, *rates, *directions, *terms)

    def _inertia_terms(self, cb, sb, cg, sg):
        """Return the inertia terms of a KnucklePosture, from `c` to `jib_inertia`."""
        boom, jib = self.boom, self.jib
        k1 = boom.length * boom.length * (0.25 * boom.mass + jib.mass)
        k2 = 0.25 * jib.length * jib.length * jib.mass
        k3 = 0.5 * boom.length * jib.length * jib.mass
        p1, p2 = k1 * cb + k3 * cg, k2 * cg + k3 * cb
        (boom_yaw_inertia, boom_h), (jib_yaw_inertia, jib_h) = (
            boom.yaw_inertia(cb, sb),
            jib.yaw_inertia(cg, sg),
        )
        slew = self.tower.inertia + cb * p1 + cg * p2 + boom_yaw_inertia + jib_yaw_inertia
        inertias = slew, boom.inertia + k1, jib.inertia + k2
        if self.motors is not None:
            inertias = add(inertias, self.motors)
        c, s, hb, hg = (
            k3 * (cb * cg + sb * sg),
            k3 * (sb * cg - cb * sg),
            sb * p1 + boom_h,
            sg * p2 + jib_h,
        )
        return c, s, inertias[0], hb, hg, inertias[1], inertias[2]

    def accelerations(self, pose, gravity, tau, force):
        """Return the joint accelerations under efforts tau and a force (3,) [N] on the tip."""
        slew, b2, b3 = pose.free_moments(self._moments(pose, gravity, tau, force))
        boom_acc, jib_acc = pose.solve_luff(b2, b3)
        return slew / pose.slew_inertia, boom_acc, jib_acc

    def constraint_efforts(self, pose, gravity, tau, force, qdd):
        """Return the constraint efforts of joints that stick: what friction bears.

        Arguments of `accelerations`.

        qdd are its accelerations; the numbers of joints that move mean nothing.
        """
        slew, b2, b3 = self._moments(pose, gravity, tau, force)
        return slew, b2 - pose.c * qdd[2], b3 - pose.c * qdd[1]

    def _moments(self, pose, gravity, tau, force):
        """Return the right-hand sides [N m] of slew, boom and jib.

        Arguments of `accelerations`.
        """
        boom, jib = self.boom, self.jib
        fr, ft, fz = force
        wa, wb, wg = pose.yaw_rate, pose.beta_rate, pose.gamma_rate
        u2 = add_spring(self.boom_spring, tau[1], pose.beta)
        u2, u3 = add_jib_spring(self.jib_spring, u2, tau[2], pose.beta, pose.gamma)
        slew = tau[0] + pose.tip[0] * ft + 2.0 * wa * (pose.hb * wb + pose.hg * wg)
        b2 = u2 + boom.length * (pose.cb * fz - pose.sb * fr)
        b3 = u3 + jib.length * (pose.cg * fz - pose.sg * fr)
        b2 = (
            b2
            - gravity * boom.length * pose.cb * (0.5 * boom.mass + jib.mass)
            - pose.s * wg * wg
            - pose.hb * wa * wa
        )
        b3 = (
            b3
            - gravity * jib.length * pose.cg * 0.5 * jib.mass
            + pose.s * wb * wb
            - pose.hg * wa * wa
        )
        return slew, b2, b3

    def tip_acceleration(self, pose, qdd):
        """Return (second derivative of the tip's coordinates (3,), yaw acceleration) at qdd.

        qdd are the joint accelerations.
        """
        boom, jib = self.boom.length, self.jib.length
        wb2, wg2 = pose.beta_rate * pose.beta_rate, pose.gamma_rate * pose.gamma_rate
        radial = -boom * (pose.sb * qdd[1] + pose.cb * wb2) - jib * (
            pose.sg * qdd[2] + pose.cg * wg2
        )
        vertical = boom * (pose.cb * qdd[1] - pose.sb * wb2) + jib * (
            pose.cg * qdd[2] - pose.sg * wg2
        )
        return (radial, 0.0, vertical), qdd[0]

    def tip_mobility(self, pose, n):
        """Return the tip's mobility nᵀ J Mc⁻¹ Jᵀ n [1/kg] along the unit vector n.

        It is the acceleration along n for a unit force along n.
        """
        boom = self.boom.length * (pose.cb * n[2] - pose.sb * n[0])
        jib = self.jib.length * (pose.cg * n[2] - pose.sg * n[0])
        slew, boom, jib = pose.free_moments((pose.tip[0] * n[1], boom, jib))
        boom_acc, jib_acc = pose.solve_luff(boom, jib)
        return slew * slew / pose.slew_inertia + boom * boom_acc + jib * jib_acc

    def add_base_efforts(self, tau, base, pose):
        """Return the joint efforts tau plus those of a moving base's inertial forces.

        `base` is that of `crane_sim.models.moving_base.base_kinematics_at`, in the axes of the
        support's frame; None for one at rest.
        """
        return tau if base is None else (*add(tau, imposed_efforts(base, self, pose)), *tau[3:])

    def add_wind_efforts(self, tau, flow, base, pose):
        """Return the joint efforts tau plus those of the wind on boom and jib.

        `flow` is that of `crane_sim.models.wind_load.airflow_at`, None without wind, and `base` as
        in `add_base_efforts`, both in the axes of the support's frame.
        """
        return tau if flow is None else (*add(tau, wind_moments(flow, self, base, pose)), *tau[3:])

    def add_yaw_moment(self, tau, couple):
        """Return the joint efforts tau plus those of a couple [N m] about the vertical.

        The couple is applied to the support.
        """
        return (tau[0] + couple, *tau[1:])

    def power(self, tau, pose, force):
        """Return the power [W] of joint efforts tau with a force (3,) [N] on the tip."""
        return tau[0] * pose.yaw_rate + tau[1] * pose.beta_rate + tau[2] * pose.gamma_rate

    def guard(self, best, xs):
        """Return the smallest one of `best` and of the travel limits.

        See `crane_sim.models.guards`.
        """
        for i, limits in enumerate((self.tower.limits, self.boom.limits, self.jib.limits)):
            best = travel_guard(limits, best, xs[i], encode(Guard.TRAVEL, i))
        return best

    def yaw(self, xs):
        """Return the angle [rad] of the support's frame about z."""
        return xs[0]

    def polyline(self, xs):
        """Return the support's polyline, base to tip, in its own frame: a tuple of (x, y, z)."""
        boom, jib = self.boom.length, self.jib.length
        x, z = boom * cos(xs[1]), boom * sin(xs[1])
        return (0.0, 0.0, 0.0), (x, 0.0, z), (x + jib * cos(xs[2]), 0.0, z + jib * sin(xs[2]))

    def polyline_size(self):
        """Return the number of points of the polyline."""
        return 3

    def kinetic(self, pose):
        """Return the support's kinetic energy [J], without rope and payload."""
        wa, wb, wg = pose.yaw_rate, pose.beta_rate, pose.gamma_rate
        luffing = pose.boom_inertia * wb * wb + pose.jib_inertia * wg * wg
        return 0.5 * (pose.slew_inertia * wa * wa + luffing) + pose.c * wb * wg

    def potential(self, pose, gravity):
        """Return the potential energy [J] of gravity and joint springs, without the payload.

        The rope has no part in it either.
        """
        boom, jib = self.boom, self.jib
        energy = gravity * boom.length * pose.sb * (0.5 * boom.mass + jib.mass)
        energy = energy + 0.5 * gravity * jib.mass * jib.length * pose.sg
        energy = add_spring_energy(self.boom_spring, energy, pose.beta)
        return add_jib_spring_energy(self.jib_spring, energy, pose.beta, pose.gamma)

    def base_energy(self, base, pose, gravity):
        """Return (kinetic, potential) energy [J] of the masses in the world less those in the base.

        `base` is that of `crane_sim.models.moving_base.base_state`, in the axes of the support's
        frame.
        """
        return world_energies(base, self, pose, gravity)
