"""The page on scene files agrees with the schemas, its signs and origins with the model."""

import re
from functools import cache
from itertools import chain
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel, Field

from crane_bench.documentation.fields import (
    REQUIRED,
    UNITS,
    Choice,
    fields,
    in_words,
    split_comment,
    subgroup,
)
from crane_bench.documentation.scene_format import COMMAND, anchor, scene_format
from crane_bench.documentation.signs import SIGNS
from crane_sim import load_scene
from crane_sim.laws import law_names, law_of
from crane_sim.scenes.registry import ALL_SCHEMAS
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import world_points

ROOT = Path(__file__).parents[2]


def groups() -> set[Any]:
    """Return every group that a scene file can have, those of laws included."""
    collected: set[Any] = set()

    def visit(group: Any) -> None:
        if isinstance(group, Choice):
            for kind in group.kinds.values():
                visit(kind)
        elif group is not None and group not in collected:
            collected.add(group)
            for field in fields(group):
                visit(subgroup(field.annotation))

    for group in (
        *ALL_SCHEMAS.values(),
        *chain(*(law_of(name).settings.values() for name in law_names())),
    ):
        visit(group)
    return collected


def test_the_page_is_what_the_command_writes() -> None:
    """The page in the tree is what its command writes now, with every added or changed key."""
    stored = (ROOT / "docs" / "scene_format.md").read_text()
    assert stored == scene_format(), f"out of date: ./{COMMAND}"


@pytest.mark.parametrize(
    "group", sorted(groups(), key=lambda group: f"{group.__module__}.{group.__name__}")
)
def test_every_key_has_a_unit_and_a_description(group: Any) -> None:
    """Each number has a unit, `-` for none, each key a description, each group a docstring."""
    assert group.__doc__
    for field in fields(group):
        assert field.text, f"{group.__name__}.{field.key} has no description"
        if "number" in in_words(field.annotation) or "angle" in in_words(field.annotation):
            assert field.unit in UNITS, f"{group.__name__}.{field.key} has no unit"


def test_links_lead_to_headings() -> None:
    """Each link within the page has its heading, and no two headings have the same anchor."""
    page = scene_format()
    anchors = [anchor(line.lstrip("# ")) for line in page.splitlines() if line.startswith("#")]
    assert len(set(anchors)) == len(anchors)
    assert set(re.findall(r"\]\(#(.*?)\)", page)) <= set(anchors)


class Example(BaseModel):
    """A group."""

    length: float = Field(gt=0.0)  # m, of
    # two lines
    name: str = "a, b"  # what it is called
    share: float = 0.5  # -, of all
    bare: float = 0.0


def test_fields_are_read_where_they_are_declared() -> None:
    """A field's comments, over several lines too, give its unit and description, or neither."""
    declared = {field.key: (field.unit, field.text, field.default) for field in fields(Example)}
    assert declared == {
        "length": ("m", "of two lines", REQUIRED),
        "name": ("", "what it is called", "a, b"),
        "share": ("-", "of all", 0.5),
        "bare": ("", "", 0.0),
    }
    assert split_comment("m/s² more, or less") == ("", "m/s² more, or less") and split_comment(
        "N; in all"
    ) == (
        "N",
        "in all",
    )


OVERHEAD: dict[str, Any] = {"crane": "overhead", "duration": 1.0, "trolley": {"mass": 5.0}}
SPATIAL = OVERHEAD | {"dimensions": 3, "bridge": {"mass": 9.0}}
LINKS = {"lengths": [1.5, 0.7], "node_masses": [0.5, 10.0]}
ELASTIC = LINKS | {"model": "elastic", "stiffness": 1e5}
HOIST = {"hoist": {"drive": "force", "inertia": 4.0}}
POSTURES = {
    "knuckle": (0.0, 0.5, 0.2, 2.0, 0.0, 0.0),
    "bridge": (0.0, 0.0, 4.0, 0.0, 0.0, 0.6, 0.0, -0.8, 1.0, 0.0, 0.0, 0.0),
    "pendulum": (0.0, 0.0, 0.0, 0.6, 0.0, -0.8),
}
X, Y, Z = np.eye(3)
SPRING, BENDING = {"stiffness": 3e8}, {"lateral_deflection": Y, "vertical_deflection": Z}
LINK = {"link_2_x": X, "link_2_y": Y, "link_2_z": Z}
UNMOVED = {
    ("gantry", "trolley"),
    ("gantry", "bridge"),
    ("gantry", "hoist"),
    ("bridge", "bridge_drive_k"),
}
"""Joints whose change does not move the load, as (crane, joint)."""
DIRECTIONS = {  # of the payload, for a small positive change of the joint
    "knuckle": {
        "slew": Y,
        "boom": Z,
        "jib": Z,
        "rope": -Z,
        "swing_tangential": Y,
        "swing_radial": X,
    },
    "tower": {
        "slew": Y,
        "trolley": X,
        "rope": -Z,
        "swing_tangential": Y,
        "swing_radial": X,
        **BENDING,
    },
    "mast": {"slew": Y, "trolley": X, "rope": -Z, "mast_x_deflection": -Y, "mast_y_deflection": X},
    "mobile": {
        "slew": Y,
        "boom": Z,
        "telescope": X,
        "rope": -Z,
        "swing_tangential": Y,
        "swing_radial": X,
        **BENDING,
    },
    "bridge": {
        "trolley": X,
        "bridge": Y,
        "rope": -Z,
        "swing_tangential": Y,
        "swing_radial": X,
        **LINK,
    },
    "gantry": {"payload_x": X, "payload_y": Y, "payload_z": Z},
    "pendulum": {"tip_x": X, "tip_y": Y, "tip_z": Z, "link_1_x": X, "link_1_y": Y, "link_1_z": Z},
    "plane": {"trolley": X, "hoist": -Z, "swing_1": X, "swing_2": X},
    "space": {
        "trolley": X,
        "bridge": Y,
        "link_1_x": X,
        "link_1_y": Y,
        "link_1_z": Z,
        "link_2_x": X,
    },
    "elastic": {"node_2_x": X, "node_2_y": Y, "node_2_z": Z},
}
SCENES: dict[str, tuple[Any, ...]] = {  # scene and changes
    "knuckle": ("knuckle_setpoint",),
    "tower": ("tower_flexible_jib",),
    "mast": ("tower_sway",),
    "mobile": ("mobile_lift", {"flexibility": {"lateral": SPRING, "vertical": SPRING}}),
    "bridge": ("bridge_hook_and_sling",),
    "gantry": ("port_sts_container",),
    "pendulum": ("pendulum_free",),
    "plane": (OVERHEAD | HOIST | {"cable": LINKS},),
    "space": (SPATIAL | {"cable": LINKS, "initial": {"directions": [[0.6, 0.0, -0.8]]}},),
    "elastic": (SPATIAL | {"cable": ELASTIC},),
}
BASE_DIRECTIONS = {"surge": X, "sway": Y, "heave": Z, "roll": Z, "pitch": -Z, "yaw": Y}
"""Of a payload on the y axis for roll, else on the x axis, for a small positive motion of the
base."""


@cache
def scene_of(name: str) -> Scene:
    """Return a scene of SCENES."""
    return load_scene(*SCENES[name])


def payload(name: str, q: Any, changes: dict[str, Any] | None = None) -> np.ndarray:
    """Return the payload's position (3,) in the world."""
    scene = scene_of(name) if changes is None else load_scene(scene_of(name).to_dict() | changes)
    return world_points(scene.model, 0.0, np.array(q, dtype=float), np.zeros(len(q)))[0][-1]


def test_no_sign_is_left_out() -> None:
    """Every joint of every crane, and every motion of the base, is in the page and tried below."""
    tried = {("base", name) for name in BASE_DIRECTIONS}
    for name, directions in DIRECTIONS.items():
        crane = (
            "overhead"
            if name in ("plane", "space", "elastic")
            else "tower"
            if name == "mast"
            else name
        )
        tried |= {
            (crane, re.sub(r"_\d", "_k", joint) if crane != "pendulum" else joint)
            for joint in directions
        }
        assert set(directions) <= set(scene_of(name).joint_names)
    assert tried | UNMOVED == {(sign.crane, sign.joint) for sign in SIGNS}


@pytest.mark.parametrize("name", DIRECTIONS)
def test_positive_is_where_the_page_says(name: str) -> None:
    """A small positive change of a joint moves the payload in the direction of the page."""
    q = np.array(POSTURES.get(name, scene_of(name).initial_q), dtype=float)
    for joint, direction in DIRECTIONS[name].items():
        changed = q.copy()
        changed[scene_of(name).joint_names.index(joint)] += 1e-3
        moved = payload(name, changed) - payload(name, q)
        assert moved @ direction > 1e-4, joint  # lengths of 0.7 m and more, changed by 1e-3


def test_zero_is_where_the_page_says() -> None:
    """At zero boom and jib are horizontal along x, cables hang, origins are those of the page."""
    support = scene_of("knuckle").model.support
    assert payload("knuckle", [0, 0, 0, 2, 0, 0]) == pytest.approx(
        [support.boom.length + support.jib.length, 0, -2]
    )
    assert payload("pendulum", [0, 0, 0, 0, 0, -1]) == pytest.approx(
        [0, 0, -scene_of("pendulum").model.cable.length]
    )
    assert payload("plane", [0, 1.5, 0, 0]) == pytest.approx([0, 0, -2.2])
    assert payload("space", [0, 0, 0, 0, -1, 0, 0, -1]) == pytest.approx([0, 0, -2.2])
    assert payload("elastic", [5, 6, 0, 0, -1, 1, 2, -3]) == pytest.approx([1, 2, -3])


def test_swing_of_a_knuckle_crane_is_the_pages_formula() -> None:
    """The payload is where the page's formula of the two swing angles puts it, at any slew."""
    slew, boom, jib, rope, t1, t2 = q = (0.7, 0.5, -0.2, 2.0, 0.4, -0.3)
    support = scene_of("knuckle").model.support
    out, left = np.array([cos(slew), sin(slew), 0]), np.array([-sin(slew), cos(slew), 0])
    reach = support.boom.length * cos(boom) + support.jib.length * cos(jib)
    height = support.boom.length * sin(boom) + support.jib.length * sin(jib)
    swing = sin(t2) * out + cos(t2) * sin(t1) * left - cos(t2) * cos(t1) * Z
    assert payload("knuckle", q) == pytest.approx(reach * out + height * Z + rope * swing)


@pytest.mark.parametrize("motion", BASE_DIRECTIONS)
def test_base_moves_as_the_page_says(motion: str) -> None:
    """A small positive motion of the base moves a payload in the direction of the page."""
    q = (pi / 2, 0, 0, 0.1, 0, 0) if motion == "roll" else (0, 0, 0, 0.1, 0, 0)
    still, moved = (
        payload(
            "knuckle",
            q,
            {"base_motion": {motion: {"amplitude": 0.0, "frequency": 1.0, "offset": offset}}},
        )
        for offset in (0.0, 1e-3)
    )
    assert (moved - still) @ BASE_DIRECTIONS[motion] > 0.99e-3  # 1 mm, or 1 mrad on 9 m


def test_base_yaws_then_pitches_then_rolls() -> None:
    """The base's axes in the world are Rz(yaw) Ry(pitch) Rx(roll), as on the page."""
    angles, q = {"yaw": 0.5, "pitch": 0.3, "roll": -0.4}, (0.3, 0.4, 0.1, 2.0, 0.1, 0.2)
    base = {
        name: {"amplitude": 0.0, "frequency": 1.0, "offset": angle}
        for name, angle in angles.items()
    }
    (sy, cy), (sp, cp), (sr, cr) = ((sin(angle), cos(angle)) for angle in angles.values())
    rotation = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    rotation = (
        rotation
        @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    )
    assert payload("knuckle", q, {"base_motion": base}) == pytest.approx(
        rotation @ payload("knuckle", q)
    )
