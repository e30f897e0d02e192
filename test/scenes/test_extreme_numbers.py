"""Numbers for which a crane's equations cannot be evaluated: refused in a line that names one."""

from typing import Any

import pytest

from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene, load_scenes

HIGH, LOW = 1e200, 1e-200  # the square of neither is a number of the machine other than 0
CASES: dict[str, tuple[str, str, float]] = {
    "mass matrix": ("knuckle_setpoint", "boom.length", HIGH),
    "balance of a jib": ("tower_flexible_jib", "flexibility.jib.centre", HIGH),
    "frequency of a jib": ("tower_flexible_jib", "flexibility.jib.centre", LOW),
    "motion of a hoist": ("overhead_hoist", "hoist.profile.duration", HIGH),
    "inertia of sheaves": ("reeved_twelve_falls", "rope.reeving.sheaves.radius", LOW),
    "difference of two loads": ("spreader_pick_up", "events.0.set.payload.mass", 1e308),
}


@pytest.mark.filterwarnings("ignore:.*encountered:RuntimeWarning")  # NumPy's, of the overflow
@pytest.mark.parametrize(("scene", "key", "value"), CASES.values(), ids=CASES)
def test_numbers_that_overflow_are_named(scene: str, key: str, value: float) -> None:
    """Errors in a schema's equations name the number, also among many scenes.

    They are overflow, division by zero and singular matrices.
    """
    with pytest.raises(SceneError) as caught:
        load_scene(scene, {key: value})
    assert f"{key} = {value:g}: the equations cannot be evaluated (" in str(caught.value)
    (refused,) = load_scenes(scene, [{key: value}])
    assert isinstance(refused, SceneError)


@pytest.mark.parametrize(
    "modes", [{"vertical": {"stiffness": 1e8, "deflection": 0.0}}, {"vertical": {"stiffness": 1e8}}]
)
@pytest.mark.parametrize("limits", [None, [36.0, 52.0]])
def test_a_boom_that_bends_has_inertia_at_its_shortest(modes: Any, limits: Any) -> None:
    """A point mass that can telescope to a bending boom's foot pin is refused without inertia."""
    shortest = {"initial.q.2": 36.0 if limits is None else 40.0, "reference": None, "control": None}
    changes = shortest | {
        "flexibility": modes,
        "telescope": {"mass": 8e3, "centre": 36.0, "inertia": 0.0},
    }
    changes["telescope.limits"] = limits
    with pytest.raises(SceneError, match="telescope.inertia = 0: must be greater than 0"):
        load_scene("mobile_lift", changes)
    load_scene("mobile_lift", changes | {"telescope.inertia": 6e5})
