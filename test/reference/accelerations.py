"""Accelerations of thirty links below a payload 1e8 times a node, in 60 digits.

Run as python test/reference/accelerations.py. Lagrange's equations with the dense mass matrix in
absolute angles, whose condition number is beyond double precision. Writes
config/references/accelerations.json.
"""

import json
from pathlib import Path

import mpmath
import numpy as np

TARGET = Path(__file__).parents[2] / "config" / "references" / "accelerations.json"
GRAVITY, TROLLEY, LINKS, RATIO = 9.81, 5.0, 30, 1e8


def accelerations(
    m: list[float], lengths: list[float], q: list[float], v: list[float], force: float
) -> list[float]:
    """Return the accelerations of trolley and angles."""
    n = len(m)
    with mpmath.workdps(60):
        mass, right = mpmath.matrix(n + 1), mpmath.matrix(n + 1, 1)
        below = [mpmath.fsum(m[i:]) for i in range(n)]
        a, w, length = ([mpmath.mpf(x) for x in row] for row in (q[1:], v[1:], lengths))
        mass[0, 0], right[0] = mpmath.mpf(TROLLEY) + below[0], mpmath.mpf(force)
        for j in range(n):
            mass[0, j + 1] = mass[j + 1, 0] = below[j] * length[j] * mpmath.cos(a[j])
            right[0] += below[j] * length[j] * mpmath.sin(a[j]) * w[j] ** 2
            right[j + 1] = -mpmath.mpf(GRAVITY) * below[j] * length[j] * mpmath.sin(a[j])
            for k in range(n):
                shared = below[max(j, k)] * length[j] * length[k]
                mass[j + 1, k + 1] = shared * mpmath.cos(a[j] - a[k])
                right[j + 1] -= shared * mpmath.sin(a[j] - a[k]) * w[k] ** 2
        return [float(x) for x in mpmath.lu_solve(mass, right)]


def main() -> None:
    """Write ten random states of one crane with their accelerations."""
    rng = np.random.default_rng(8)
    lengths, masses = rng.uniform(0.5, 1.5, LINKS).tolist(), [0.1] * (LINKS - 1) + [0.1 * RATIO]
    states = []
    for _ in range(10):
        q, v = [0.3, *rng.uniform(-1, 1, LINKS).tolist()], rng.normal(0, 1, LINKS + 1).tolist()
        states.append(
            {"q": q, "v": v, "u": [7.0], "acceleration": accelerations(masses, lengths, q, v, 7.0)}
        )
    cable = {"lengths": lengths, "node_masses": masses}
    scene = {"crane": "overhead", "duration": 1.0, "trolley": {"mass": TROLLEY}, "cable": cable}
    TARGET.write_text(json.dumps({"scene": scene, "states": states}) + "\n")


if __name__ == "__main__":
    main()
