"""The moving base of an overhead scene."""

from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.base_motions import AXES, Base, SplineBase
from crane_sim.explain import SceneError

if TYPE_CHECKING:
    from crane_sim.forms.overhead import OverheadFile

IN_PLANE = ("surge", "heave", "pitch")


def on_base(file: "OverheadFile", crane: Any) -> Any:
    """Return the crane on the scene's base: as it is where the base rests.

    Raises:
        SceneError: the base leaves the plane of a crane in the plane, or its group cannot be used.
    """
    if file.base_motion is None:
        return crane
    base = file.base_motion.base(file.seed, file.duration)
    if file.dimensions == 2:
        _check_plane(base)
        return crane._replace(base=base)
    carried, own = file.trolley.mass or 0.0, file.bridge.mass or 0.0 if file.bridge is not None else 0.0
    return crane._replace(base=base, share=carried / (carried + own) if carried + own > 0.0 else 1.0)


def _check_plane(base: Base | SplineBase) -> None:
    tables = (base.coefficients,) if isinstance(base, SplineBase) else (base.offsets, base.amplitudes)
    for i, name in enumerate(AXES):
        if name not in IN_PLANE and any(np.any(table[i]) for table in tables):
            raise SceneError(
                f"base_motion: {name} leaves the plane; it takes dimensions: 3; 2 have {', '.join(IN_PLANE)}"
            )


def check_straight(file: "OverheadFile") -> None:
    """Raise SceneError when a straight cable of several nodes hangs on a moving base."""
    if file.base_motion is not None and file.modelled == "straight" and len(file.parts.lengths) > 1:
        raise SceneError("cable.model = 'straight': needs a base that rests; with base_motion take model: rigid")
