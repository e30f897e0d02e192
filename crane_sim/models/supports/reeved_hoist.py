"""A winch that drives a rope over sheaves: response of the falls' length, friction, and outputs.

The mode is that of dry friction (`friction`): 0 while the falls keep their length, else the
direction of l'. They stick while what the winch pulls lies between the lead line's tensions of
paying out and of hauling in, with the static friction of the winch itself on either side.
"""

from typing import Any, NamedTuple

from crane_sim.models.supports.friction import Friction, friction_effort
from crane_sim.models.supports.reeving import (
    Reeving,
    dead_end_of,
    fall_tension,
    follow_rope,
    lead_at_rest,
    reeved_acceleration,
    reeving_energy,
    reeving_of,
    sheave_factor,
    winding_inertia,
)

HALVINGS = 50  # of the part of the friction that is in use at rest


class Torque(NamedTuple):
    """The presence of a drive by the drum's torque."""


class ReevedHoist(NamedTuple):
    """A winch that takes a force on the falls' length, or its drum's torque; positive pays out.

    Its methods are those of the hoists in `hoist`.
    """

    reeving: Reeving
    friction: Friction | None = None  # N, of the winch, in terms of the length
    torque: Torque | None = None

    def modes(self) -> int:
        """Return one where winch or sheaves have friction."""
        return 0 if self.friction is None and self.reeving.loss is None else 1

    def lead_force(self, tau: Any, length: Any) -> Any:
        """Return the winch's force [N] on the lead line under all efforts, positive pays out."""
        if self.torque is None:
            return tau[-1] / self.reeving.falls
        return tau[-1] / radius_of_drum(self.reeving, length)

    def response(self, t: Any, tau: Any, mode: Any, motion: Any, gravity: Any) -> tuple[Any, Any]:
        """Return (inverse mass [1/kg], bias acceleration [m/s²]) of the length.

        Without inertia it is (-1, tension [N]).
        """
        if self.modes() > 0 and mode == 0.0:
            return 0.0, 0.0
        length, rate = motion[0], motion[1]
        force = self.lead_force(tau, length)
        force += friction_effort(self.friction, rate, mode) / self.reeving.falls
        return reeved_acceleration(
            self.reeving, sheave_factor(self.reeving.loss, mode), force, length, rate, gravity
        )

    def power(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the power [W] of the winch, less what friction and sheaves take."""
        reeving, factor = self.reeving, sheave_factor(self.reeving.loss, mode)
        dead_end = dead_end_of(reeving, factor, pull, motion, gravity)
        _, _, _, lost = follow_rope(reeving, factor, dead_end, motion, gravity)
        effort = reeving.falls * self.lead_force(tau, motion[0])
        return (effort + friction_effort(self.friction, motion[1], mode) - lost) * motion[1]

    def slip_excess(self, tau: Any, pull: Any, length: Any, gravity: Any) -> tuple[Any, Any]:
        """Return the forces [N] that would (pay out, haul in) beyond what friction holds, at rest.

        They act on the lead line.
        """
        reeving, force = self.reeving, self.lead_force(tau, length)
        static = 0.0 if self.friction is None else self.friction.static / reeving.falls
        low = lead_at_rest(reeving, sheave_factor(reeving.loss, 1.0), pull, length, gravity)
        high = lead_at_rest(reeving, sheave_factor(reeving.loss, -1.0), pull, length, gravity)
        return force + low - static, -force - high - static

    def winch_guard(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the guard of its stick and slip under a pull [N] on the length."""
        if mode != 0.0:
            return mode * motion[1]
        out, in_ = self.slip_excess(tau, pull, motion[0], gravity)
        return -max(out, in_)

    def stopped_mode(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return its mode at rest after its guard has failed in `mode`."""
        out, in_ = self.slip_excess(tau, pull, motion[0], gravity)
        if mode != 0.0 and max(out, in_) <= 0.0:
            return 0.0
        return 1.0 if out > in_ else -1.0

    def slip_direction(self, rate: Any, mode: Any) -> Any:
        """Return the direction of `sheave_factor` in which its rope moves."""
        return mode

    def rope_direction(self, tau: Any, mode: Any, motion: Any, pull: Any, gravity: Any) -> Any:
        """Return the `sheave_factor` direction by which the falls' tensions follow the pull.

        A rope that sticks uses the same part of the friction on every sheave, between -1 and 1.
        """
        if mode != 0.0 or self.modes() == 0:
            return mode
        force, low, high = self.lead_force(tau, motion[0]), -1.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            lead = lead_at_rest(
                self.reeving, sheave_factor(self.reeving.loss, middle), pull, motion[0], gravity
            )
            low, high = (middle, high) if lead + force > 0.0 else (low, middle)
        return 0.5 * (low + high)


def winch_energy(hoist, length, rate, gravity):
    """Return (kinetic, potential) energy [J] of rope, sheaves and drum.

    The potential one is the rope's, from the falls' top.
    """
    if not isinstance(hoist, ReevedHoist):
        return 0.0, 0.0
    return reeving_energy(hoist.reeving, length, rate, gravity)


def radius_of_drum(reeving, length):
    """Return the radius [m] of the rope's centre line where it leaves the drum, 0 without one."""
    return (
        0.0
        if reeving.drum is None
        else reeving.drum.winding_radius(reeving.length - reeving.falls * length)[0]
    )


def drum_torque(reeving, lead, motion):
    """Return the torque [N m] on a reeving's drum, positive pays out; 0 without a drum.

    It is that under the tension `lead` [N] of the lead line.
    """
    mass, q = winding_inertia(reeving, motion[0])
    force = mass * reeving.falls * motion[2] - q * motion[1] * motion[1] - lead
    return force * radius_of_drum(reeving, motion[0])


def hoist_falls(hoist):
    """Return the number of falls of a hoist's reeving, 0 without one."""
    reeving = reeving_of(hoist)
    return 0 if reeving is None else reeving.falls


def write_fall_tensions(hoist, tau, mode, motion, pull, gravity, row):
    """Write the result of `system.fall_tensions` into a row (falls + 2,); none without a reeving.

    The other arguments are those of `ReevedHoist.power`.
    """
    reeving = reeving_of(hoist)
    if reeving is None:
        return
    factor = sheave_factor(reeving.loss, hoist.rope_direction(tau, mode, motion, pull, gravity))
    dead_end = dead_end_of(reeving, factor, pull, motion, gravity)
    _, lead, _, _ = follow_rope(reeving, factor, dead_end, motion, gravity)
    row[0] = lead
    for k in range(1, reeving.falls + 1):
        row[k] = fall_tension(reeving, factor, dead_end, motion, gravity, k)
    row[reeving.falls + 1] = drum_torque(reeving, lead, motion)
