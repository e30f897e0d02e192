"""Links that have a moment of inertia: then a link also carries a force across, and its turning is an unknown too."""

import numpy as np

from crane_sim.jit import kernel, routine
from crane_sim.overhead.chain import Rods, demanded, rod_pull, solve_links


@rod_pull.register(Rods)
def _(rods, links, turning):
    return rods.inertia[0] / links.lengths[0] * turning[0] * links.cosines[0]


@solve_links.register(Rods)
def _(rods, links, top, acc, tension, turning):
    solve_pairs(rods.inertia, links, top, acc, tension, turning)


@kernel
def coupling(links, inertia, k, j):
    """Return the 2 x 2 block, by rows, by which (tension, turning) of link j act on link k across the node between."""
    node = links.below[min(k, j)]
    along = (links.sines[k] * links.sines[j] + links.cosines[k] * links.cosines[j]) * node
    across = (links.cosines[k] * links.sines[j] - links.sines[k] * links.cosines[j]) * node
    arm = inertia[j] / links.lengths[j]
    return -along, across * arm, -across, -along * arm


@kernel
def own(links, inertia, top, k):
    """Return the 2 x 2 block, by rows, of link k's own (tension, turning)."""
    arm, length = inertia[k] / links.lengths[k], links.lengths[k]
    if k > 0:
        ease = links.below[k - 1] + links.below[k]
        return ease, 0.0, 0.0, ease * arm + length
    give, pay, _, _ = top
    s, c, ease = links.sines[0], links.cosines[0], links.below[0]
    return ease + s * s * give + pay, s * c * give * arm, s * c * give, (ease + c * c * give) * arm + length


@kernel
def sought(links, top, acc, k):
    """Return the right-hand sides of link k: along it and across it."""
    along = demanded(links, top, acc, k)
    across = links.cosines[k] * (acc[k + 1, 0] - acc[k, 0]) + links.sines[k] * (acc[k + 1, 2] - acc[k, 2])
    if k > 0:
        return along, across
    _, _, run, rate = top
    return along - run, across - 2.0 * rate * links.rates[0]


@routine
def solve_pairs(inertia, links, top, acc, tension, turning):
    """Eliminate 2 x 2 blocks downwards, substitute upwards; arguments as of `chain.solve_links`."""
    n, blocks = len(tension), np.zeros((len(tension), 4))  # inverse of the eliminated block times the one right of it
    for k in range(n):
        a, b, c, d = own(links, inertia, top, k)
        along, across = sought(links, top, acc, k)
        if k > 0:
            e, f, g, h = coupling(links, inertia, k, k - 1)
            w, x, y, z = blocks[k - 1]
            a, b, c, d = a - e * w - f * y, b - e * x - f * z, c - g * w - h * y, d - g * x - h * z
            along = along - e * tension[k - 1] - f * turning[k - 1]
            across = across - g * tension[k - 1] - h * turning[k - 1]
        inverse = 1.0 / (a * d - b * c)
        tension[k], turning[k] = (d * along - b * across) * inverse, (a * across - c * along) * inverse
        if k + 1 < n:
            e, f, g, h = coupling(links, inertia, k, k + 1)
            blocks[k, 0], blocks[k, 1] = (d * e - b * g) * inverse, (d * f - b * h) * inverse
            blocks[k, 2], blocks[k, 3] = (a * g - c * e) * inverse, (a * h - c * f) * inverse
    for k in range(n - 2, -1, -1):
        w, x, y, z = blocks[k]
        tension[k], turning[k] = (
            tension[k] - w * tension[k + 1] - x * turning[k + 1],
            turning[k] - y * tension[k + 1] - z * turning[k + 1],
        )
