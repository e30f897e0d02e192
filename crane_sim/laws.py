"""Control laws: their interface, and their lookup by name.

A law is found through the entry-point group `crane_sim.laws`, so a package of your own adds one by
naming a function `build(settings, scene) -> Law` there: `settings` are the keys of the scene's
`control` group beside law, period and nominal; `scene` is the *nominal* scene, all that the law may
depend on. It raises ValueError for what does not fit. A law of your own in a file needs no package:
`control.law: FILE.py:FUNCTION`.
A module that has `build_many` designs its law for many scenes at once. One that has `SETTINGS`, the
NamedTuples that its settings are read into by the group that has them, is described in the page of
the scene format.
"""

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from inspect import cleandoc, signature
from math import isfinite
from numbers import Real
from typing import Any, NamedTuple, Protocol, TypeVar, cast

from pydantic import ValidationError

from crane_sim.files.errors import (
    PATH,
    SceneError,
    foreign_path,
    join_lines,
    no_group,
    one_line,
    shorten,
    unknown_key,
)
from crane_sim.files.extensions import find_extensions
from crane_sim.files.functions import load_function
from crane_sim.files.types import type_adapter

T = TypeVar("T")
GROUP = "crane_sim.laws"
COMMON = ("law", "period", "nominal")
"""Keys of `control` that are no settings of a law."""
SHARED = ("servo", "tracker_rate", "vision")
"""Settings of measurement and drive that several laws share: another law that has them keeps
them."""


class ForeignSetting(SceneError):
    """A setting that a law does not have."""

    def __init__(self, key: str, known: Sequence[str], law: str = "") -> None:
        """Name the key, the keys that law `law` has, and which one was perhaps meant."""
        super().__init__(
            f"control: {unknown_key(key, known, of=f'for law {law!r}' if law else '')}"
        )
        self.key, self.known = key, known


class Law(Protocol):
    """Commands from time and joint coordinates; a law may be compiled.

    A NamedTuple with a registered `system.command` runs compiled.

    They are efforts unless the law's class has an attribute `commands`: "velocity" or "position",
    or one of these and "effort" for each actuated joint, for drives that are commanded so
    (`actuators.JOINT.drive`).
    """

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return effort commands (nu,) at t [s], joint positions q and velocities v (nq,)."""
        ...


class EnergyShaping(Protocol):
    """A law that shapes an energy, which its recordings and `Rollout.lyapunov` show."""

    def lyapunov(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, float]:
        """Return (V [J], dV/dt [W]) at time t [s], joint positions q (nq,) and velocities v (nq,).

        dV/dt is that of the law's nominal crane, under commands that are evaluated continuously;
        motions, forces and limits that `control.nominal` leaves out of it do not count.
        """
        ...


class AboutLaw(NamedTuple):
    """Description of a law, from its module."""

    about: str  # the first paragraph of its docstring
    settings: Mapping[str, Any]  # its SETTINGS: NamedTuples of keys by the group that has them;
    # empty where it has none


def law_names() -> list[str]:
    """Return the names of all laws that are installed."""
    return sorted({entry.name for entry in find_extensions(GROUP)})


def law_of(name: str) -> AboutLaw:
    """Return the description of an installed law, from its module."""
    entry = next(entry for entry in find_extensions(GROUP) if entry.name == name)
    module = import_module(entry.module)
    about = cleandoc(module.__doc__ or "").partition("\n\n")[0]
    return AboutLaw(about, getattr(module, "SETTINGS", {}))


def has_setting(name: str, key: str) -> bool:
    """Return whether a law has a setting, as its module's SETTINGS say.

    One without SETTINGS, or built by a function of one's own from (settings, scene), has any.
    """
    if is_own(name):
        return _is_builder(load_function("control.law", name))
    if name not in law_names():
        return False
    settings = law_of(name).settings
    if not settings:
        return True
    return f"control.{key}" in settings or key in getattr(settings.get("control"), "_fields", ())


def switch_law(
    document: dict[str, Any], changes: Mapping[str, Any]
) -> tuple[dict[str, Any], list[str]]:
    """Return (a scene's document without the settings of its law, their keys) for another law.

    `changes` are by key; where they select no other law, the document stays as it is. Settings
    that laws share stay where the other law has them.
    """
    control, law = document.get("control"), changes.get("control.law")
    if not isinstance(control, dict) or law is None or law == control.get("law"):
        return document, []
    kept = [key for key in SHARED if key in control and has_setting(str(law), key)]
    ignored = [key for key in control if key not in (*COMMON, *kept)]
    return document | {
        "control": {key: control[key] for key in control if key not in ignored}
    }, ignored


def make_law(name: str, settings: Mapping[str, Any], nominal: Any) -> Law:
    """Return the law called `name` for the nominal scene.

    Raises:
        SceneError: no such law, or it does not accept the settings or the scene.
    """
    with _errors_in_one_line(name):
        return (
            _make_own_law(name, settings, nominal)
            if is_own(name)
            else _find_builder(name)(settings, nominal)
        )


def is_own(name: str) -> bool:
    """Return whether a law is named by its code, FILE.py:FUNCTION or MODULE:FUNCTION."""
    return ":" in name


def make_laws(
    name: str, settings: Sequence[Mapping[str, Any]], nominals: Sequence[Any]
) -> list["Law | SceneError"]:
    """Return the law called `name` for each nominal scene, or the error that `make_law` raises.

    A law whose module has `build_many`, a function of (list of settings, list of scenes) that
    returns laws and errors, is designed for all scenes at once; where that fails, for each alone,
    so that an error is of one scene.
    """
    module = next((entry.module for entry in find_extensions(GROUP) if entry.name == name), None)
    if module is not None and hasattr(import_module(module), "build_many"):
        with suppress(SceneError), _errors_in_one_line(name):
            return import_module(module).build_many(settings, nominals)
    laws: list[Law | SceneError] = []
    for own, nominal in zip(settings, nominals, strict=True):
        try:
            laws.append(make_law(name, own, nominal))
        except SceneError as error:
            laws.append(error)
    return laws


@contextmanager
def _errors_in_one_line(name: str) -> Iterator[None]:
    """Raise a SceneError in place of any error that building the law called `name` raises."""
    try:
        yield
    except ForeignSetting as error:
        raise ForeignSetting(error.key, error.known, name) from None
    except SceneError:
        raise
    except ValueError as error:
        raise SceneError(f"control: {join_lines(error)}") from None
    except Exception as error:
        # of an external package: whatever it is, the user gets a one-line error
        what = f"{type(error).__name__}: {join_lines(error)}"
        raise SceneError(f"control.law = {shorten(name, PATH)}: cannot be built: {what}") from error


def _find_builder(name: str) -> Callable[[Mapping[str, Any], Any], Law]:
    """Return the function that builds an installed law.

    Raises SceneError where there is none of this name.
    """
    entries = [entry for entry in find_extensions(GROUP) if entry.name == name]
    if not entries:
        known = f"known: {', '.join(law_names())}; or FILE.py:FUNCTION, MODULE:FUNCTION"
        raise SceneError(f"control.law = {shorten(name)}: no such law ({known})")
    return entries[0].load()


def _is_builder(function: Any) -> bool:
    return len(signature(function).parameters) == len(("settings", "scene"))


def _make_own_law(name: str, settings: Mapping[str, Any], nominal: Any) -> Law:
    """Return the law FILE.py:FUNCTION or MODULE:FUNCTION.

    It is a function of (t, q, v), or is built by one of (settings, scene).
    """
    found: Any = load_function("control.law", name)
    if _is_builder(found):
        law = found(settings, nominal)
        if callable(law):
            return cast(Law, law)
        line = (
            "a function of (settings, scene) must return a law, a function of (t, q, v); it "
            "returned"
        )
        raise SceneError(f"control.law = {shorten(name, PATH)}: {line} {shorten(law)}")
    if settings:
        raise ForeignSetting(next(iter(settings)), (), name)
    return found


def check_commands(name: str, law: Law, actuated: Sequence[str], drives: Sequence[str]) -> None:
    """Raise SceneError where a law's commands (nu,) are not what the joints' drives take.

    The joints are the actuated ones.
    """
    given = getattr(law, "commands", "effort")
    kinds = [given] * len(drives) if isinstance(given, str) else given
    if not isinstance(kinds, Sequence) or len(kinds) != len(drives):
        line = (
            f"control.law = {shorten(name, PATH)}: commands = {shorten(given)}: must be effort, "
            "velocity or position"
        )
        raise SceneError(f"{line}, or one of these for each of {', '.join(actuated)}")
    for joint, kind, drive in zip(actuated, kinds, drives, strict=True):
        if kind != drive:
            line = f"control.law = {shorten(name, PATH)}: commands {kind} of the {joint}"
            raise SceneError(f"{line}, whose drive takes {drive} (actuators.{joint}.drive)")


class OuterLoop(Protocol):
    """The outer loop of a law, which computes the inner loop's setpoints less often.

    It may run in another process.
    """

    @property
    def interval(self) -> float:
        """Sampling interval [s]."""
        ...

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the n coordinates of its setpoint."""
        ...

    @property
    def demand(self) -> tuple[float, ...]:
        """The inner loop's setpoint (3 n,): positions, velocities, accelerations."""
        ...

    def due(self, t: float) -> bool:
        """Return whether it is sampled at the state at time t [s], which is new to the law."""
        ...

    def take(self, demand: tuple[float, ...]) -> None:
        """Hold a setpoint that another process has computed."""
        ...


def outer_loop_of(law: Any) -> OuterLoop | None:
    """Return the outer loop of a law that can be two processes; None of others.

    It is the law's attribute `outer_loop`.
    """
    return getattr(law, _usable_name(law, "outer_loop", "slow_half"), None)


def inner_loop_of(law: Any) -> Any:
    """Return the law whose outer loop only holds received setpoints; others as they are."""
    return (
        law
        if outer_loop_of(law) is None
        else getattr(law, _usable_name(law, "inner_loop", "fast_half"))()
    )


def _usable_name(law: Any, name: str, deprecated: str) -> str:
    """Return the name of a law's attribute, or the deprecated one of a law that has only this.

    The deprecated one gives a warning.
    """
    if hasattr(law, name) or not hasattr(law, deprecated):
        return name
    warnings.warn(
        f"{type(law).__name__}.{deprecated} is now called {name}", DeprecationWarning, stacklevel=3
    )
    return deprecated


class LawError(RuntimeError):
    """A law raised an exception, or did not return a vector of efforts; the message is one line."""


def evaluate_law(
    law: Law, t: float, q: tuple[float, ...], v: tuple[float, ...], nu: int
) -> tuple[float, ...]:
    """Return the effort commands (nu,) of the law; arguments of `Law`.

    Raises:
        LawError: the law raised, or did not return nu finite numbers.
    """
    try:
        answer = law(t, q, v)
        if type(answer) is not tuple and isinstance(
            answer, Iterator
        ):  # its items are the law's own code
            answer = tuple(answer)
    except Exception as error:
        raise LawError(
            f"the law failed at t = {t:g} s: {type(error).__name__}: {join_lines(error)}"
        ) from error
    try:
        efforts = tuple(map(float, answer))
    except (TypeError, ValueError, OverflowError):
        line = f"the law returned {shorten(answer)} at t = {t:g} s, not {how_many(nu)}"
        raise LawError(
            f"{line}: return (x,), a tuple" if isinstance(answer, Real) else line
        ) from None
    if len(efforts) != nu:
        raise LawError(
            f"the law gave {len(efforts)} efforts at t = {t:g} s, {nu} joints are actuated"
        )
    if not all(map(isfinite, efforts)):
        raise LawError(f"the law gave efforts that are not finite at t = {t:g} s: {list(efforts)}")
    return efforts


def how_many(nu: int) -> str:
    """Return the number of efforts in words."""
    return "one effort" if nu == 1 else f"{nu} efforts"


def with_initial_state(law: Any) -> Any:
    """Return a law with its initial state, by its method of this name; a stateless one as it is."""
    reset = getattr(law, _usable_name(law, "with_initial_state", "fresh"), None)
    return law if reset is None else reset()


class RemainingSettings(dict[str, Any]):
    """Settings of a law that remain after some groups were read."""

    read_groups: tuple[str, ...] = ()


def read_group(
    kind: type[T], settings: Mapping[str, Any], group: str
) -> tuple[T, RemainingSettings]:
    """Return (group of the law's settings as a NamedTuple `kind`, the settings without it).

    Raises:
        SceneError: the group is none, or a key in it is unknown or a value out of range.
    """
    remaining = RemainingSettings({key: value for key, value in settings.items() if key != group})
    remaining.read_groups = (*getattr(settings, "read_groups", ()), group)
    return read_settings(kind, settings.get(group, {}), (group,)), remaining


def read_settings(kind: type[T], settings: Any, group: tuple[str, ...] = ()) -> T:
    """Return the law's settings, or those of a group, as a NamedTuple `kind`.

    A group is one within `control`.

    Raises:
        SceneError: the group is none, or a key in it is unknown or a value out of range.
    """
    names: tuple[str, ...] = getattr(kind, "_fields", ())
    if not isinstance(settings, Mapping):
        raise SceneError(
            f"{'.'.join(('control', *group))} = {shorten(settings)}: {no_group(names)}"
        )
    try:
        return type_adapter(kind).validate_python(dict(settings))
    except ValidationError as error:
        path = foreign_path(error)
        if len(path) != 1 or group:
            raise SceneError(one_line(error, kind, ("control", *group))) from None
        raise ForeignSetting(path[0], (*names, *getattr(settings, "read_groups", ()))) from None
