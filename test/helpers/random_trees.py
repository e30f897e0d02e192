"""Random trees of joints and bodies, and random states of them."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.models.supports.support import Mechanism
from crane_sim.multibody.tree import Body, Joint, Point, Tree


class RandomStructure(NamedTuple):
    """A structure of a support that is any tree."""

    tree: Tree

    def mechanism(self) -> Mechanism:
        """Return the tree, every joint with a drive of its own."""
        n = len(self.tree.joints)
        return Mechanism(self.tree, limits=(None,) * n, actuated=tuple(range(n)), yaw=())


def random_tree(rng: np.random.Generator, n: int) -> Tree:
    """Return a tree of n joints of all kinds, with branches, offsets and bodies off their axes."""
    joints: list[Joint] = []
    # the base, and the joints between it and the last one: branches are numbered one after the
    # other
    below = [-1]
    for i in range(n):
        del below[int(rng.integers(1, len(below) + 1)) :]
        joints.append(random_joint(rng, below[-1], i))
        below.append(i)
    return Tree(tuple(joints), Point(n - 1, vector(rng)))


def random_joint(rng: np.random.Generator, parent: int, coordinate: int) -> Joint:
    """Return a joint on the link of another one, or on the base (-1)."""
    bodies = tuple(random_body(rng) for _ in range(int(rng.integers(1, 3))))
    axis, slides, reverse = int(rng.integers(3)), bool(rng.random() < 0.4), bool(rng.random() < 0.5)
    return Joint(axis, ((coordinate, 1),), slides, reverse, parent, vector(rng), bodies)


def random_body(rng: np.random.Generator) -> Body:
    """Return a body with a mass, a centre off its link's origin and a full tensor of inertia."""
    m = rng.standard_normal((3, 3))
    inertia = m @ m.T + 0.1 * np.eye(3)
    return Body(float(rng.uniform(0.5, 3.0)), vector(rng), tuple(map(tuple, inertia.tolist())))


def random_state(rng: np.random.Generator, n: int) -> tuple[tuple[float, ...], ...]:
    """Return positions, velocities and efforts (n,)."""
    return tuple(tuple(rng.standard_normal(n).tolist()) for _ in range(3))


def vector(rng: np.random.Generator) -> Any:
    """Return a vector (3,) of numbers of size one."""
    return tuple(rng.standard_normal(3).tolist())
