"""Links that have a moment of inertia: then a link also carries a force across, and its turning is an unknown too."""

import numpy as np

from crane_sim.jit import lean_generic, lean_kernel, routine
from crane_sim.overhead.chain import (
    ACROSS,
    ALONG,
    BELOW,
    COS,
    LENGTH,
    RATE,
    SIN,
    TENSION,
    TURNING,
    Rods,
    bends,
    rod_pull,
    solve_links,
)


@lean_generic
def rod_energy(rods, rates):
    """Return the kinetic energy [J] of turning links."""
    return 0.0


@rod_energy.register(Rods)
def _(rods, rates):
    energy = 0.0
    for k in range(len(rates)):
        energy += 0.5 * rods.inertia[k] * rates[k] ** 2
    return energy


@rod_pull.register(Rods)
def _(rods, w):
    return rods.inertia[0] / w[LENGTH, 0] * w[TURNING, 0] * w[COS, 0]


@solve_links.register(Rods)
def _(rods, w, top):
    solve_pairs(rods.inertia, w, top)


@lean_kernel
def coupling(w, inertia, k, j):
    """Return the 2 x 2 block, by rows, by which (tension, turning) of link j act on link k across the node between."""
    node = min(k, j)
    along, across, arm = w[ALONG, node], w[ACROSS, node], inertia[j] / w[LENGTH, j]
    across = across if j > k else -across
    return -along, across * arm, -across, -along * arm


@lean_kernel
def own(w, inertia, top, k):
    """Return the 2 x 2 block, by rows, of link k's own (tension, turning)."""
    arm, length = inertia[k] / w[LENGTH, k], w[LENGTH, k]
    if k > 0:
        ease = w[BELOW, k - 1] + w[BELOW, k]
        return ease, 0.0, 0.0, ease * arm + length
    give, pay, _, _ = top
    s, c, ease = w[SIN, 0], w[COS, 0], w[BELOW, 0]
    return ease + s * s * give + pay, s * c * give * arm, s * c * give, (ease + c * c * give) * arm + length


@lean_kernel
def sought(w, top, k):
    """Return the right-hand sides of link k: along it and across it."""
    along, across = w[TENSION, k], w[TURNING, k]
    if k > 0:
        return along, across
    _, _, run, rate = top
    return along - run, across - 2.0 * rate * w[RATE, 0]


@routine
def solve_pairs(inertia, w, top):
    """Eliminate 2 x 2 blocks downwards, substitute upwards; arguments as of `chain.solve_links`."""
    n = w.shape[1] - 1
    right = np.zeros((n, 4))  # the inverse of an eliminated block times the one right of it
    bends(w)
    for k in range(n):
        a, b, c, d = own(w, inertia, top, k)
        along, across = sought(w, top, k)
        if k > 0:
            e, f, g, h = coupling(w, inertia, k, k - 1)
            a, b = a - e * right[k - 1, 0] - f * right[k - 1, 2], b - e * right[k - 1, 1] - f * right[k - 1, 3]
            c, d = c - g * right[k - 1, 0] - h * right[k - 1, 2], d - g * right[k - 1, 1] - h * right[k - 1, 3]
            along = along - e * w[TENSION, k - 1] - f * w[TURNING, k - 1]
            across = across - g * w[TENSION, k - 1] - h * w[TURNING, k - 1]
        inverse = 1.0 / (a * d - b * c)
        w[TENSION, k], w[TURNING, k] = (d * along - b * across) * inverse, (a * across - c * along) * inverse
        if k + 1 < n:
            e, f, g, h = coupling(w, inertia, k, k + 1)
            right[k, 0], right[k, 1] = (d * e - b * g) * inverse, (d * f - b * h) * inverse
            right[k, 2], right[k, 3] = (a * g - c * e) * inverse, (a * h - c * f) * inverse
    for k in range(n - 2, -1, -1):
        along, across = w[TENSION, k + 1], w[TURNING, k + 1]
        w[TENSION, k] -= right[k, 0] * along + right[k, 1] * across
        w[TURNING, k] -= right[k, 2] * along + right[k, 3] * across
