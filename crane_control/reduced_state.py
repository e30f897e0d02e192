"""Joint coordinates for a law whose nominal cable has fewer links than the crane's."""


def nominal_coordinate(values, i, n):
    """Return nominal joint coordinate i of n from the crane's own `values`, at least n of them.

    The last one is the mean of the crane's remaining ones: of the swing angles of a cable. For
    links of equal length that is, to first order, the payload's direction seen from the trolley.
    The mean hardly contains the cable's bending modes, so its feedback neither damps nor excites
    them. Largest real part of their eigenvalues in linearised loops of LQR and energy law (two and
    ten undamped links, 2 to 1000 kg of payload, continuous or 10 ms):
    - with the mean 0.02 1/s, where the cable, which the law does not model, is as heavy as the
      payload;
    - with the first link's angle 7 1/s (LQR, heavy payloads; for light ones it damps the modes);
    - with the last link's angle 7 1/s (both laws, most cranes).
    """
    if i < n - 1:
        return values[i]
    total = 0.0
    for k in range(n - 1, len(values)):
        total = total + values[k]
    return total / (len(values) - n + 1)
