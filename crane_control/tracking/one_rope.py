"""Check of laws whose nominal crane has one rope and a point mass."""

from crane_sim.files.errors import SceneError
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene


def check_one_rope(law: str, nominal: Scene) -> None:
    """Raise SceneError where the nominal crane has further links or a payload with a body; law: its name."""
    if not isinstance(nominal.model, SuspendedCrane):
        return
    keys = ", ".join(getattr(nominal.file, "further_keys", ["links"]))
    raise SceneError(
        f"control.nominal: control.law = {law!r} knows one rope and a point mass, here is {keys}; leave that out "
        "there, as {links: [], payload: {mass: ..., inertia: null, attachment: null}} does"
    )
