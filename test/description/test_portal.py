"""A gantry crane's drawn structure: in its scene's place, with a boom where the rail is long."""

from xml.etree import ElementTree

import numpy as np
import pytest

from crane_sim import SceneError, load_scene
from crane_sim.description import urdf
from crane_sim.description.falls import (
    HEIGHT,
    LENGTHS,
    WIDTH,
    container_edges,
    portal_of,
    portal_visual,
)
from crane_sim.description.suspended import box_edges

SHIP_TO_SHORE = ("port_sts_container", "set_down_on_deck", "spreader_pick_up", "spreader_skew")


def boxes_of(document: str, link: str) -> list[list[float]]:
    """Return the edges (3,) [m] of the boxes that a link is drawn with."""
    robot = ElementTree.fromstring(document)
    part = next(each for each in robot.iter("link") if each.get("name") == link)
    return [[float(edge) for edge in box.attrib["size"].split()] for box in part.iter("box")]


@pytest.mark.parametrize("name", SHIP_TO_SHORE)
def test_a_ship_to_shore_crane_has_a_boom(name: str) -> None:
    """It has its scene's legs, its boom reaches beyond the trolley's start, its mast is highest."""
    scene = load_scene(name)
    portal, legs = portal_of(scene), scene.to_dict()["legs"]
    assert portal.boom is not None and portal.boom[0] == legs[0]
    root, tip = portal.boom
    assert tip < scene.initial_q[0] < root and portal.ends[1] > legs[1]
    heights = [
        shape.at[2] + 0.5 * shape.size[2] for shape in portal_visual(portal) if len(shape.size) == 3
    ]
    assert max(heights) == pytest.approx(
        portal.top, abs=portal.unit
    ) and portal.top > portal.leg_top + 0.3 * (root - tip)
    # the load passes between the legs
    assert portal.half_span > 0.5 * box_edges(scene.model.load)[1] + 1.0


def test_a_container_has_its_true_size() -> None:
    """The load of 40 ft is drawn as the ISO container near its moments, another box as it is."""
    boxes = boxes_of(urdf(load_scene("port_sts_container")), "payload_link")
    assert [WIDTH, LENGTHS[1], HEIGHT] == pytest.approx(boxes[0], abs=1e-9)
    assert container_edges((2.4, 6.0, 2.4)) == (WIDTH, LENGTHS[0], HEIGHT)
    assert container_edges((2.4, 9.0, 2.4)) == (2.4, 9.0, 2.4)


def test_a_long_load_on_falls_in_a_line_is_a_boat() -> None:
    """A lifeboat is drawn with hull and canopy in the box of its moments, a lug below each fall."""
    scene = load_scene("pendulum_lifeboat")
    x, y, z = box_edges(scene.model.load)
    *boat, bow, stern = np.array(boxes_of(urdf(scene), "payload_link"))
    assert len(boat) == 4 and np.max(boat, axis=0) == pytest.approx([x, y, 0.4 * z]) and x > 2.0 * y
    assert bow.tolist() == stern.tolist() and bow[2] < 0.5 * z


def test_without_legs_or_overhang_it_is_a_bare_portal() -> None:
    """Without legs it stands at its rail's ends; one whose rail ends near them has no boom."""
    plain = portal_of(load_scene("spreader_skew", {"legs": None}))
    assert plain.boom is None and np.ptp(plain.legs) > 0.8 * np.ptp(plain.ends)
    assert portal_of(load_scene("spreader_skew", {"legs": [-20.0, 20.0]})).boom is None


def test_legs_in_the_wrong_order_are_refused() -> None:
    """One line names the key."""
    with pytest.raises(SceneError, match=r"legs.*low < high"):
        load_scene("spreader_skew", {"legs": [20.0, -20.0]})
