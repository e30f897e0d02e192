"""A rope over n sheaves: tensions of its falls, dead end to drum, with inertia, loss, weight.

Fall k of n has the length l, as all others, the lead line is fall 0. Sheave k, between falls k - 1
and k, turns with the rim speed (n - k + 1) l', those of the lead line with n l'. The rope does not
stretch, so all follows from l.

On a sheave of rotational inertia J and radius r, T the tension on the side of the dead end and T'
on that of the drum,

    T' = f T - (1 + f) / 2 (J / r²) s l'',     s its rim speed over l',

where f is 1 without loss, 1/c while the rope is paid out and c while it is hauled in, c >= 1 the
ratio of the tensions. It is e^(μθ) of a rope that slides over a sheave that does not turn (Euler,
Eytelwein), or that of the moment μ (T + T') r_pin of a bearing under parallel falls, c = (1 + μ
r_pin / r) / (1 - μ r_pin / r), or 1/η for an efficiency η of one sheave (Feyrer, Wire Ropes, 2nd
ed., 2015, chapter 3, on rope efficiency). Without inertia the product over the sheaves gives the
efficiency of a block with n falls, (1 - η^n) / (n (1 - η)), a geometric series.

Tensions are those with which the rope lies on a sheave: ρ v² of a rope with the mass ρ per length
are left out.
"""

from math import inf
from typing import Any, NamedTuple


class SheaveLoss(NamedTuple):
    """What a rope loses on a sheave."""

    ratio: float  # -, of the tensions on both sides of a sheave, at least 1


class Layers(NamedTuple):
    """Layers of rope on a drum, the outermost one apart, (layers - 1,) arrays."""

    full: Any  # m, of rope on the drum when a layer is full
    turn: Any  # m, of the turn in which the rope climbs on it
    height: float  # m, from layer to layer


class Drum(NamedTuple):
    """The drum of a winch."""

    radius: float  # m, of the rope's centre line in the first layer
    inertia: float  # kg m², of the drum with gear and motor, about its axis
    layers: Layers | None = None

    def winding_radius(self, wound):
        """Return (radius of the rope's centre line [m], its derivative) at a length wound [m]."""
        layers, radius, slope = self.layers, self.radius, 0.0
        if layers is None:
            return radius, slope
        for i in range(len(layers.full)):
            s = min(max((wound - layers.full[i]) / layers.turn[i] + 0.5, 0.0), 1.0)
            radius += layers.height * s * s * s * (10.0 - s * (15.0 - 6.0 * s))
            slope += layers.height * 30.0 * s * s * (1.0 - s) * (1.0 - s) / layers.turn[i]
        return radius, slope


class Reeving(NamedTuple):
    """A rope between drum and dead end; what is None is not modelled."""

    falls: int
    lead_sheaves: int = 1  # between drum and falls
    sheave_mass: float = 0.0  # kg, rotational inertia of each sheave over its radius squared
    loss: SheaveLoss | None = None
    drum: Drum | None = None
    mass: float | None = None  # kg/m, of the rope
    length: float = inf  # m, of the rope on the drum and in the falls


def reeving_of(hoist: Any) -> Any:
    """Return the reeving of a hoist; None without a reeving, or without a hoist."""
    return getattr(hoist, "reeving", None)


def sheave_factor(loss, direction):
    """Return f, the ratio of tensions at a sheave without inertia, drum's side over the other's.

    It is 1 without loss.

    `direction` is 1 while the rope is paid out, -1 while it is hauled in, and between where only a
    part of the friction is used.
    """
    if loss is None:
        return 1.0
    if direction == 0.0:
        return 1.0
    return loss.ratio if direction == -1.0 else loss.ratio**-direction


def fall_difference(mass, k, falls, motion, gravity):
    """Return the tension [N] at the upper end of fall k less that at its lower end.

    `mass` is per length [kg/m], None: 0.

    Its rope moves downwards with `down` l'. It hangs vertically here, wherever the load swings.
    """
    if mass is None:
        return 0.0
    length, rate, acceleration = motion
    down = falls - k + 1 if k % 2 == 1 else k - falls
    return mass * (length * (gravity - down * acceleration) + (1 - 2 * down) * rate * rate)


def along_fall(reeving, k, tension, motion, gravity):
    """Return the tensions [N] at (lower, upper) end of fall k.

    `tension` is that at the end nearer to the dead end.
    """
    more = fall_difference(reeving.mass, k, reeving.falls, motion, gravity)
    return (tension - more, tension) if k % 2 == 0 else (tension, tension + more)


def over_sheave(reeving, factor, tension, speed, acceleration):
    """Return (tension on the drum's side of a sheave [N], its loss over l' [N]).

    `speed` is its rim speed over l'.
    """
    inertia = reeving.sheave_mass * speed * acceleration
    return factor * tension - 0.5 * (1.0 + factor) * inertia, (1.0 - factor) * (
        tension - 0.5 * inertia
    ) * speed


def follow_rope(reeving, factor, dead_end, motion, gravity):
    """Return what follows from the tension at the dead end [N].

    Args:
        reeving: the rope.
        factor: of `sheave_factor`.
        dead_end: tension there [N].
        motion: (l [m], l' [m/s], l'' [m/s²]).
        gravity: acceleration of free fall [m/s²].

    Returns:
        pull of all falls on the block, tension of the lead line, the smallest tension, all losses
        over l' [N].
    """
    n, acceleration = reeving.falls, motion[2]
    tension, pull, smallest, lost = dead_end, 0.0, dead_end, 0.0
    for k in range(n, 0, -1):
        lower, upper = along_fall(reeving, k, tension, motion, gravity)
        pull, smallest, tension = (
            pull + lower,
            min(smallest, lower, upper),
            lower if k % 2 == 0 else upper,
        )
        if k > 1:
            tension, more = over_sheave(reeving, factor, tension, n - k + 1, acceleration)
            lost += more
    for _ in range(reeving.lead_sheaves):
        tension, more = over_sheave(reeving, factor, tension, n, acceleration)
        lost += more
    return pull, tension, min(smallest, tension), lost


def fall_tension(reeving, factor, dead_end, motion, gravity, fall):
    """Return the tension [N] of a fall at its upper end, where it is highest.

    Arguments of `follow_rope`.
    """
    n, tension = reeving.falls, dead_end
    for k in range(n, fall, -1):
        lower, upper = along_fall(reeving, k, tension, motion, gravity)
        tension, _ = over_sheave(
            reeving, factor, lower if k % 2 == 0 else upper, n - k + 1, motion[2]
        )
    return along_fall(reeving, fall, tension, motion, gravity)[1]


def dead_end_of(reeving, factor, pull, motion, gravity):
    """Return the tension [N] of the dead end at which all falls pull the block with `pull` [N]."""
    alone, _, _, _ = follow_rope(reeving, factor, 1.0, (motion[0], 0.0, 0.0), 0.0)
    moved, _, _, _ = follow_rope(reeving, factor, 0.0, motion, gravity)
    return (pull - moved) / alone


def lead_at_rest(reeving, factor, pull, length, gravity):
    """Return the tension [N] of the lead line for a pull on the block [N] while nothing moves."""
    motion = length, 0.0, 0.0
    return follow_rope(
        reeving, factor, dead_end_of(reeving, factor, pull, motion, gravity), motion, gravity
    )[1]


def drum_inertia(drum, reeving, length):
    """Return (mass m [kg] at the rope, q [kg/m]) of drum and wound rope.

    m n l'' - q l'² moves them.
    """
    if drum is None:
        return 0.0, 0.0
    n = reeving.falls
    radius, slope = drum.winding_radius(reeving.length - n * length)
    mass = drum.inertia / (radius * radius)
    return mass, -mass * n * n * slope / radius


def wound_rope(mass, reeving, length):
    """Return (mass [kg], q [kg/m]) of the wound rope as `drum_inertia` does.

    `mass` is per length [kg/m], None: 0.
    """
    if mass is None:
        return 0.0, 0.0
    return mass * (reeving.length - reeving.falls * length), mass * reeving.falls * reeving.falls


def winding_inertia(reeving, length):
    """Return (mass [kg], q [kg/m]) of all that the lead line's end moves, as of `drum_inertia`."""
    (mass, q), (wound, more) = (
        drum_inertia(reeving.drum, reeving, length),
        wound_rope(reeving.mass, reeving, length),
    )
    return mass + wound, q + more


def reeved_acceleration(reeving, factor, force, length, rate, gravity):
    """Return (inverse mass [1/kg], bias [m/s²]) of l, by the pull on the block.

    Without inertia it is (-1, that pull [N]).

    Args:
        reeving: the rope.
        factor: of `sheave_factor`.
        force: of the winch on the lead line, positive pays out [N].
        length, rate: l [m] and l' [m/s].
        gravity: acceleration of free fall [m/s²].
    """
    pull, lead, _, _ = follow_rope(reeving, factor, 1.0, (length, 0.0, 0.0), 0.0)
    inert_pull, inert_lead, _, _ = follow_rope(reeving, factor, 0.0, (length, 0.0, 1.0), 0.0)
    still_pull, still_lead, _, _ = follow_rope(reeving, factor, 0.0, (length, rate, 0.0), gravity)
    (mass, q), share = winding_inertia(reeving, length), lead / pull
    inertia = reeving.falls * mass + share * inert_pull - inert_lead
    force += q * rate * rate + still_lead - share * still_pull
    return (share / inertia, force / inertia) if inertia > 0.0 else (-1.0, -force / share)


def reeving_energy(reeving, length, rate, gravity):
    """Return (kinetic, potential) energy [J] of rope, sheaves and drum.

    The potential one is the rope's, from the falls' top.
    """
    n, (mass, _) = reeving.falls, winding_inertia(reeving, length)
    # sum of the squares of rim speeds over l'
    sheaves = (n - 1) * n * (2 * n - 1) / 6 + reeving.lead_sheaves * n * n
    moved, potential = falls_energy(reeving.mass, n, length, gravity)
    return 0.5 * (n * n * mass + reeving.sheave_mass * sheaves + moved) * rate * rate, potential


def falls_energy(mass, n, length, gravity):
    """Return (mass [kg] that the rope in the falls adds to l, its potential energy [J]).

    `mass` is per length [kg/m], None: 0.
    """
    if mass is None:
        return 0.0, 0.0
    return mass * length * (n * (n * n + 2) / 3), -0.5 * n * mass * gravity * length * length
