"""The law of these examples: springs and dampers that carry the crane of knuckle_setpoint."""

from collections.abc import Sequence
from math import cos, radians

TARGET = {"slew": radians(45), "boom": radians(45), "jib": 0.0, "rope": 1.5}  # rad; the rope in m
KP = {"slew": 60.0, "boom": 400.0, "jib": 120.0, "rope": 4.0}  # N m/rad, N/m
KD = {"slew": 120.0, "boom": 400.0, "jib": 120.0, "rope": 4.0}  # N m s/rad, N s/m
G, BOOM, JIB, M_BOOM, M_JIB, LOAD = 9.81, 5.0, 4.0, 2.0, 3.0, 1.0  # m/s², m, m, kg


def effort(
    names: Sequence[str], position: Sequence[float], velocity: Sequence[float]
) -> list[float]:
    """Return what the joints of TARGET exert [N m, N] at positions and velocities by `names`."""
    q, v = dict(zip(names, position, strict=True)), dict(zip(names, velocity, strict=True))
    weight = {
        "slew": 0.0,
        "boom": G * BOOM * cos(q["boom"]) * (M_BOOM / 2 + M_JIB + LOAD),
        "jib": G * JIB * cos(q["jib"]) * (M_JIB / 2 + LOAD),
        "rope": -G * LOAD,  # paying out is positive: the winch pulls
    }
    return [
        weight[joint] + KP[joint] * (TARGET[joint] - q[joint]) - KD[joint] * v[joint]
        for joint in TARGET
    ]
