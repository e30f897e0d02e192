"""The kinds of crane and the schemas of their files: a support and what may hang below it."""

from typing import Any, Literal

from pydantic import Field, create_model

from crane_sim.files.types import Positive, Real, Tilt
from crane_sim.scenes.schema.crane_file import CraneFile
from crane_sim.scenes.schema.falls_file import (
    FallsFile,
    HoistedFile,
    LoadStart,
    PointLoadStart,
    PortalStart,
)
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.line_file import LineFile, LineStart
from crane_sim.scenes.schema.overhead import OverheadFile
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.rigging import RopeStart
from crane_sim.scenes.schema.rope_file import RopeFile
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.schema.supports import (
    BridgeGroups,
    GantryGroups,
    KnuckleGroups,
    MobileGroups,
    PointGroups,
    SupportGroups,
    TowerGroups,
)
from crane_sim.trajectories.inputs import Constant

_MADE: dict[str, Any] = {}
"""Schemas that are made here, by their qualified names."""


def __getattr__(name: str) -> Any:
    """Return a schema that is made here: pickle finds classes as attributes of their module."""
    try:
        return _MADE[name]
    except KeyError:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None


def _keep(schema: Any) -> Any:
    """Return a schema with a qualified name of its own, under which it is kept."""
    schema.__qualname__ = f"{schema.__name__}_{len(_MADE)}"
    return _MADE.setdefault(schema.__qualname__, schema)


ADDED = {
    "rope": {"rope": Positive, "swing_tangential": Tilt, "swing_radial": Tilt},
    "hoist": {"hoist": Positive},
}
"""Joints of `initial.q` behind the support's, and the types of their positions, by the joint of the
winch."""


def in_words(kinds: dict[str, Any], per: str = "") -> str:
    """Return the unit of most joints, then all names with other units, from the joints' types."""
    units = {
        name: f"{'m' if kind in (Positive, Real) else 'rad'}{per}" for name, kind in kinds.items()
    }
    values = list(units.values())
    most = max(values, key=values.count)
    described = [name if unit == most else f"{name} [{unit}]" for name, unit in units.items()]
    return f"{most}, {', '.join(described)}"


def start_of(support: type[SupportGroups], winch: str, base: type[Group]) -> type[Group]:
    """Return the group `initial` of a crane: positions and velocities in the joints' order."""
    kinds = {joint.name: joint.kind for joint in support.joints} | ADDED[winch]
    return _keep(
        create_model(
            "Initial",
            __base__=base,
            __doc__=f"{base.__doc__}",
            __module__=__name__,
            q=(
                tuple[*kinds.values()],  # type: ignore[misc]
                Field(description=f"{in_words(kinds)}; angles may be text such as `30 deg`"),
            ),
            v=(
                tuple[*(Real,) * len(kinds)],  # type: ignore[misc]
                Field((0.0,) * len(kinds), description=f"{in_words(kinds, '/s')}"),
            ),
        )
    )


def reference_of(support: type[SupportGroups], winch: str) -> type[Group]:
    """Return the group `reference` of a crane all of whose joints take commands."""
    kinds = {joint.name: joint.kind for joint in support.joints} | {winch: Positive}
    words = f"{in_words(kinds)} at the end; the last one is the length of rope or falls"
    kind: Any = tuple[*kinds.values()] | None  # type: ignore[misc]
    return _keep(
        create_model(
            "Reference",
            __base__=ReferenceGroup,
            __doc__="Target of the actuated joints, and path of joints or payload; at least one of "
            "them.",
            __module__=__name__,
            q=(kind, Field(None, description=words)),
        )
    )


def inputs_of(units: dict[str, str]) -> type[Group]:
    """Return the group `inputs` of a crane, from the units of the efforts by joint."""
    fields: dict[str, Any] = {
        name: (Channel, Field(Constant(0.0), description=f"{unit}, over time"))
        for name, unit in units.items()
    }
    return _keep(
        create_model(
            "Inputs",
            __base__=Group,
            __doc__="Open-loop inputs of the actuated joints; those left out are zero.",
            __module__=__name__,
            **fields,
        )
    )


def _effort_units(support: type[SupportGroups], hanging: type[CraneFile]) -> dict[str, str]:
    """Return the units of the efforts on support and winch by joint."""
    any_unit = "effort's unit"
    units = dict.fromkeys(("tip_x", "tip_y", "tip_z"), any_unit)
    if support is not PointGroups:
        units = {joint.name: joint.effort_unit for joint in support.joints}
    return units | dict.fromkeys(hanging.winch, any_unit)


def file_of(
    crane: str,
    support: type[SupportGroups],
    hanging: type[CraneFile],
    start: type[Group],
    *,
    optional: bool = False,
) -> type[SceneFile]:
    """Return the schema of a kind of crane: a support, and what hangs below it.

    Args:
        crane: its name.
        support, hanging: their groups.
        start: the group `initial`, or its base where positions are in the order of the joints;
            `optional`: it may be left out.
    """
    by_order = start in (RopeStart, LoadStart)
    own = start_of(support, hanging.winch[0], start) if by_order else start
    typed = by_order and not issubclass(support, BridgeGroups)
    reference = reference_of(support, hanging.winch[0]) if typed else ReferenceGroup
    inputs = inputs_of(_effort_units(support, hanging))
    fields: dict[str, Any] = {
        "crane": (Literal[crane], Field(description="the kind of crane")),
        "initial": (own, Field(own() if optional else ..., description="the state at t = 0")),
        "reference": (reference | None, Field(None, description="where the crane should go")),
        "inputs": (
            inputs | None,
            Field(None, description="efforts of the actuated joints where there is no law"),
        ),
    }
    bases: Any = (support, hanging)
    return _keep(
        create_model(
            f"{crane.capitalize()}{hanging.__name__}",
            __base__=bases,
            __doc__=f"{support.__doc__} {hanging.__doc__}",
            __module__=__name__,
            **fields,
        )
    )


_SUPPORTS: dict[str, type[SupportGroups]] = {
    "knuckle": KnuckleGroups,
    "tower": TowerGroups,
    "mobile": MobileGroups,
}
SCHEMAS: dict[str, type[SceneFile]] = {
    **{crane: file_of(crane, support, RopeFile, RopeStart) for crane, support in _SUPPORTS.items()},
    "bridge": file_of("bridge", BridgeGroups, RopeFile, RopeStart),
    "gantry": file_of("gantry", GantryGroups, HoistedFile, PortalStart),
    "overhead": OverheadFile,
    "pendulum": file_of("pendulum", PointGroups, LineFile, LineStart, optional=True),
}
"""The kinds of crane, and the schema of their scene files."""

FALLS_SCHEMAS: dict[str, type[SceneFile]] = {
    **{
        crane: file_of(crane, support, HoistedFile, LoadStart)
        for crane, support in _SUPPORTS.items()
    },
    "pendulum": file_of("pendulum", PointGroups, FallsFile, PointLoadStart),
}
"""The same of those files that have `falls` in place of a rope."""

ALL_SCHEMAS = SCHEMAS | {f"{crane} with falls": schema for crane, schema in FALLS_SCHEMAS.items()}
"""All schemas, by what a crane is called."""
