"""The URDF of a crane: what robot_state_publisher and RViz draw, and recordings and pages.

Frames follow REP-103: x forward, y left, z up, SI units and radians. The model's own frame is
`base_link`. Below a base that rests it is fixed to the root, `world`; one that moves is the root
itself, since no joint of a URDF may be a given motion: its place in the world is a transform
(`description.transforms`), as for any vehicle (REP-105).
"""

from __future__ import annotations

from crane_sim.description import falls, knuckle, overhead, pendulum, suspended
from crane_sim.description.robot import UNBOUNDED, Robot
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene

IMU = "imu_link"
"""The frame of an inertial measurement unit on the base."""
ABOUT = (
    "masses, centres and inertias are those that are simulated; links without an inertial have "
    "none, nor have motors",
    "every visual is a drawing: its size, shape and position are not those of the simulated crane",
    f"lengths and limits are the scene's; {UNBOUNDED:g} stands for no limit, since a URDF takes no "
    "infinity",
)


def urdf(scene: Scene) -> str:
    """Describe a scene's crane as a URDF document; its free joints are `scene.joint_names`."""
    robot = Robot(f"{scene.crane}_crane", ABOUT)
    if getattr(scene.model, "base", None) is None:
        robot.fix("base", "world", "base_link")
    if scene.crane == "overhead":
        overhead.add_overhead_crane(robot, scene)
    elif scene.crane == "pendulum":
        pendulum.add_pendulum(robot, scene)
    elif isinstance(scene.model, FallsCrane):
        falls.add_crane_on_falls(robot, scene)
    elif isinstance(scene.model, SuspendedCrane):
        suspended.add_suspended_crane(robot, scene)
    else:
        knuckle.add_knuckle_crane(robot, scene.model, scene.joint_names)
    if scene.instruments is not None and scene.instruments.imu is not None:
        robot.fix("imu", "base_link", IMU, scene.instruments.imu.position)
    return robot.finish(scene)
