"""Bags of runs without ROS, as a recorder writes them."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from mcap_samples import TOPICS

from crane_sim.recording.layout import layout_of_scene, text_properties
from crane_sim.recording.mcap.bag import Bag
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec
from crane_sim.simulation.rollout import Rollout

TOPICS_OF_RUN = TOPICS | {
    "joint_commands": TOPICS["applied_effort"]._replace(name="/knuckle/joint_commands")
}


def properties_of(run: Rollout) -> dict[str, str]:
    """Return the properties of a run."""
    return text_properties(layout_of_scene(run.scene, ""))


def write_bag(
    path: Path,
    run: Rollout,
    properties: Mapping[str, str] | None = None,
    leave_out: str = "",
    save_every: int = 10_000,
    foreign: bytes = b"",
) -> Path:
    """Write the messages of a run into a bag.

    Args:
        path: of the bag.
        run: what is written.
        properties: of the run; None: its own.
        leave_out: a topic without messages.
        save_every: steps in a chunk.
        foreign: a message of other bytes among the commands, empty for none.
    """
    scene = run.scene
    bag = Bag(
        path,
        TOPICS_OF_RUN,
        scene.period_ns,
        properties=properties_of(run) if properties is None else properties,
    )
    callbacks = bag.callbacks() | ({leave_out: lambda _: None} if leave_out else {})
    states, efforts = (
        JointStateCodec(scene.joint_names, STATE),
        JointStateCodec(scene.actuated, EFFORT),
    )
    for k in range(len(run.t)):
        stamp = (k + 1) * scene.period_ns
        callbacks["joint_states"](
            states.encode(stamp, run.q[k], run.v[k], np.zeros(len(scene.joint_names)))
        )
        if k < len(run.commands):
            callbacks["joint_commands"](efforts.encode(stamp, run.commands[k]))
            callbacks["applied_effort"](efforts.encode(stamp, run.u[k]))
        if (k + 1) % save_every == 0:
            bag.save()
    if foreign:
        callbacks["joint_commands"](foreign)
    bag.finish({"steps": len(run.t) - 1})
    return path
