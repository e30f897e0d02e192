"""Units of the figures of a summary, in which people read them: angles in degrees."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from crane_sim.recording.run import Crane

UNITS = {
    "sim_time": "s",
    "wall_time": "s",
    "settling_time": "s",
    "min_rope_tension": "N",
    "max_rope_tension": "N",
    "max_lead_line_tension": "N",
    "max_drum_torque": "N m",
    "peak_contact_force": "N",
    "tracking_mse": "m²",
    "tracking_mae": "m",
    "tracking_peak": "m",
    "peak_tip_acceleration": "m/s²",
}
"""Units of plain figures; those whose names end in `_deg` are angles."""
_OF_POSITIONS, _OF_EFFORTS = ("final_error", "limit_margin"), ("peak_effort",)


class FigureUnit(NamedTuple):
    """How a figure is shown: what it is called, its unit, and the factor from the summary's number to it."""

    label: str
    unit: str
    factor: float


def figure_unit(name: str, crane: Crane) -> FigureUnit:
    """Return how a figure NAME, or NAME.JOINT, of a crane's summary is shown."""
    key, _, joint = name.partition(".")
    label = " ".join([key.removesuffix("_deg").replace("_", " "), *[joint] * bool(joint)])
    if key.endswith("_deg"):
        return FigureUnit(label, "deg", 1.0)
    if key in _OF_POSITIONS:
        return FigureUnit(label, *shown_unit(dict(zip(crane.joint_names, crane.joint_units, strict=True))[joint]))
    if key in _OF_EFFORTS:
        return FigureUnit(label, dict(zip(crane.actuated, crane.effort_units, strict=True))[joint], 1.0)
    return FigureUnit(label, UNITS.get(key, ""), 1.0)


def shown_unit(unit: str) -> tuple[str, float]:
    """Return (unit in which people read a quantity, its factor): angles in degrees."""
    return (unit.replace("rad", "deg"), degrees(1.0)) if unit.startswith("rad") else (unit, 1.0)
