"""A scene: the crane, its inputs, duration and integration method."""

import copy
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import yaml

from crane_sim import system
from crane_sim.files.document import nominal, plain_copy, read, with_values
from crane_sim.files.errors import PATH, SceneError, one_word, shorten
from crane_sim.files.output import write_text
from crane_sim.hardware.instruments import Instruments
from crane_sim.laws import Law, check_commands, is_own, make_laws, switch_law
from crane_sim.scenes.extreme_numbers import refuse_extreme_numbers
from crane_sim.scenes.hardware_settings import (
    CLOSE,
    commands_of,
    equipment_of,
    stateful_joints,
    varies_within_period,
)
from crane_sim.scenes.instrument_settings import instruments_of
from crane_sim.scenes.schema.integrator import check_fit, choose_method
from crane_sim.scenes.schema.limits import TravelLimits
from crane_sim.scenes.schema.reference import resolve_target
from crane_sim.scenes.schema.scene_file import Assembly, SceneFile
from crane_sim.scenes.validation import read_file
from crane_sim.trajectories.breakpoints import with_breakpoints

OF_CRANE = (
    *("joint_names", "joint_units", "actuated", "effort_units"),
    *("limits", "initial_q", "initial_v", "trajectory"),
)
"""Fields of a scene that are those of its crane."""
MAX_STEPS = 1e8  # control periods in a run
DEFAULT_PERIOD = 0.01  # s, between published states, unless the law has a period


@dataclass(frozen=True, repr=False)
class Scene:
    """A checked scene; joint coordinates are in the order of joint_names, actuated ones first."""

    name: str  # of its file
    crane: str  # the kind of crane: knuckle, tower, overhead, ...
    model: Any = field(compare=False)  # parameters, whose type chooses the equations
    initial_q: tuple[float, ...]  # (nq,)
    initial_v: tuple[float, ...]  # (nq,)
    duration: float  # s
    period: float  # s, between published states, and between commands when sampled
    method: Any  # settings of the integrator
    law: Law | None = field(compare=False)  # a callable(t, q, v), see `crane_sim.laws`; None
    # without one
    law_name: str | None  # None without a law
    sampled: bool  # drives are commanded once a period; otherwise the equations evaluate `source`,
    # except for `held`
    source: Any = field(compare=False)  # open-loop Inputs or a continuous law; None when sampled
    reference: tuple[float, ...] | None  # (nu,)
    trajectory: Any = field(compare=False)  # compiled `trajectories.trajectory.Trajectory`, None
    # without one
    seed: int  # of everything random
    description: str  # in plain words
    joint_names: tuple[str, ...]  # (nq,)
    actuated: tuple[str, ...]  # joints that take commands (nu,)
    joint_units: tuple[str, ...]  # (nq,)
    effort_units: tuple[str, ...]  # (nu,)
    limits: tuple[TravelLimits, ...]  # travel limits of the joints that have some
    notes: Mapping[str, Any]  # automatic settings and warnings, entries of the summary
    document: Mapping[str, Any]  # the file as it was read, with all changes
    file: SceneFile = field(compare=False)  # as it was checked, defaults included and uncertain
    # parameters drawn
    hardware: Any = field(default=None, compare=False)  # `hardware.settings.HardwareConfig`; None
    # where all is ideal
    instruments: Instruments | None = None  # camera and motion reference unit; None without

    @cached_property
    def period_ns(self) -> int:
        """The period in whole nanoseconds: stamps are multiples of it."""
        return round(self.period * 1e9)

    @cached_property
    def steps(self) -> int:
        """Control periods in the run, at least one."""
        return max(1, round(self.duration / self.period))

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands of the drives of actuated joints (nu,): effort, velocity or position."""
        return commands_of(self.hardware, len(self.actuated))

    @property
    def held(self) -> tuple[str, ...]:
        """Actuated joints whose demand is held for a period.

        All that are commanded, and of open-loop inputs those of drives with a state of their own.
        """
        return self.actuated if self.sampled else stateful_joints(self.hardware, self.actuated)

    @property
    def command_units(self) -> tuple[str, ...]:
        """Units of the commands (nu,)."""
        own = dict(zip(self.joint_names, self.joint_units, strict=True))
        units = {"velocity": "{}/s", "position": "{}"}
        named = zip(self.actuated, self.commands, self.effort_units, strict=True)
        return tuple(
            units[kind].format(own[name]) if kind in units else unit for name, kind, unit in named
        )

    @property
    def idle_command(self) -> tuple[float, ...]:
        """The command (nu,) that moves nothing at the start: the initial position, or zero."""
        start = dict(zip(self.joint_names, self.initial_q, strict=True))
        return self.zero_command([start[name] for name in self.actuated])

    def zero_command(self, last: Sequence[float]) -> tuple[float, ...]:
        """Return the command (nu,) of zero efforts and speeds, positions as in `last` (nu,).

        A command is a position of a position drive, or of a suspension point that is moved.
        """
        own = dict(zip(self.joint_names, self.joint_units, strict=True))
        named = zip(self.actuated, self.command_units, last, strict=True)
        return tuple(held if unit == own[name] else 0.0 for name, unit, held in named)

    @property
    def path(self) -> Any:
        """Deprecated name of `trajectory`, for one release."""
        warnings.warn("Scene.path is now Scene.trajectory", DeprecationWarning, stacklevel=2)
        return self.trajectory

    def with_external_commands(self) -> "Scene":
        """Return the scene without its law and inputs, for external commands every period."""
        return replace(self, law=None, law_name=None, source=None, sampled=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the document that this scene was read from, names and overrides included."""
        return copy.deepcopy(dict(self.document))

    def __repr__(self) -> str:
        """Return a description in one line."""
        law = f"law {self.law_name!r}" if self.law_name else "no law"
        steps = f"{self.duration:g} s in {self.steps} periods of {self.period:g} s"
        return (
            f"<Scene {self.name!r}: {self.crane} crane, {law}, {steps}, "
            f"{type(self.method).__name__}>"
        )

    def dump(self, path: Path | str) -> None:
        """Write the scene as a file that `load_scene` reads back."""
        style: dict[str, Any] = {
            "sort_keys": False,
            "allow_unicode": True,
            "default_flow_style": None,
        }  # lists in lines
        write_text(Path(path), yaml.safe_dump(self.to_dict(), **style))


SceneSource = str | Path | Mapping[str, Any] | Scene
"""Sources of `load_scene`: a name of the catalogue, a file, a dict of a file's shape, or a
scene."""


def load_scene(
    source: SceneSource, overrides: Mapping[str, Any] | None = None, own_law: bool = True
) -> Scene:
    """Return the scene of a catalogue name, a file path, a dict as in a file, or another scene.

    Args:
        source: what to read; a Scene without overrides is returned as it is.
        overrides: values by dotted key, such as {"payload.mass": 1.2}. Another "control.law" than
            the scene's own leaves the settings of that one out; `notes` then name them.
        own_law: whether a law FILE.py:FUNCTION or MODULE:FUNCTION is executed; if not, such a scene
            has none (`law`).

    Raises:
        SceneError: one line naming the key, its value and what is possible.
    """
    if overrides is not None and not isinstance(overrides, Mapping):
        raise SceneError(
            f"overrides = {shorten(overrides)}: must map dotted keys of the scene to values"
        )
    if isinstance(source, Scene) and not overrides:
        return source
    (found,) = load_scenes(source, [overrides or {}], own_law)
    if isinstance(found, SceneError):
        raise found from None
    return found


def load_scenes(
    source: SceneSource, changes: Sequence[Mapping[str, Any]], own_law: bool = True
) -> list[Scene | SceneError]:
    """Return, for each of many changes of a scene, the result or the error of `load_scene`.

    The source is read once, and laws of the same name are designed together.

    Raises:
        SceneError: there is no such scene.
    """
    document = source.document if isinstance(source, Scene) else source
    try:
        document = plain_copy(document) if isinstance(document, Mapping) else read(document)
    except RecursionError:
        raise SceneError("scene: has too many nested groups") from None
    changed = [_changed_document(document, each) for each in changes]
    found = [_attempt(each, _build_scene, each) for each, _ in changed]
    for law, numbers in _by_law(found, own_law).items():
        _add_laws(law, found, numbers)
    control = document.get("control")
    return [
        _note_left_out(scene, keys, control)
        for scene, (_, keys) in zip(found, changed, strict=True)
    ]


def _changed_document(
    document: dict[str, Any], changes: Mapping[str, Any]
) -> tuple[Any, Sequence[str]]:
    """Return (the changed document, settings of its law that the changes leave out).

    Where that fails it is (the error, none).
    """
    try:
        switched, ignored = switch_law(document, changes)
        return with_values(switched, changes), ignored
    except SceneError as error:
        return _with_name(document, error), ()
    except RecursionError:
        return SceneError("scene: has too many nested groups"), ()


def _attempt(document: Any, function: Callable[..., Any], *args: Any) -> Any:
    """Return what a function returns, or its error with the scene's name.

    A document that is itself an error is returned as it is.
    """
    if isinstance(document, SceneError):
        return document
    try:
        return function(*args)
    except (SceneError, RecursionError) as error:
        return _with_name(document, error)


def _with_name(document: Mapping[str, Any], error: Exception) -> SceneError:
    return SceneError(f"scene {one_word(document.get('name', 'given as a dict'))}: {error}")


def _by_law(found: Sequence[Scene | SceneError], own_law: bool) -> dict[str, list[int]]:
    """Return the numbers of the scenes by the name of their law.

    Without `own_law` only installed laws count.
    """
    groups: dict[str, list[int]] = {}
    for i, scene in enumerate(found):
        name = scene.law_name if isinstance(scene, Scene) else None
        if name is not None and (own_law or not is_own(name)):
            groups.setdefault(name, []).append(i)
    return groups


def _add_laws(name: str, found: list[Any], numbers: Iterable[int]) -> None:
    """Give the scenes of these numbers their law, or put its error in their place."""
    scenes = {i: found[i] for i in numbers}
    nominals = {i: _attempt(scene.document, _nominal_scene, scene) for i, scene in scenes.items()}
    sound = [i for i, scene in nominals.items() if isinstance(scene, Scene)]
    settings = [scenes[i].file.control.model_extra or {} for i in sound]
    laws = make_laws(name, settings, [nominals[i] for i in sound]) if sound else ()
    found_laws = dict(zip(sound, laws, strict=True))
    for i, scene in scenes.items():
        law = found_laws.get(i, nominals[i])
        if isinstance(law, SceneError):
            found[i] = law if i not in found_laws else _with_name(scene.document, law)
        else:
            found[i] = _attempt(scene.document, _with_law, scene, law)


def _with_law(scene: Scene, law: Law) -> Scene:
    """Return a scene with its law; SceneError: the equations, or its drives, do not take it."""
    name = str(scene.law_name)
    if not scene.sampled and not system.effort.has_implementation(type(law)):
        line = f"{shorten(name, PATH)} is a sampled law: give a period, in seconds"
        raise SceneError(f"control.period = 'continuous': {line}")
    check_commands(name, law, scene.actuated, scene.commands)
    return replace(
        scene, law=law, source=None if scene.sampled else _source(law, scene.method, scene.model)
    )


def _source(source: Any, method: Any, model: Any) -> Any:
    """Return a source of efforts, with its kinks as ends of steps for adaptive methods."""
    return with_breakpoints(source, model) if hasattr(method, "rtol") else source


def _note_left_out(scene: Any, ignored: Sequence[str], control: Any) -> Any:
    """Return the scene with a note on the settings of its own `control` that were left out."""
    if not ignored or isinstance(scene, SceneError):
        return scene
    left_out = f"{', '.join(map(str, ignored))} of law {control.get('law')!r}"
    return replace(scene, notes={**scene.notes, "left_out": left_out})


def _build_scene(document: dict[str, Any], period: float | None = None) -> Scene:
    """Return the scene of a document without its law.

    Args:
        document: of the scene.
        period: the control period [s] of another scene, None: its own.
    """
    file, drawn = read_file(document)
    with refuse_extreme_numbers(document):
        crane = file.build()
        method, reason = choose_method(file.integrator, crane.requirements, crane.model)
    reference = resolve_target(crane.target, crane.trajectory)
    check_limits(crane, reference)
    period, duration, rounded = _clock(file, period)
    devices, noted = _devices(file, period)
    motion = _motion(file, crane, method, varies_within_period(devices["hardware"], duration))
    notes = (crane.notes, drawn, {"method": reason} if reason else {}, rounded, noted)
    return Scene(
        name=file.name or "unnamed",
        crane=document["crane"],
        seed=file.seed,
        description=file.description,
        duration=duration,
        period=period,
        reference=reference,
        notes=_join_notes(*notes, _load_notes(file, crane, duration)),
        document=document,
        file=file,
        **{name: getattr(crane, name) for name in OF_CRANE},
        **motion,
        **devices,
    )


def _motion(file: SceneFile, crane: Assembly, method: Any, varies: bool) -> dict[str, Any]:
    """Return the fields of a scene on what is integrated and what drives it, without its law.

    Args:
        file, crane: of the scene.
        method: settings of the integrator.
        varies: whether held commands give efforts that change within a period.
    """
    control, sampled = file.control, file.is_sampled
    is_held = sampled or (control is None and type(crane.open_loop) is tuple)
    model = system.with_meter(crane.model, is_held and not varies)
    check_fit(method, model, continuous=control is not None and not sampled)
    source = None if control is not None else _source(crane.open_loop, method, model)
    law = {"law": None, "law_name": control and control.law, "sampled": sampled}
    return law | {"model": model, "method": method, "source": source}


def _devices(file: SceneFile, period: float) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (the fields of a scene on hardware and instruments, notes on both)."""
    hardware, noted = equipment_of(file, period)
    instruments, also_noted = instruments_of(file, period)
    return {"hardware": hardware, "instruments": instruments}, _join_notes(noted, also_noted)


def _nominal_scene(scene: Scene) -> Scene:
    """Return the nominal scene of a scene's law: commanded as the real one, with its first joints.

    Raises:
        SceneError: the scene has a law and inputs, or the nominal scene is invalid.
    """
    control = scene.file.control
    assert control is not None
    if scene.document.get("inputs") is not None:
        raise SceneError(
            "inputs: a scene with a control law takes none (leave out one of inputs, control)"
        )
    document = nominal(dict(scene.document), control.nominal)
    same_crane = scene.document.keys() - document.keys() == {"control"}
    if scene.sampled and not control.nominal and same_crane:
        file = scene.file.model_copy(update={"control": None})
        return replace(scene, law_name=None, file=file, document=document, source=file.open_loop())
    try:
        own = _build_scene(document, scene.period)
    except SceneError as error:
        raise SceneError(f"control.nominal: {error}") from None
    first_joints = scene.joint_names[: len(own.joint_names)]
    if own.actuated != scene.actuated or own.joint_names != first_joints:
        raise SceneError(
            f"control.nominal: its joints {own.joint_names}, actuated {own.actuated}, must be the "
            f"first ones of the crane's {scene.joint_names}, actuated {scene.actuated}"
        )
    return replace(own, sampled=scene.sampled)


def _join_notes(*notes: Mapping[str, Any]) -> dict[str, Any]:
    """Return notes as one group; lists of the same name are concatenated."""
    joined: dict[str, Any] = {}
    for key, value in (item for group in notes for item in group.items()):
        joined[key] = [*joined.get(key, ()), *value] if isinstance(value, list) else value
    return joined


def _load_notes(file: SceneFile, crane: Assembly, duration: float) -> dict[str, Any]:
    """Return notes on base motion, wind and payload changes after the end of the run.

    The run ends at `duration` [s].
    """
    motion, wind = file.base_motion, getattr(crane.model, "wind", None)
    of_base = motion.notes(crane.model.base, file.duration) if motion is not None else {}
    of_wind = file.wind.notes(wind, file.seed) if file.wind is not None and wind is not None else {}
    lines = [
        f"events[{i}].at = {event.at:g}: not reached, the run ends at {duration:g} s"
        for i, event in enumerate(getattr(file, "events", ()))
        if event.at >= duration
    ]
    return _join_notes(of_base, of_wind, {"warnings": lines} if lines else {})


def _clock(file: SceneFile, period: float | None) -> tuple[float, float, dict[str, Any]]:
    """Return (period [s], duration [s] in whole periods, a note when the file's is another).

    The duration is at least one period.
    """
    period, duration = _period(file) if period is None else period, file.duration
    exact = duration / period
    steps = max(1, round(exact))
    if abs(steps - exact) <= CLOSE:
        return period, duration, {}
    return (
        period,
        steps * period,
        {"rounded": [f"duration: {duration:.9g} s is taken as {steps * period:.9g} s"]},
    )


def _period(file: SceneFile) -> float:
    control = file.control
    period = float(
        DEFAULT_PERIOD if control is None or control.period == "continuous" else control.period
    )
    if not period <= file.duration <= MAX_STEPS * period:
        raise SceneError(
            f"duration = {file.duration}: must be 1 to {MAX_STEPS:g} periods of {period:g} s"
        )
    return period


def check_limits(crane: Assembly, target: Sequence[float] | None) -> None:
    """Raise SceneError when a crane's start or target (nu,) is outside its travel limits."""
    for limit in crane.limits:
        i, key = crane.joint_names.index(limit.joint), f"{limit.key} = {[limit.low, limit.high]}"
        start, unit = crane.initial_q[i], crane.joint_units[i]
        if not limit.low < limit.high:
            raise SceneError(f"{key}: must increase")
        if not limit.low <= start <= limit.high:
            raise SceneError(
                f"{key}: the {limit.joint} starts outside of them, at {start:g} {unit}"
            )
        if target is None or limit.joint not in crane.actuated:
            continue
        k = crane.actuated.index(limit.joint)
        if not limit.low <= target[k] <= limit.high:
            raise SceneError(
                f"reference: the {limit.joint} should end at {target[k]:g} {unit}, outside of {key}"
            )
