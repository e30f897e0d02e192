"""The springs of an overhead scene with an elastic cable."""

from typing import TYPE_CHECKING

import numpy as np

from crane_sim.explain import SceneError
from crane_sim.forms.overhead_start import filled
from crane_sim.overhead.elastic import Springs
from crane_sim.overhead.hoists import Hoist, MasslessHoist

if TYPE_CHECKING:
    from crane_sim.forms.overhead import OverheadFile

_OWN = ("stiffness", "damping", "tension_only")  # keys that only an elastic cable has


def springs_of(file: "OverheadFile", hoist: Hoist | None) -> Springs:
    """Return the links of an elastic cable.

    Raises:
        SceneError: what it needs is missing, or there is something that it cannot have.
    """
    group, parts = file.cable, file.parts
    n = len(parts.lengths)
    if group.stiffness is None:
        raise SceneError("cable.stiffness = None: an elastic cable has one, in N/m, for each link or for all")
    if n != (group.links or max(len(group.lengths), len(group.node_masses))):
        raise SceneError("cable.node_masses: every node of an elastic cable has a mass greater than 0")
    for name, given in (("joints", file.joints or group.joints), ("cable.inertia", group.inertia)):
        if given is not None:
            raise SceneError(f"{name}: belongs to rigid links; an elastic cable neither bends nor turns as rods")
    if group.slack == "stop":
        raise SceneError("cable.slack = 'stop': belongs to rigid links; an elastic cable takes tension_only")
    if isinstance(hoist, MasslessHoist):
        raise SceneError("hoist.inertia = 0: the massless winch needs rigid links; give the hoist an inertia")
    stiffness, damping = filled(group.stiffness, n, "cable.stiffness"), group.damping or (0.0,)
    damping = filled(damping, n, "cable.damping")
    masses, lengths = np.array(parts.masses), np.array(parts.lengths)
    return Springs(masses, lengths, np.array(stiffness), np.array(damping), float(group.tension_only))


def refuse_springs(file: "OverheadFile") -> None:
    """Raise SceneError when a cable that is not elastic has keys of an elastic one."""
    for name in _OWN:
        if getattr(file.cable, name):
            raise SceneError(f"cable.{name}: belongs to cable.model: elastic, here it is {file.modelled!r}")
