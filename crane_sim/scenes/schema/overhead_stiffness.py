"""The fastest small oscillation of an overhead crane: what a fixed step has to bear."""

import numpy as np
import numpy.typing as npt

from crane_sim.models.stops import MIN_LENGTH
from crane_sim.models.supports.friction import steepest_slope
from crane_sim.scenes.schema.friction_checks import friction_rate
from crane_sim.scenes.schema.motors import reflected_inertia
from crane_sim.scenes.schema.oscillation import row_frequency
from crane_sim.scenes.schema.overhead_cable import OverheadCrane, fill_list
from crane_sim.trajectories.profiles import Shape

Array = npt.NDArray[np.float64]
LEAST_MASS = 1e-10  # of the payload's mass: that of a trolley or bridge without any


def stiffest(file: OverheadCrane) -> float:
    """Return the largest frequency or decay rate [rad/s] of the hanging cable, by any payload.

    Or the largest initial rate, where that is larger.
    """
    *nodes, payload = file.parts.masses
    payloads = (payload, *(event.set.payload.mass for event in file.events))
    return max(_stiffest_with(file, np.array([*nodes, mass], dtype=float)) for mass in payloads)


def _stiffest_with(file: OverheadCrane, masses: Array) -> float:
    """Return what `stiffest` does, of the cable with nodes of these masses (N,) [kg]."""
    gravity, lengths = float(file.gravity), np.array(file.parts.lengths, dtype=float)
    lengths[0] = _shortest_first(file)
    rates = max((float(np.linalg.norm(rate)) for rate in file.parts.rates), default=0.0)
    if file.cable_model == "straight":
        reach = np.cumsum(lengths)
        swing = float(np.sqrt(gravity * (masses @ reach) / (masses @ reach**2)))
        return max(rates, swing, _friction_rate(file))
    tension = gravity * np.cumsum(masses[::-1])[::-1]
    across = tension / lengths
    frequencies = [rates, _largest(file, masses, across), _friction_rate(file)]
    if file.cable_model == "elastic" and file.cable.stiffness is not None:
        stiffness = np.array(fill_list(file.cable.stiffness, len(lengths), "cable.stiffness"))
        damping = np.array(fill_list(file.cable.damping or (0.0,), len(lengths), "cable.damping"))
        frequencies += [_largest(file, masses, stiffness), _largest(file, masses, damping) ** 2]
    joints = file.joints or file.cable.joints
    if joints is not None:  # a bound: at most four times two neighbours' moments act on a node
        turned = np.min(masses) * np.min(lengths) ** 2
        frequencies.append(
            float(np.hypot(frequencies[1], 4.0 * np.sqrt(max(joints.stiffness) / turned)))
        )
        frequencies.append(float(16.0 * max(joints.damping) / turned))
    return max(frequencies)


def _shortest_first(file: OverheadCrane) -> float:
    """Return the least length [m] of the first link: of its profile in the run, or its start."""
    first, hoist = file.parts.lengths[0], file.hoist
    if hoist is None:
        return first
    if hoist.profile is None:
        return file.initial.length or first
    return max(
        _least(hoist.profile, file.duration), hoist.limits[0] if hoist.limits else 0.0, MIN_LENGTH
    )


def _friction_rate(file: OverheadCrane) -> float:
    """Return the largest rate [1/s] of a joint's viscous friction or falling Stribeck curve."""
    friction, carried, rate = file.friction, file.trolley.mass or 0.0, 0.0
    if friction is not None and friction.trolley is not None:
        rate = steepest_slope(friction.trolley) / carried
    if friction is not None and friction.bridge is not None and file.bridge is not None:
        rate = max(rate, steepest_slope(friction.bridge) / ((file.bridge.mass or 0.0) + carried))
    if (
        friction is not None
        and friction.hoist is not None
        and file.hoist is not None
        and file.hoist.inertia
    ):
        rate = max(rate, steepest_slope(friction.hoist) / file.hoist.inertia)
    return max(rate, _bristle_rate(file))


def _bristle_rate(file: OverheadCrane) -> float:
    """Return the largest frequency or rate [1/s] of axes on their bristles."""
    trolley, own = (
        file.trolley.mass or 0.0,
        (file.bridge.mass if file.bridge is not None else None) or 0.0,
    )
    masses = {"trolley": trolley, "bridge": trolley + own}
    return max(
        friction_rate(getattr(file.lugre, name, None), mass) for name, mass in masses.items()
    )


def _least(shape: Shape, duration: float) -> float:
    """Return a motion's least value in a run, of a thousand instants and where pieces meet."""
    motion = shape.motion()
    ends = motion.starts[(motion.starts > 0.0) & (motion.starts < duration)]
    t = np.concatenate([np.linspace(0.0, duration, 1001), ends])
    piece = np.maximum(0, np.searchsorted(motion.starts, t, side="right") - 1)
    with np.errstate(all="ignore"):
        values = np.polynomial.polynomial.polyval(
            t - motion.starts[piece], motion.coefficients[piece].T, tensor=False
        )
    return float(np.min(values + motion.amplitude * np.sin(motion.frequency * t + motion.phase)))


def bending_error(file: OverheadCrane) -> float:
    """Return about how far [m] the payload is off because a straight cable cannot bend.

    The nodes above it, m_c kg in all, bend the cable by their share of its tension, and push the
    payload by their share of its mass: (m_c / m_p)² of the way that it swings, more below a light
    trolley, and growing with the phase. The factors fit chains of ten links, 2 to 10 m long, from
    0.1 to 1.2 rad (true errors were 0.2 to 0.8 of the estimate).
    """
    masses, length = np.array(file.parts.masses), float(np.sum(file.parts.lengths))
    swung = 1.0 + masses[-1] / _lightest_axis(file)
    frequency = float(np.sqrt(file.gravity / length * swung))
    rate = abs(float(file.parts.rates[0]))
    angle = abs(float(file.parts.turns[0])) + (rate / frequency if frequency else 0.0)
    share = float(np.sum(masses[:-1]) / masses[-1])
    return (
        0.3
        * swung
        * share**2
        * length
        * min(angle, np.pi)
        * (1.0 + frequency * file.duration / 20.0)
    )


def driven_masses(file: OverheadCrane) -> dict[str, float]:
    """Return the masses [kg] that forces on trolley and bridge move, beside the cable."""
    carried, masses = file.trolley.mass or 0.0, dict[str, float]()
    if file.trolley.drive == "force":
        masses["trolley"] = carried
    if file.bridge is not None and file.bridge.drive == "force":
        masses["bridge"] = (file.bridge.mass or 0.0) + carried
    return masses


def massless_axes(file: OverheadCrane) -> list[str]:
    """Return which axes are driven by a force although neither they nor their motors have mass."""
    return [
        name
        for name, mass in driven_masses(file).items()
        if not mass + reflected_inertia(file, name) > 0.0
    ]


def axis_mass(file: OverheadCrane, name: str) -> float:
    """Return the mass [kg] of a force-driven axis in the equations, which is not 0."""
    mass = driven_masses(file)[name]
    return mass if mass > 0.0 else LEAST_MASS * file.parts.masses[-1]


def _lightest_axis(file: OverheadCrane) -> float:
    """Return the least mass [kg] that the cable can move along an axis; infinite without any."""
    return min([np.inf, *(axis_mass(file, name) for name in driven_masses(file))])


def _largest(file: OverheadCrane, masses: Array, springs: Array) -> float:
    """Return the largest frequency of trolley and nodes joined by `springs` (N,) [N/m]."""
    return row_frequency(springs, 1.0 / np.array([_lightest_axis(file), *masses], dtype=float))
