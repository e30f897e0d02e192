"""The group `base_motion` of a scene file: how the base of a crane moves."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from crane_sim.base_motions import AXES, Base, SplineBase
from crane_sim.explain import SceneError
from crane_sim.forms.base_table import peak_notes, spline_base
from crane_sim.forms.groups import Group
from crane_sim.quantities import Angle, NonNegative, Positive, Real, Seed, Tilt, no_switch
from crane_sim.seas import BREAKING, Response, Sea, Waves, answered, largest_observed, sampled, steepness

PEAKED = 3.3  # gamma of a JONSWAP spectrum that names none, the mean of the measured ones
MOST = 1000  # sinusoids of a sea, and of an axis
LARGEST = 1e6  # m, rad, rad/s: accelerations stay numbers of the machine
Amount = Annotated[Real, Field(ge=-LARGEST, le=LARGEST)]
Turn = Annotated[Angle, Field(ge=-LARGEST, le=LARGEST)]
Lean = Annotated[Tilt, Field(ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[NonNegative, Field(le=LARGEST)]


class Sway(Group):
    """offset + amplitude sin(frequency t + phase) along an axis."""

    amplitude: Amount  # m
    frequency: NotNegative  # rad/s
    phase: Turn = 0.0  # rad
    offset: Amount = 0.0  # m


class Roll(Group):
    """offset + amplitude sin(frequency t + phase) about an axis."""

    amplitude: Lean  # rad
    frequency: NotNegative  # rad/s
    phase: Turn = 0.0  # rad
    offset: Lean = 0.0  # rad


def _listed(value: Any) -> Any:
    return (value,) if isinstance(value, dict) else value


Sways = Annotated[tuple[Sway, ...], BeforeValidator(_listed), Field(max_length=MOST)]
Rolls = Annotated[tuple[Roll, ...], BeforeValidator(_listed), Field(max_length=MOST)]


class Answer(Group):
    """How a motion of the vessel answers a wave, over frequency; a number stands for the same at all of them."""

    frequencies: Annotated[tuple[NotNegative, ...], Field(min_length=1)]  # rad/s, increasing
    amplitudes: Annotated[tuple[NotNegative, ...], Field(min_length=1)]  # m/m, of angles rad/m
    phases: tuple[Turn, ...] | None = None  # rad, by which the motion leads the wave; 0 when left out

    def table(self, name: str) -> Response:
        """Return the table of the axis `name`.

        Raises:
            SceneError: its columns do not fit together.
        """
        count, phases = len(self.frequencies), self.phases or (0.0,) * len(self.frequencies)
        where = f"base_motion.sea.response.{name}"
        for column, values in (("amplitudes", self.amplitudes), ("phases", phases)):
            if len(values) != count:
                raise SceneError(f"{where}.{column}: has {len(values)} values, frequencies has {count}")
        if any(later <= sooner for sooner, later in zip(self.frequencies, self.frequencies[1:], strict=False)):
            raise SceneError(f"{where}.frequencies = {list(self.frequencies)}: must increase")
        return Response(self.frequencies, self.amplitudes, phases)


def _constant(value: Any) -> Any:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return {"frequencies": (0.0,), "amplitudes": (value,)} if plain else value


Answered = Annotated[Answer | None, BeforeValidator(_constant)]


class Answers(Group):
    """How the vessel answers a wave, axis by axis; absent axes do not move."""

    surge: Answered = None
    sway: Answered = None
    heave: Answered = None
    roll: Answered = None
    pitch: Answered = None
    yaw: Answered = None


class SeaGroup(Group):
    """A sea, and how the vessel answers it; without a response the base heaves as the water does."""

    spectrum: Literal["jonswap", "pierson_moskowitz"] = "jonswap"
    significant_height: NotNegative  # m
    peak_period: Annotated[Positive, Field(ge=1.0 / LARGEST, le=LARGEST)]  # s
    gamma: Annotated[Real, Field(ge=1.0, le=10.0)] | None = None  # of jonswap
    components: Annotated[int, BeforeValidator(no_switch), Field(ge=1, le=MOST)] = 60
    seed: Seed | None = None  # the scene's own when left out
    response: Answers | None = None

    def motions(self, seed: int) -> dict[str, Waves]:
        """Return the sinusoids of each axis that moves.

        Raises:
            SceneError: settings contradict each other.
        """
        waves = sampled(self._sea(), self.components, seed if self.seed is None else self.seed)
        response = (
            Answers(heave=Answer(frequencies=(0.0,), amplitudes=(1.0,))) if self.response is None else self.response
        )
        given = {name: getattr(response, name) for name in AXES}
        return {name: answered(waves, answer.table(name)) for name, answer in given.items() if answer is not None}

    def _sea(self) -> Sea:
        """Return the sea.

        Raises:
            SceneError: settings contradict each other, or its waves would break.
        """
        peaked = self.spectrum == "jonswap"
        if self.gamma is not None and not peaked:
            raise SceneError(f"base_motion.sea.gamma = {self.gamma}: belongs to jonswap, here it is {self.spectrum}")
        sea = Sea(self.significant_height, self.peak_period, 1.0 if not peaked else self.gamma or PEAKED)
        if steepness(sea) > BREAKING:
            most = sea.significant_height * BREAKING / steepness(sea)
            raise SceneError(
                f"base_motion.sea.significant_height = {sea.significant_height:g}: such waves break; at a peak period "
                f"of {sea.peak_period:g} s at most {most:.3g} m are possible, a seventh of the wave's length"
            )
        return sea

    def notes(self) -> dict[str, Any]:
        """Return a warning when the sea is steeper than any that was measured."""
        sea = self._sea()
        most = largest_observed(sea.peak_period)
        if steepness(sea) <= most:
            return {}
        line = (
            f"base_motion.sea: its steepness is 1/{1.0 / steepness(sea):.3g}; at a peak period of "
            f"{sea.peak_period:g} s measured seas stay below 1/{1.0 / most:.3g}"
        )
        return {"warnings": [line]}


class BaseMotion(Group):
    """How the base moves: sinusoids along and about its axes, a sea, both together, or a file."""

    surge: Sways = ()
    sway: Sways = ()
    heave: Sways = ()
    roll: Rolls = ()
    pitch: Rolls = ()
    yaw: Rolls = ()
    sea: SeaGroup | None = None
    file: str | None = None  # CSV: time, and any of surge, sway, heave [m], roll, pitch, yaw [rad]
    cut_off: Positive | None = None  # Hz, of the low pass of a file's rows; None: none

    def base(self, seed: int, duration: float) -> Base | SplineBase:
        """Return the motion of the base, for a run of `duration` [s]; a sea without its own seed takes `seed`.

        Raises:
            SceneError: settings contradict each other, or the file cannot be used.
        """
        if self.file is not None:
            others = [name for name in (*AXES, "sea") if getattr(self, name)]
            if others:
                raise SceneError(f"base_motion.{others[0]}: the file tells the whole motion; leave out one of the two")
            return spline_base(self.file, duration, self.cut_off)
        if self.cut_off is not None:
            raise SceneError(f"base_motion.cut_off = {self.cut_off:g}: smooths the rows of a file, and there is none")
        return self._sum(self.sea.motions(seed) if self.sea is not None else {})

    def notes(self, base: Any, duration: float) -> dict[str, Any]:
        """Return what the summary says of the motion `base` that this group came to, over `duration` [s]."""
        if self.file is not None:
            return peak_notes(f"base_motion.file = {self.file!r}", base, duration)
        return self.sea.notes() if self.sea is not None else {}

    def _sum(self, sea: dict[str, Waves]) -> Base:
        none = Waves(np.empty(0), np.empty(0), np.empty(0))
        width = max(len(getattr(self, name)) + len(sea.get(name, none).amplitudes) for name in AXES)
        table, offsets = np.zeros((3, 6, width)), np.zeros(6)
        for i, name in enumerate(AXES):
            own, waves = getattr(self, name), sea.get(name, none)
            offsets[i] = sum(part.offset for part in own)
            for row, key in enumerate(("amplitude", "frequency", "phase")):
                column = [*(getattr(part, key) for part in own), *waves[row]]
                table[row, i, : len(column)] = column
        return Base(offsets, *table)
