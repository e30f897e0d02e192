"""Plots of quantities that have one component a joint: one plot for each unit, because a plot has one axis."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.layout import label
from crane_sim.recording.quantities import COMMANDS, EFFORTS, ERROR, RATES, drawn_unit

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from crane_sim.recording.layout import Array, Layout


class UnitPlot(NamedTuple):
    """The components of a quantity that share a unit."""

    entity: str
    title: str  # with the unit
    names: tuple[str, ...]  # of the joints
    coordinates: tuple[int, ...]  # of the joints, in the order of q: they have the joint's colour
    columns: list[int]  # among the components of the quantity
    convert: Callable[[Array], Array]  # from SI to the unit that is shown


class JointQuantity(NamedTuple):
    """A quantity with one component for each of some coordinates."""

    name: str  # beginning of its entities
    coordinates: Sequence[int]
    units: Sequence[str]  # of the components, SI
    titles: Mapping[str, str]  # by unit

    def plots(self, layout: Layout) -> list[UnitPlot]:
        """Return its plots, in the order in which their units come first."""
        return [self._of_unit(layout, unit) for unit in dict.fromkeys(self.units)]

    def _of_unit(self, layout: Layout, unit: str) -> UnitPlot:
        columns = [i for i, own in enumerate(self.units) if own == unit]
        coordinates = tuple(self.coordinates[i] for i in columns)
        shown, _ = drawn_unit(unit)
        word = shown.replace("°", "deg").replace("/", "_").replace("²", "2").replace(" ", "")
        names = tuple(label(layout.joints[i]) for i in coordinates)
        convert = np.asarray if shown == unit else np.degrees
        return UnitPlot(
            f"shown/{self.name}_{word}", f"{self.titles[unit]} [{shown}]", names, coordinates, columns, convert
        )


def errors(layout: Layout) -> list[UnitPlot]:
    """Return the plots of the tracking errors of the actuated joints."""
    units = [layout.units[i] for i in layout.driven]
    return JointQuantity("error", layout.driven, units, dict.fromkeys(units, ERROR)).plots(layout)


def rates(layout: Layout) -> list[UnitPlot]:
    """Return the plots of the rates of the coordinates that are plotted."""
    units = [f"{layout.units[i]}/s" for i in layout.moving]
    return JointQuantity("rate", layout.moving, units, RATES).plots(layout)


def efforts(layout: Layout) -> list[UnitPlot]:
    """Return the plots of the efforts applied."""
    return JointQuantity("effort", layout.driven, layout.effort_units, EFFORTS).plots(layout)


def commands(layout: Layout) -> list[UnitPlot]:
    """Return the plots of what is commanded."""
    return JointQuantity("command", layout.driven, layout.command_units, COMMANDS).plots(layout)
