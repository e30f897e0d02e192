"""Check of laws whose nominal crane has one rope and a point mass."""

from crane_sim.files.errors import SceneError
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene


def check_one_rope(law: str, nominal: Scene) -> None:
    """Raise SceneError where the nominal crane has falls, further links or a rigid-body payload; law: its name."""
    if isinstance(nominal.model, FallsCrane):  # whose joints are the load's place, and no swing angles
        line = "knows one rope and a point mass, here is falls; possible with falls: lqr, joint_trajectory"
        raise SceneError(f"control.law = {law!r}: {line}")
    if not isinstance(nominal.model, SuspendedCrane):
        return
    keys = ", ".join(getattr(nominal.file, "further_keys", ["links"]))
    raise SceneError(
        f"control.nominal: control.law = {law!r} knows one rope and a point mass, here is {keys}; leave that out "
        "there, as {links: [], payload: {mass: ..., inertia: null, attachment: null}} does"
    )
