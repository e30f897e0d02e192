"""The law called `energy`: energy-based laws for the knuckle-boom crane and the overhead crane."""

from collections.abc import Callable, Mapping
from typing import Any

from crane_control import knuckle_energy, knuckle_load_estimation, overhead_energy
from crane_control.tracking.suspension import check_has_one_rope
from crane_sim.files.errors import SceneError
from crane_sim.laws import Law
from crane_sim.scenes.scene import Scene

BUILDERS: dict[str, Callable[[Mapping[str, Any], Scene], Law]] = {
    "knuckle": knuckle_load_estimation.build,
    "overhead": overhead_energy.build,
}
SETTINGS = {
    "control of a knuckle crane": knuckle_energy.Settings,
    "control of an overhead crane": overhead_energy.Settings,
}


def build(settings: Mapping[str, Any], nominal: Scene) -> Law:
    """Return the energy-based law for the crane of the nominal scene.

    Raises:
        SceneError: no such law exists for this crane, the law rejects the settings or the scene, or
            the scene has a path.
    """
    if nominal.crane not in BUILDERS:
        raise SceneError(
            f"control.law = 'energy': not for crane = {nominal.crane!r}; possible: {[*BUILDERS]}"
        )
    if nominal.trajectory is not None:
        raise SceneError(
            "reference.path: control.law = 'energy' follows no path, it goes to reference.q; leave "
            "the path out"
        )
    check_has_one_rope("energy", nominal)
    return BUILDERS[nominal.crane](settings, nominal)
