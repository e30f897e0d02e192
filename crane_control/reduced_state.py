"""Joint coordinates for a law whose nominal cable has fewer links than the crane's."""

from crane_sim.numerics.jit import kernel


@kernel
def get_or_zero(values, i, n):
    """Return entry i of n nominal joint coordinates, where the crane's own are `values`, at least n of them.

    The last one is the mean of the crane's remaining ones: of the swing angles of a cable. For links of equal length
    that is, to first order, the payload's direction seen from the trolley, in which the cable's own waves hardly show:
    they stay as they are. Growth of waves in linearised loops of LQR and energy law (two and ten undamped links, 2 to
    1000 kg of payload, continuous or 10 ms): at most 0.02 1/s with the mean, and that only where the cable, which the
    law does not model, is as heavy as the payload; up to 7 1/s with the first link's angle (LQR, heavy payloads; for
    light ones it damps waves); up to 7 1/s with the last link's (both laws, most cranes).
    """
    if i < n - 1:
        return values[i]
    total = 0.0
    for k in range(n - 1, len(values)):
        total = total + values[k]
    return total / (len(values) - n + 1)
