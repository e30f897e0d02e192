"""The page of the cranes of ports and sites: its drawings."""

import numpy as np
import pytest
from urdf_kinematics import forward

from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.evaluation.documentation.drawing import Robot
from crane_sim.evaluation.documentation.scenes_page import PORTS_AND_SITES, format_figures

pytestmark = pytest.mark.interpreted


@pytest.mark.parametrize("name", PORTS_AND_SITES)
def test_links_are_where_the_urdf_puts_them(name: str) -> None:
    """Every link is drawn where forward kinematics of the document by another program has it, at random joints."""
    scene = load_scene(name)
    document, random = urdf(scene), np.random.default_rng(3)
    robot = Robot(document)
    moved = scene.initial_q + random.normal(0.0, 0.3, len(scene.initial_q))
    joints = dict(zip(scene.joint_names, moved.tolist(), strict=True))
    for link in ("payload_link", "trolley_link", "node_1"):
        if f'<link name="{link}"' in document:
            assert robot.link_pose(link, joints)[:3, 3] == pytest.approx(forward(document, joints, link), abs=1e-12)
    corners = np.concatenate([face.corners for face in robot.polygons(joints)])
    assert np.isfinite(corners).all() and np.ptp(corners, axis=0).min() > 0.0


def test_figures_that_a_run_lacks_are_left_out() -> None:
    """A line of figures has what the summary has, with units."""
    assert format_figures({"sim_time": 3.0, "peak_swing_deg": 1.2345}) == "3 s · largest swing 1.23 °"
