"""The same tree as a model of Pinocchio."""

from typing import Any

import numpy as np
import pinocchio

from crane_sim.multibody.tree import Tree


def to_pinocchio(tree: Tree) -> Any:
    """Return the model; a joint that counts in the other sense has its axis reversed."""
    model = pinocchio.Model()
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    numbers: list[int] = []
    for i, joint in enumerate(tree.joints):
        parent = 0 if joint.parent < 0 else numbers[joint.parent]
        axis = np.eye(3)[joint.axis] * (-1.0 if joint.reverse else 1.0)
        kind = (
            pinocchio.JointModelPrismaticUnaligned
            if joint.slides
            else pinocchio.JointModelRevoluteUnaligned
        )
        place = pinocchio.SE3(np.eye(3), np.array(joint.offset))
        numbers.append(model.addJoint(parent, kind(axis), place, f"joint_{i}"))
        for body in joint.bodies:
            inertia = pinocchio.Inertia(body.mass, np.array(body.centre), np.array(body.inertia))
            model.appendBodyToJoint(numbers[-1], inertia, pinocchio.SE3.Identity())
    return model
