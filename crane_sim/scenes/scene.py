"""A scene: the crane, its inputs, duration and integration method."""

import copy
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from pydantic import ValidationError

from crane_sim import system
from crane_sim.files.document import SHARED, nominal, plain_copy, read, set_value, switch_law, without_nulls
from crane_sim.files.errors import PATH, SceneError, foreign_path, nearest, one_line, one_word, shorten
from crane_sim.files.output import write_text
from crane_sim.hardware.instruments import Instruments
from crane_sim.laws import ForeignSetting, Law, check_commands, is_own, make_law
from crane_sim.scenes.extreme_numbers import refuse_extreme_numbers
from crane_sim.scenes.hardware_settings import (
    CLOSE,
    commands_of,
    equipment_of,
    stateful_joints,
    varies_within_period,
)
from crane_sim.scenes.instrument_settings import instruments_of
from crane_sim.scenes.registry import SCHEMAS, check_cable, key_of_other_cranes, places_of, schema_of
from crane_sim.scenes.schema.integrator import check_fit, choose_method
from crane_sim.scenes.schema.limits import TravelLimits
from crane_sim.scenes.schema.reference import resolve_target
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.schema.uncertain import draw_parameters
from crane_sim.trajectories.breakpoints import with_breakpoints

MAX_STEPS = 1e8  # control periods in a run
DEFAULT_PERIOD = 0.01  # s, between published states, unless the law has a period


@dataclass(frozen=True, repr=False)
class Scene:
    """A checked scene. Joint coordinates are in the order of joint_names, the actuated ones first."""

    name: str  # of its file
    crane: str  # the kind of crane: knuckle, tower, overhead, ...
    model: Any = field(compare=False)  # parameters, whose type chooses the equations
    initial_q: tuple[float, ...]  # (nq,)
    initial_v: tuple[float, ...]  # (nq,)
    duration: float  # s
    period: float  # s, between published states, and between commands when sampled
    method: Any  # settings of the integrator
    law: Law | None = field(compare=False)  # a callable(t, q, v), see `crane_sim.laws`; None without one
    law_name: str | None  # None without a law
    sampled: bool  # drives are commanded once a period; otherwise the equations evaluate `source`, except for `held`
    source: Any = field(compare=False)  # open-loop Inputs or a continuous law; None when sampled
    reference: tuple[float, ...] | None  # (nu,)
    trajectory: Any = field(compare=False)  # compiled `trajectories.trajectory.Trajectory`, None without one
    seed: int  # of everything random
    description: str  # in plain words
    joint_names: tuple[str, ...]  # (nq,)
    actuated: tuple[str, ...]  # joints that take commands (nu,)
    joint_units: tuple[str, ...]  # (nq,)
    effort_units: tuple[str, ...]  # (nu,)
    limits: tuple[TravelLimits, ...]  # travel limits of the joints that have some
    notes: Mapping[str, Any]  # automatic settings and warnings, entries of the summary
    document: Mapping[str, Any]  # the file as it was read, with all changes
    file: SceneFile = field(compare=False)  # as it was checked, defaults included and uncertain parameters drawn
    hardware: Any = field(default=None, compare=False)  # `hardware.settings.HardwareConfig`; None where all is ideal
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
        """What the drives of the actuated joints are commanded (nu,): effort, velocity or position."""
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
        return tuple(units[kind].format(own[name]) if kind in units else unit for name, kind, unit in named)

    @property
    def idle_command(self) -> tuple[float, ...]:
        """The command (nu,) that moves nothing at the start: the initial position where it is one, else zero."""
        start = dict(zip(self.joint_names, self.initial_q, strict=True))
        return self.zero_command([start[name] for name in self.actuated])

    def zero_command(self, last: Sequence[float]) -> tuple[float, ...]:
        """Return the command (nu,) of zero efforts and speeds; positions are those of the `last` one (nu,).

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
        """Return the scene with its own law and inputs left out: commands come from outside, one every period."""
        return replace(self, law=None, law_name=None, source=None, sampled=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the document that this scene was read from, names and overrides included."""
        return copy.deepcopy(dict(self.document))

    def __repr__(self) -> str:
        """Return a description in one line."""
        law = f"law {self.law_name!r}" if self.law_name else "no law"
        steps = f"{self.duration:g} s in {self.steps} periods of {self.period:g} s"
        return f"<Scene {self.name!r}: {self.crane} crane, {law}, {steps}, {type(self.method).__name__}>"

    def dump(self, path: Path | str) -> None:
        """Write the scene as a file that `load_scene` reads back."""
        style: dict[str, Any] = {
            "sort_keys": False,
            "allow_unicode": True,
            "default_flow_style": None,
        }  # lists in lines
        write_text(Path(path), yaml.safe_dump(self.to_dict(), **style))


SceneSource = str | Path | Mapping[str, Any] | Scene
"""Sources of `load_scene`: a name of the catalogue, a file, a dict of a file's shape, or a scene."""


def load_scene(source: SceneSource, overrides: Mapping[str, Any] | None = None, own_law: bool = True) -> Scene:
    """Return the scene of a catalogue name, a file path, a dict of a file's shape, or another scene with changes.

    Args:
        source: what to read; a Scene without overrides is returned as it is.
        overrides: values by dotted key, such as {"payload.mass": 1.2}. Another "control.law" than the scene's own
            leaves the settings of that one out; `notes` then name them.
        own_law: whether a law FILE.py:FUNCTION or MODULE:FUNCTION is executed; if not, such a scene has none (`law`).

    Raises:
        SceneError: one line naming the key, its value and what is possible.
    """
    if overrides is not None and not isinstance(overrides, Mapping):
        raise SceneError(f"overrides = {shorten(overrides)}: must map dotted keys of the scene to values")
    changes = plain_copy(overrides or {})  # two keys may overlap: the caller's groups stay as they are
    if isinstance(source, Scene):
        if not changes:
            return source
    try:
        document = document_of(source)
        control, ignored = copy.deepcopy(document.get("control")), switch_law(document, changes)
        for key, value in changes.items():
            set_value(document, key, value)
    except RecursionError:
        raise SceneError("scene: has too many nested groups") from None
    try:
        return _build_switched(document, control, ignored, changes, own_law)
    except (SceneError, RecursionError) as error:
        raise with_scene_name(document, error) from None


def document_of(source: SceneSource) -> dict[str, Any]:
    """Return a copy of the document that `load_scene` reads."""
    if isinstance(source, Scene):
        source = source.document
    return plain_copy(source) if isinstance(source, Mapping) else read(source)


def with_scene_name(document: Mapping[str, Any], error: Exception) -> SceneError:
    """Return an error of a document with the name of its scene."""
    return SceneError(f"scene {_name(document)}: {error}")


def _name(document: Mapping[str, Any]) -> str:
    return one_word(document.get("name", "given as a dict"))


def _build_switched(
    document: dict[str, Any], control: Any, ignored: list[str], changes: Mapping[str, Any], own_law: bool
) -> Scene:
    """Return the scene with a note of what was left out of its original `control` group when its law was switched.

    These are the keys in `ignored`, and those that laws share, unless the new law has them or `changes` set them; the
    latter are removed from `document` and added to `ignored`.
    """
    law, changed = changes.get("control.law"), {".".join(str(key).split(".")[:2]) for key in changes}
    switched = isinstance(control, dict) and law is not None and law != control.get("law")
    shared = [key for key in SHARED if switched and key in control and f"control.{key}" not in changed]
    while True:
        try:
            scene = _build_scene(document, own_law)
            break
        except ForeignSetting as error:
            if error.key not in shared:
                raise
            shared.remove(error.key)
            ignored.append(error.key)
            del document["control"][error.key]
    return note_left_out(scene, ignored, control)


def note_left_out(scene: Scene, ignored: Sequence[str], control: Any) -> Scene:
    """Return the scene with a note on the settings of its original `control` group that were left out."""
    if not ignored:
        return scene
    return replace(
        scene, notes={**scene.notes, "left_out": f"{', '.join(map(str, ignored))} of law {control.get('law')!r}"}
    )


class Draft(NamedTuple):
    """A checked document whose law is yet to be made."""

    file: SceneFile  # defaults included and uncertain parameters drawn
    notes: dict[str, Any]
    crane: Any  # parameters, without the integral of work
    clock: tuple[float, float, dict[str, Any]]  # as of `_clock`
    fields: dict[str, Any]  # of the scene, which depend on the file alone
    document: dict[str, Any]


def draft_scene(document: dict[str, Any], period: float | None = None) -> Draft:
    """Return a document checked, with the control period [s] of another one where that is given."""
    file, notes = _read_file(document)
    with refuse_extreme_numbers(document):
        crane = file.model()  # first: it rejects scenes of which nothing else can be computed
        return Draft(file, notes, crane, _clock(file, period), _file_fields(file, document), document)


def finish_scene(draft: Draft, law: Law | None) -> Scene:
    """Return the scene of a draft with its law.

    Raises:
        SceneError: law, method and devices do not fit one another.
    """
    file, notes, crane, (period, duration, rounded), fields, document = draft
    control, continuous = file.control, _is_continuous(file)
    _check_continuous(file, law)
    sampled = control is not None and not continuous
    with refuse_extreme_numbers(document):
        source = law if continuous else None if control is not None else file.open_loop()
        method, reason = choose_method(file.integrator, file.method_requirements(sampled), crane)
    devices, noted = _devices(file, period, law)
    is_held = sampled or type(source) is tuple
    model = system.with_meter(crane, is_held and not varies_within_period(devices["hardware"], duration))
    check_fit(method, model, continuous)
    return Scene(
        **fields,
        model=model,
        duration=duration,
        period=period,
        method=method,
        law=law,
        sampled=sampled,
        source=with_breakpoints(source, model) if hasattr(method, "rtol") and not sampled else source,
        notes=_join_notes(notes, {"method": reason} if reason else {}, rounded, noted, _load_notes(draft)),
        document=document,
        file=file,
        **devices,
    )


def _check_continuous(file: SceneFile, law: Law | None) -> None:
    """Raise SceneError where the equations should evaluate a law that they cannot."""
    if file.control is None or law is None or not _is_continuous(file):
        return
    if not system.effort.has_implementation(type(law)):
        line = f"{shorten(file.control.law, PATH)} is a sampled law: give a period, in seconds"
        raise SceneError(f"control.period = 'continuous': {line}")


def _build_scene(document: dict[str, Any], own_law: bool) -> Scene:
    """Return the scene of a document; arguments of `load_scene`."""
    draft = draft_scene(document)
    control = draft.file.control
    if control is None or (is_own(control.law) and not own_law):
        return finish_scene(draft, None)
    return finish_scene(draft, make_law(control.law, *law_parts(draft)))


def _devices(file: SceneFile, period: float, law: Law | None) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (the fields of a scene on hardware and instruments, notes on both); drives take what the law commands."""
    (hardware, noted), (instruments, also_noted) = equipment_of(file, period), instruments_of(file, period)
    if law is not None and file.control is not None:
        check_commands(file.control.law, law, file.actuated, commands_of(hardware, len(file.actuated)))
    return {"hardware": hardware, "instruments": instruments}, _join_notes(noted, also_noted)


def _read_file(document: dict[str, Any]) -> tuple[SceneFile, dict[str, Any]]:
    """Return (a document's file with its uncertain parameters drawn, its notes and one on what was drawn)."""
    certain, drawn = draw_parameters(document)
    try:
        file = _validate(certain)
    except SceneError as error:
        key = next((key for key in drawn if str(error).startswith(key)), None)
        if key is None:
            raise
        raise SceneError(f"{error} (drawn by uncertain.{key})") from None
    return file, dict(file.notes) | ({"drawn": drawn} if drawn else {})


def _file_fields(file: SceneFile, document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a scene that depend on its file alone."""
    trajectory = file.trajectory()
    reference = resolve_target(file.target, trajectory)
    check_limits(file, reference)
    return {
        "name": file.name or "unnamed",
        "crane": document["crane"],
        "law_name": file.control and file.control.law,
        "description": file.description,
        "seed": file.seed,
        "joint_names": file.joint_names,
        "joint_units": file.joint_units,
        "actuated": file.actuated,
        "effort_units": file.effort_units,
        "limits": file.limits,
        "initial_q": file.initial_q,
        "initial_v": file.initial_v,
        "trajectory": trajectory,
        "reference": reference,
    }


def _join_notes(*notes: Mapping[str, Any]) -> dict[str, Any]:
    """Return notes as one group; lists of the same name are concatenated."""
    joined: dict[str, Any] = {}
    for key, value in (item for group in notes for item in group.items()):
        joined[key] = [*joined.get(key, ()), *value] if isinstance(value, list) else value
    return joined


def _load_notes(draft: Draft) -> dict[str, Any]:
    """Return notes on base motion, wind and changes of the payload."""
    file, crane, (_, duration, _) = draft.file, draft.crane, draft.clock
    motion, wind = file.base_motion, getattr(crane, "wind", None)
    of_base = motion.notes(crane.base, file.duration) if motion is not None else {}
    of_wind = file.wind.notes(wind, file.seed) if file.wind is not None and wind is not None else {}
    return _join_notes(of_base, of_wind, _late_events(file, duration))


def _late_events(file: SceneFile, duration: float) -> dict[str, Any]:
    """Return warnings of changes of the payload that the run does not reach."""
    late = [(i, event.at) for i, event in enumerate(getattr(file, "events", ())) if event.at >= duration]
    lines = [f"events[{i}].at = {at:g}: not reached, the run ends at {duration:g} s" for i, at in late]
    return {"warnings": lines} if lines else {}


def _clock(file: SceneFile, period: float | None) -> tuple[float, float, dict[str, Any]]:
    """Return (period [s], duration [s] in whole periods, at least one, a note when the file has another one)."""
    period, duration = _period(file) if period is None else period, file.duration
    exact = duration / period
    steps = max(1, round(exact))
    if abs(steps - exact) <= CLOSE:
        return period, duration, {}
    return period, steps * period, {"rounded": [f"duration: {duration:.9g} s is taken as {steps * period:.9g} s"]}


def _is_continuous(file: SceneFile) -> bool:
    return file.control is not None and file.control.period == "continuous"


def _period(file: SceneFile) -> float:
    control = file.control
    period = float(DEFAULT_PERIOD if control is None or control.period == "continuous" else control.period)
    if not period <= file.duration <= MAX_STEPS * period:
        raise SceneError(f"duration = {file.duration}: must be 1 to {MAX_STEPS:g} periods of {period:g} s")
    return period


def _validate(document: dict[str, Any]) -> SceneFile:
    if "crane" not in document:
        known = {key for schema in SCHEMAS.values() for key in schema.model_fields}
        suggestion = nearest("crane", [key for key in document if key not in known])
        what = (
            f"unknown key {suggestion!r}, did you mean 'crane'? (crane: "
            if suggestion
            else "crane: is missing (possible: "
        )
        raise SceneError(f"{what}{', '.join(SCHEMAS)})")
    schema = schema_of(document)
    if schema is None:
        raise SceneError(f"crane = {shorten(document['crane'])}: possible: {', '.join(SCHEMAS)}")
    check_cable(document)
    try:
        return schema.model_validate(without_nulls(document))
    except ValidationError as error:
        path = foreign_path(error)
        line = key_of_other_cranes(path, document["crane"]) or one_line(error, schema) + places_of(path)
        raise SceneError(line) from None


def law_parts(draft: Draft) -> tuple[Mapping[str, Any], Scene]:
    """Return (settings of a draft's law, its nominal scene: commanded as the real one, with its first joints).

    Raises:
        SceneError: the scene has a law and inputs, or the nominal scene is invalid.
    """
    control = draft.file.control
    assert control is not None
    if draft.document.get("inputs") is not None:
        raise SceneError("inputs: a scene with a control law takes none (leave out one of inputs, control)")
    try:
        scene = finish_scene(_nominal_draft(draft), None)
    except SceneError as error:
        raise SceneError(f"control.nominal: {error}") from None
    file = draft.file
    if scene.actuated != file.actuated or scene.joint_names != file.joint_names[: len(scene.joint_names)]:
        raise SceneError(
            f"control.nominal: its joints {scene.joint_names}, actuated {scene.actuated}, must be the first ones of "
            f"the crane's {file.joint_names}, actuated {file.actuated}"
        )
    return control.model_extra or {}, replace(scene, sampled=control.period != "continuous")


def _nominal_draft(draft: Draft) -> Draft:
    """Return the draft of the law's nominal scene; where that only lacks the law, it is this draft without it."""
    file, control = draft.file, draft.file.control
    assert control is not None
    document = nominal(draft.document, control.nominal)
    if control.nominal or _is_continuous(file) or draft.document.keys() - document.keys() != {"control"}:
        return draft_scene(document, _period(file))
    return draft._replace(
        file=file.model_copy(update={"control": None}), fields=draft.fields | {"law_name": None}, document=document
    )


def check_limits(file: SceneFile, target: Sequence[float] | None) -> None:
    """Raise SceneError when a scene starts, or should end, outside its travel limits.

    Args:
        file: the scene's file.
        target: of the actuated joints (nu,), None without a target.
    """
    for limit in file.limits:
        i, key = file.joint_names.index(limit.joint), f"{limit.key} = {[limit.low, limit.high]}"
        start, unit = file.initial_q[i], file.joint_units[i]
        if not limit.low < limit.high:
            raise SceneError(f"{key}: must increase")
        if not limit.low <= start <= limit.high:
            raise SceneError(f"{key}: the {limit.joint} starts outside of them, at {start:g} {unit}")
        if target is None or limit.joint not in file.actuated:
            continue
        k = file.actuated.index(limit.joint)
        if not limit.low <= target[k] <= limit.high:
            raise SceneError(f"reference: the {limit.joint} should end at {target[k]:g} {unit}, outside of {key}")
