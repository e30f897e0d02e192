"""What a control law is, and how one is found by its name.

A law is found through the entry-point group `crane_sim.laws`, so a package of your own adds one by naming a function
`build(settings, scene) -> Law` there: `settings` are the keys of the scene's `control` group beside law, period and
nominal; `scene` is the *nominal* scene, all that the law may believe. It raises ValueError for what does not fit.
"""

from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from typing import Any, Protocol, TypeVar

from pydantic import TypeAdapter, ValidationError

from crane_sim.explain import SceneError, one_line

T = TypeVar("T")
GROUP = "crane_sim.laws"


class Law(Protocol):
    """Efforts from time and joint coordinates. A NamedTuple with a registered `system.command` runs compiled."""

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the efforts (nu,) demanded at time t [s], joint positions q (nq,) and velocities v (nq,)."""
        ...


def law_names() -> list[str]:
    """Return the names of all laws that are installed."""
    return sorted({entry.name for entry in entry_points(group=GROUP)})


def make_law(name: str, settings: Mapping[str, Any], nominal: Any) -> Law:
    """Return the law called `name` for the nominal scene.

    Raises:
        SceneError: no such law, or it does not accept the settings or the scene.
    """
    found = [entry for entry in entry_points(group=GROUP) if entry.name == name]
    if not found:
        raise SceneError(f"control.law = {name!r}: no such law (known: {', '.join(law_names())})")
    build: Callable[[Mapping[str, Any], Any], Law] = found[0].load()
    try:
        return build(settings, nominal)
    except SceneError:
        raise
    except ValueError as error:
        raise SceneError(f"control: {error}") from None


def read_settings(kind: type[T], settings: Mapping[str, Any]) -> T:
    """Return the law's settings read into the NamedTuple `kind`.

    Raises:
        SceneError: a key is unknown or a value out of range.
    """
    try:
        return TypeAdapter(kind).validate_python(dict(settings))
    except ValidationError as error:
        raise SceneError(one_line(error, kind, ("control",))) from None
