"""A scene: what is simulated, for how long, driven by what, integrated how."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from crane_sim.cables.rope import ForceRope, LockedRope, RateRope
from crane_sim.catalogue import scene_files
from crane_sim.explain import SceneError, one_line, unknown_key
from crane_sim.laws import Law, make_law
from crane_sim.model import Crane
from crane_sim.schema import InputGroup, KnuckleFile
from crane_sim.sources import Inputs
from crane_sim.supports.knuckle import Knuckle

JOINTS = ("slew", "boom", "jib", "rope", "swing_tangential", "swing_radial")
UNITS = ("N m", "N m", "N m", "N")
DEFAULT_PERIOD = 0.01  # s, between published states where no law says otherwise


@dataclass(frozen=True)
class Scene:
    """A checked scene. Joint coordinates are in the order of joint_names, the actuated ones first."""

    name: str
    crane: str
    model: Crane
    initial_q: tuple[float, ...]  # (nq,)
    initial_v: tuple[float, ...]  # (nq,)
    duration: float  # s
    period: float  # s, between published states, and between commands when sampled
    method: Any  # settings of the integrator
    law: Law | None
    law_name: str | None
    sampled: bool  # efforts are commanded once a period; otherwise the equations evaluate `source`
    source: Any  # open-loop Inputs or a continuous law; None when sampled
    reference: tuple[float, ...] | None  # (nu,)
    seed: int
    description: str
    document: Mapping[str, Any] = field(repr=False)
    joint_names: tuple[str, ...] = JOINTS
    joint_units: tuple[str, ...] = ("rad", "rad", "rad", "m", "rad", "rad")

    @property
    def actuated(self) -> tuple[str, ...]:
        """Names of the joints that take commands (nu,)."""
        return self.joint_names[: 3 if isinstance(self.model.cable, LockedRope) else 4]

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands (nu,)."""
        units = (*UNITS[:3], self._winch_unit)
        return units[: len(self.actuated)]

    @property
    def _winch_unit(self) -> str:
        if not isinstance(self.model.cable, RateRope):
            return UNITS[3]
        return "m/s²" if self.model.cable.time_constant is None else "m/s"

    @property
    def period_ns(self) -> int:
        """The period in whole nanoseconds: stamps are multiples of it."""
        return round(self.period * 1e9)

    @property
    def steps(self) -> int:
        """Control periods in the run, at least one."""
        return max(1, round(self.duration / self.period))

    def commanded(self) -> "Scene":
        """Return the scene with its own law and inputs left out: somebody else sends a command every period."""
        return replace(self, law=None, law_name=None, source=None, sampled=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the document that this scene was read from, names and overrides included."""
        return copy.deepcopy(dict(self.document))

    def dump(self, path: Path | str) -> None:
        """Write the scene as a file that `load_scene` reads back."""
        Path(path).write_text(yaml.safe_dump(self.to_dict(), sort_keys=False, allow_unicode=True))


def load_scene(source: str | Path | Mapping[str, Any], overrides: Mapping[str, Any] | None = None) -> Scene:
    """Return the scene of a catalogue name, a file path or a dict of a file's shape.

    Args:
        source: what to read.
        overrides: values by dotted key, such as {"payload.mass": 1.2}.

    Raises:
        SceneError: one line naming the culprit, its value and what is possible.
    """
    document = copy.deepcopy(dict(source)) if isinstance(source, Mapping) else _read(source)
    for key, value in (overrides or {}).items():
        _set(document, key, value)
    try:
        return _build(document)
    except SceneError as error:
        raise SceneError(f"scene {document.get('name', 'given as a dict')}: {error}") from None


def _read(source: str | Path) -> dict[str, Any]:
    path = scene_files().get(str(source), Path(source))
    if not path.exists():
        known = tuple(scene_files())
        raise SceneError(f"{unknown_key(str(source), known, 'scene')}, and there is no such file")
    try:
        document = yaml.safe_load(path.read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise SceneError(f"scene file {path}: cannot be read: {' '.join(str(error).split())}") from None
    if not isinstance(document, dict):
        raise SceneError(f"scene file {path}: holds {type(document).__name__}, not groups of keys")
    document.setdefault("name", path.stem)
    return document


def _set(document: dict[str, Any], key: str, value: Any) -> None:
    *groups, last = key.split(".")
    group = document
    for name in groups:
        group = group.setdefault(name, {})
        if not isinstance(group, dict):
            raise SceneError(f"{key}: {name!r} is not a group of keys")
    group[last] = value


def _build(document: dict[str, Any]) -> Scene:
    if document.get("crane") != "knuckle":
        raise SceneError(f"crane = {document.get('crane')!r}: possible: knuckle")
    file = _validated(document)
    control, reference = file.control, file.reference
    law = None
    if control is not None:
        if file.inputs is not None:
            raise SceneError("inputs: a scene with a control law takes none (leave out one of inputs, control)")
        law = make_law(control.law, control.model_extra or {}, _build(_nominal(document, control.nominal)))
    continuous = control is not None and control.period == "continuous"
    cable = _cable(file)
    return Scene(
        name=file.name or "unnamed",
        crane=file.crane,
        model=_model(file, cable),
        initial_q=file.initial.q,
        initial_v=file.initial.v,
        duration=file.duration,
        period=float(control.period) if control is not None and not continuous else DEFAULT_PERIOD,
        method=file.integrator,
        law=law,
        law_name=control.law if control else None,
        sampled=control is not None and not continuous,
        source=law if continuous else None if control else _inputs(file, cable),
        reference=reference.q[: 3 if isinstance(cable, LockedRope) else 4] if reference else None,
        seed=file.seed,
        description=file.description,
        document=document,
    )


def _validated(document: dict[str, Any]) -> KnuckleFile:
    try:
        return KnuckleFile.model_validate(document)
    except ValidationError as error:
        raise SceneError(one_line(error, KnuckleFile)) from None


def _nominal(document: dict[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document of what the law believes: the scene without its law, with `nominal` merged over it."""

    def merged(base: Any, over: Any) -> Any:
        if not (isinstance(base, dict) and isinstance(over, dict)):
            return over
        return {**base, **{key: merged(base.get(key), value) for key, value in over.items()}}

    return merged({key: value for key, value in document.items() if key != "control"}, dict(overrides))


def _cable(file: KnuckleFile) -> ForceRope | RateRope | LockedRope:
    if file.rope.time_constant is not None and file.rope.drive != "rate":
        raise SceneError(f"rope.time_constant: only a rate drive has one, this drive is {file.rope.drive!r}")
    if file.springs.rope is not None and file.rope.drive != "force":
        raise SceneError(f"springs.rope: only a force drive can have one, this drive is {file.rope.drive!r}")
    if file.rope.drive == "locked":
        if file.initial.v[3] != 0.0:
            raise SceneError(f"initial.v[3] = {file.initial.v[3]}: a locked rope starts at rest")
        return LockedRope(file.initial.q[3])
    return RateRope(file.rope.time_constant) if file.rope.drive == "rate" else ForceRope(file.springs.rope)


def _model(file: KnuckleFile, cable: ForceRope | RateRope | LockedRope) -> Crane:
    support = Knuckle(file.boom, file.jib, file.tower, file.springs.boom, file.springs.jib)
    return Crane(support, cable, file.payload, file.gravity, file.swing_friction, file.payload_drag)


def _inputs(file: KnuckleFile, cable: ForceRope | RateRope | LockedRope) -> Inputs:
    given = file.inputs or InputGroup()
    inputs = None if isinstance(cable, LockedRope) else Inputs(given.rope)
    return Inputs(given.slew, Inputs(given.boom, Inputs(given.jib, inputs)))
