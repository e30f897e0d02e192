"""Linear equations of a scene about a point where it can be held, for control design.

model = crane_sim.linearise("overhead_energy")
model.a, model.b, model.states, model.inputs
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from crane_sim.files.errors import SceneError, shorten
from crane_sim.scenes.scene import Scene, SceneSource, load_scene
from crane_sim.simulation.linearisation import (
    equilibrium,
    state_matrices,
    tangent_basis,
    without_dry_friction,
)

Array = npt.NDArray[np.float64]
_UNIT_VECTOR = 1e-12  # entries of a basis vector smaller than this are rounding


@dataclass(frozen=True, repr=False)
class LinearModel:
    """ẋ = A x + B w, with x the deviations of n coordinates and their rates, w those of nu efforts.

    About rest under constant efforts, with disturbances at their means and without dry friction.
    """

    a: Array  # (2 n, 2 n)
    b: Array  # (2 n, nu)
    q: Array  # (nq,) joint positions at rest
    u: Array  # (nu,) efforts that hold them
    basis: Array  # (nq, n): deviations of joint positions are basis @ x[:n]; the identity without
    # unit vectors
    states: tuple[str, ...]  # (2 n,) names: those of joints, of their rates with /s
    state_units: tuple[str, ...]  # (2 n,)
    inputs: tuple[str, ...]  # (nu,) names of actuated joints
    input_units: tuple[str, ...]  # (nu,)

    def __repr__(self) -> str:
        """Return states and inputs in one line."""
        n = len(self.states) // 2
        return f"<LinearModel of {', '.join(self.states[:n])}; inputs {', '.join(self.inputs)}>"

    @property
    def eigenvalues(self) -> npt.NDArray[np.complex128]:
        """Eigenvalues (2 n,) of A [1/s], those of the largest real part first."""
        found = np.linalg.eigvals(self.a).astype(np.complex128)
        return found[np.lexsort((found.imag, -found.real))]


def linearise(scene: SceneSource, at: Sequence[float] | None = None) -> LinearModel:
    """Return the linear equations of a scene about rest.

    Args:
        scene: a Scene, or what `load_scene` reads.
        at: positions of the actuated joints (nu,); None: the scene's target, or where it starts.

    Raises:
        SceneError: the scene is invalid, has no actuated joint, or nothing holds it at rest there.
    """
    loaded = load_scene(scene)
    if not loaded.actuated:
        raise SceneError("linearise: the scene has no actuated joint")
    smooth = replace(without_dry_friction(loaded), reference=_equilibrium_positions(loaded, at))
    q, u = equilibrium(smooth)
    a, b = state_matrices(smooth, q, u)
    basis = tangent_basis(smooth, q)
    names, units = _coordinates(loaded, basis)
    return LinearModel(
        *(a, b, q, u, basis),
        states=(*names, *(f"{name}/s" for name in names)),
        state_units=(*units, *("1/s" if unit == "1" else f"{unit}/s" for unit in units)),
        inputs=loaded.actuated,
        input_units=loaded.effort_units,
    )


def _equilibrium_positions(scene: Scene, at: Sequence[float] | None) -> tuple[float, ...]:
    """Return the positions (nu,) at which the actuated joints are held."""
    if at is None:
        own = dict(zip(scene.joint_names, scene.initial_q, strict=True))
        return scene.reference or tuple(own[name] for name in scene.actuated)
    try:
        positions = tuple(map(float, at))
    except (TypeError, ValueError, OverflowError):
        positions = ()
    if len(positions) != len(scene.actuated) or not np.all(np.isfinite(positions)):
        names = ", ".join(scene.actuated)
        raise SceneError(
            f"at = {shorten(at)}: must be a finite position for each actuated joint: {names}"
        )
    return positions


def _coordinates(scene: Scene, basis: Array) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units of the n deviations.

    They are joints, or directions along which unit vectors turn [rad].
    """
    names, units = [], []
    for column in basis.T:
        turned = np.flatnonzero(np.abs(column) > _UNIT_VECTOR)
        joint = int(turned[np.argmax(np.abs(column[turned]))])
        plain = len(turned) == 1 and scene.joint_units[joint] != "1"
        name = scene.joint_names[joint]
        names.append(name if plain else f"{name} tangent")
        units.append(scene.joint_units[joint] if plain else "rad")
    return tuple(names), tuple(units)
