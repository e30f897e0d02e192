"""The support of ARCHITECTURE.md, a davit: a crane of no catalogue, with a rope and a load."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from point_masses import Extras, Point, accelerations, mpf, mpmath, plus, rod_points, rotate

from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.loads import PointLoad
from crane_sim.models.supports.support import Support
from crane_sim.models.suspended.crane import SuspendedCrane

ROOT = Path(__file__).parents[2]
POST, ARM, LENGTH, INERTIA, ROPE, MASS = 40.0, 30.0, 4.0, 35.0, 2.5, 12.0


def davit(folder: Path) -> Any:
    """Return the structure that the page declares, as a module of its own."""
    text = (ROOT / "ARCHITECTURE.md").read_text()
    block = re.search(r'^```python title="davit.py"\n(.*?)^```$', text, re.MULTILINE | re.DOTALL)
    assert block is not None and block[1].count("\n") < 50
    file = folder / "davit.py"
    file.write_text(block[1])
    names: dict[str, Any] = {"__name__": "davit"}
    exec(compile(block[1], str(file), "exec"), names)
    return names["Davit"](POST, ARM, LENGTH, INERTIA)


def along(q: Any, distance: Any) -> Point:
    """Return the point at a distance up the arm."""
    return rotate(2, q[0], rotate(0, q[1], (mpf(0), mpf(0), distance)))


def places(t: Any, q: Any) -> list[tuple[Any, Point]]:
    """Return all points; coordinates: post, arm, and the rope's azimuth and inclination.

    The inclination is from the downward vertical.
    """
    half = mpmath.sqrt(mpf(POST) / 2)
    points = [(mpf(1), rotate(2, q[0], (side * half, mpf(0), mpf(0)))) for side in (-1, 1)]
    points += [(m, along(q, s)) for m, s in rod_points(mpf(ARM), mpf(INERTIA), mpf(LENGTH) / 2)]
    s = mpmath.sin(q[3])
    down = tuple(ROPE * x for x in (s * mpmath.cos(q[2]), s * mpmath.sin(q[2]), -mpmath.cos(q[3])))
    return [*points, (mpf(MASS), plus(along(q, mpf(LENGTH)), down))]


def test_the_davit_of_the_page_moves_by_virtual_work(tmp_path: Path) -> None:
    """Accelerations of post and arm under efforts are those of point masses, to 1e-12.

    The load swings.
    """
    crane = SuspendedCrane(
        Support(davit(tmp_path)), Chain(np.array([MASS]), np.array([ROPE])), PointLoad(MASS)
    )
    rng = np.random.default_rng(4)
    q, v = np.array([0.4, -0.7, 0.9, 0.5]), rng.uniform(-0.6, 0.6, 4)
    efforts = np.array([20.0, -300.0, 0.0, 0.0])
    expected = accelerations(places, 0.0, q, v, efforts, Extras(np.zeros(4)))
    s, c, sa, ca = np.sin(q[3]), np.cos(q[3]), np.sin(q[2]), np.cos(q[2])
    n = s * ca, s * sa, -c
    rates = c * ca * v[3] - s * sa * v[2], c * sa * v[3] + s * ca * v[2], s * v[3]
    x = np.array([*q[:2], *n, *v[:2], *rates])
    got = system.rhs(crane, 0.0, x, tuple(efforts[:2]))[5:7]
    # rounding, 50 terms
    np.testing.assert_allclose(got, expected[:2], rtol=0.0, atol=1e-12 * abs(expected).max())
