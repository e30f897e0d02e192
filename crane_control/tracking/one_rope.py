"""Check of laws that support only a nominal crane with one rope and a point mass."""

from crane_sim.files.errors import SceneError
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene


def check_has_one_rope(law: str, nominal: Scene) -> None:
    """Raise SceneError where the nominal crane has falls, further links or a rigid-body payload; law: its name."""
    if isinstance(nominal.model, FallsCrane):  # its joints are the position of the load, not swing angles
        line = "supports only one rope and a point mass; the scene has falls, possible with them: lqr, joint_trajectory"
        raise SceneError(f"control.law = {law!r}: {line}")
    if not isinstance(nominal.model, SuspendedCrane):
        return
    keys = ", ".join(getattr(nominal.file, "beyond_one_rope", ["links"]))
    raise SceneError(
        f"control.nominal: law {law!r} supports only one rope and a point mass; the nominal scene has {keys}; "
        "leave that out there, as {links: [], payload: {mass: ..., inertia: null, attachment: null}} does"
    )
