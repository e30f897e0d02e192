"""The group `base_motion` of a scene file: how the base of a crane moves."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from crane_sim.files.errors import PATH, SceneError, shorten
from crane_sim.files.types import (
    Angle,
    Heel,
    NonNegative,
    Positive,
    Real,
    Seed,
    Tilt,
    reject_bool,
)
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.recorded_motion import peak_notes, spline_base
from crane_sim.trajectories.base_motion import (
    AXES,
    AnyBase,
    Base,
    MountedBase,
    SplineBase,
    rotations,
)
from crane_sim.trajectories.waves import (
    BREAKING_STEEPNESS,
    ResponseAmplitudeOperator,
    Sea,
    SineSum,
    apply_response,
    max_observed_steepness,
    sample_sea,
    steepness,
)

PEAKED = 3.3  # gamma of a JONSWAP spectrum that names none, the mean of the measured ones


MAX_SINUSOIDS = 1000  # sinusoids of a sea, and of an axis


LARGEST = 1e6  # m, rad, rad/s: accelerations stay numbers of the machine


Amount = Annotated[Real, Field(ge=-LARGEST, le=LARGEST)]


Turn = Annotated[Angle, Field(ge=-LARGEST, le=LARGEST)]


Lean = Annotated[Heel, Field(ge=-LARGEST, le=LARGEST)]


Heading = Annotated[Tilt, Field(ge=-LARGEST, le=LARGEST)]


NotNegative = Annotated[NonNegative, Field(le=LARGEST)]


class Sway(Group):
    """offset + amplitude sin(frequency t + phase) along an axis."""

    amplitude: Amount  # m, size of the sine
    frequency: NotNegative  # rad/s, of the sine
    phase: Turn = 0.0  # rad, of the sine at t = 0
    offset: Amount = 0.0  # m, added to the sine


class Roll(Group):
    """offset + amplitude sin(frequency t + phase) about an axis."""

    amplitude: Lean  # rad, size of the sine
    frequency: NotNegative  # rad/s, of the sine
    phase: Turn = 0.0  # rad, of the sine at t = 0
    offset: Lean = 0.0  # rad, added to the sine


class Yaw(Group):
    """offset + amplitude sin(frequency t + phase) about the vertical axis."""

    amplitude: Heading  # rad, size of the sine
    frequency: NotNegative  # rad/s, of the sine
    phase: Turn = 0.0  # rad, of the sine at t = 0
    offset: Heading = 0.0  # rad, added to the sine


def _as_list(value: Any) -> Any:
    return (value,) if isinstance(value, dict) else value


Sways = Annotated[tuple[Sway, ...], BeforeValidator(_as_list), Field(max_length=MAX_SINUSOIDS)]


Rolls = Annotated[tuple[Roll, ...], BeforeValidator(_as_list), Field(max_length=MAX_SINUSOIDS)]


Yaws = Annotated[tuple[Yaw, ...], BeforeValidator(_as_list), Field(max_length=MAX_SINUSOIDS)]


class Answer(Group):
    """Response of a motion of the vessel to waves, by frequency; a number is a constant one."""

    frequencies: Annotated[tuple[NotNegative, ...], Field(min_length=1)]  # rad/s, increasing
    amplitudes: Annotated[tuple[NotNegative, ...], Field(min_length=1)]  # -, metres per metre of
    # wave; of roll, pitch, yaw rad per metre
    phases: tuple[Turn, ...] | None = None  # rad, by which the motion leads the wave; left out: 0

    def table(self, name: str) -> ResponseAmplitudeOperator:
        """Return the table of the axis `name`.

        Raises:
            SceneError: its columns do not fit together.
        """
        count = len(self.frequencies)
        phases = self.phases if self.phases is not None else (0.0,) * count
        where = f"base_motion.sea.response.{name}"
        for column, values in (("amplitudes", self.amplitudes), ("phases", phases)):
            if len(values) != count:
                raise SceneError(
                    f"{where}.{column}: has {len(values)} values, frequencies has {count}"
                )
        if any(
            later <= sooner
            for sooner, later in zip(self.frequencies, self.frequencies[1:], strict=False)
        ):
            raise SceneError(f"{where}.frequencies = {list(self.frequencies)}: must increase")
        return ResponseAmplitudeOperator(self.frequencies, self.amplitudes, phases)


def _constant(value: Any) -> Any:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return {"frequencies": (0.0,), "amplitudes": (value,)} if plain else value


Answered = Annotated[Answer | None, BeforeValidator(_constant)]


class Answers(Group):
    """Response of the vessel to a wave, by axis; absent axes do not move."""

    surge: Answered = None  # how it answers; left out: it does not move
    sway: Answered = None  # how it answers; left out: it does not move
    heave: Answered = None  # how it answers; left out: it does not move
    roll: Answered = None  # how it answers; left out: it does not move
    pitch: Answered = None  # how it answers; left out: it does not move
    yaw: Answered = None  # how it answers; left out: it does not move


class SeaGroup(Group):
    """A sea and the vessel's response; without a response the base heaves with the water."""

    spectrum: Literal["jonswap", "pierson_moskowitz"] = "jonswap"  # shape of the spectrum
    significant_height: NotNegative  # m, of the waves, from trough to crest; refused above a
    # seventh of the length of a wave of the peak period, where waves break; a warning above 1/15
    # (up to 8 s) to 1/25 (from 15 s on) of it
    peak_period: Annotated[Positive, Field(ge=1.0 / LARGEST, le=LARGEST)]  # s, of the waves that
    # have the most energy
    gamma: Annotated[Real, Field(ge=1.0, le=10.0)] | None = None  # -, peak enhancement of
    # `jonswap`; left out: 3.3
    components: Annotated[int, BeforeValidator(reject_bool), Field(ge=1, le=MAX_SINUSOIDS)] = (
        60  # -, number of
    )
    # sinusoids, of equal energy, at frequencies drawn at random
    seed: Seed | None = None  # -, of these; left out: the scene's own
    response: Answers | None = None  # how each axis answers a metre of wave; left out: the base
    # heaves as the water does

    def motions(self, seed: int) -> dict[str, SineSum]:
        """Return the sinusoids of each axis that moves.

        Raises:
            SceneError: settings contradict each other.
        """
        waves = self.waves(seed)
        response = (
            Answers(heave=Answer(frequencies=(0.0,), amplitudes=(1.0,)))
            if self.response is None
            else self.response
        )
        curves = {name: getattr(response, name) for name in AXES}
        return {
            name: apply_response(waves, answer.table(name))
            for name, answer in curves.items()
            if answer is not None
        }

    def waves(self, seed: int) -> SineSum:
        """Return the elevation [m] of the water at the vessel; `seed` is for a sea without one."""
        return sample_sea(self._sea(), self.components, seed if self.seed is None else self.seed)

    def _sea(self) -> Sea:
        """Return the sea.

        Raises:
            SceneError: settings contradict each other, or its waves would break.
        """
        peaked = self.spectrum == "jonswap"
        if self.gamma is not None and not peaked:
            raise SceneError(
                f"base_motion.sea.gamma = {self.gamma}: belongs to jonswap, here it is "
                f"{self.spectrum}"
            )
        sea = Sea(
            self.significant_height, self.peak_period, 1.0 if not peaked else self.gamma or PEAKED
        )
        if steepness(sea) > BREAKING_STEEPNESS:
            most = sea.significant_height * BREAKING_STEEPNESS / steepness(sea)
            raise SceneError(
                f"base_motion.sea.significant_height = {sea.significant_height:g}: such waves "
                "break; at a peak period "
                f"of {sea.peak_period:g} s at most {most:.3g} m are possible, a seventh of the "
                "wave's length"
            )
        return sea

    def notes(self) -> dict[str, Any]:
        """Return a warning when the sea is steeper than any that was measured."""
        sea = self._sea()
        most = max_observed_steepness(sea.peak_period)
        if steepness(sea) <= most:
            return {}
        line = (
            f"base_motion.sea: its steepness is 1/{1.0 / steepness(sea):.3g}; at a peak period of "
            f"{sea.peak_period:g} s measured seas stay below 1/{1.0 / most:.3g}"
        )
        return {"warnings": [line]}


class Mount(Group):
    """The place of the base on the vessel, in the vessel's axes: turned by roll, pitch, yaw.

    The lever arm adds to the motion: at r from the vessel's reference point the acceleration is a +
    α × r + ω × (ω × r).
    """

    position: tuple[Amount, Amount, Amount] = (0.0, 0.0, 0.0)  # m, of the base's origin, from the
    # vessel's reference point
    roll: Turn = 0.0  # rad, about x, after the other two turns
    pitch: Turn = 0.0  # rad, about y, after yaw
    yaw: Turn = 0.0  # rad, about z: a crane that looks to port has 90 deg

    def carry(self, vessel: Base | SplineBase) -> MountedBase:
        """Return the motion of the base on a vessel."""
        rows = rotations(np.array([[self.roll, self.pitch, self.yaw]]))[0]
        return MountedBase(vessel, self.position, tuple(map(tuple, rows.tolist())))


class BaseMotion(Group):
    """Motion of the base in the world: sinusoids of its axes, a sea, both together, or a file.

    Joints stay relative to the base. An axis takes one sinusoid or a list of them. Cranes in the
    plane take surge, heave and pitch.
    """

    surge: Sways = ()  # m, along x
    sway: Sways = ()  # m, along y
    heave: Sways = ()  # m, along z
    roll: Rolls = ()  # rad, about x
    pitch: Rolls = ()  # rad, about y
    yaw: Yaws = ()  # rad, about z
    sea: SeaGroup | None = None  # a sea and how the vessel answers it, on top
    file: str | None = None  # CSV with the columns `time` and any of the six, [m] and [rad], in
    # place of all other keys; degrees are columns `roll_deg`, `pitch_deg`, `yaw_deg`, and radians
    # of any size `roll_rad` and so on; a quintic spline through the rows; the summary has the
    # largest accelerations that it means, and warns of more than 4.9 m/s² or 0.5 rad/s²
    cut_off: Positive | None = None  # Hz, of a low pass that the file's rows go through first, to
    # free them of noise: of a frequency f, 1 / (1 + (f / cut_off)⁴) is left, in phase; left out:
    # the rows as they are

    mount: Mount | None = None  # where the crane stands on the vessel whose motion this is; left
    # out: at its reference point, in its axes

    def base(self, seed: int, duration: float) -> AnyBase:
        """Return the motion of the base over `duration` [s]; `seed` is for a sea without one.

        Raises:
            SceneError: settings contradict each other, or the file cannot be used.
        """
        vessel = self._vessel(seed, duration)
        return vessel if self.mount is None else self.mount.carry(vessel)

    def _vessel(self, seed: int, duration: float) -> Base | SplineBase:
        """Return the motion that the keys give; arguments and errors of `base`."""
        if self.file is not None:
            others = [name for name in (*AXES, "sea") if getattr(self, name)]
            if others:
                raise SceneError(
                    f"base_motion.{others[0]}: the file gives the whole motion; leave out one of "
                    "the two"
                )
            return spline_base(self.file, duration, self.cut_off)
        if self.cut_off is not None:
            raise SceneError(
                f"base_motion.cut_off = {self.cut_off:g}: smooths the rows of a file, and there is "
                "none"
            )
        return self._sum(self.sea.motions(seed) if self.sea is not None else {})

    def notes(self, base: Any, duration: float) -> dict[str, Any]:
        """Return the summary's notes on the motion `base` of this group over `duration` [s]."""
        if self.file is not None:
            vessel = base.vessel if isinstance(base, MountedBase) else base
            return peak_notes(f"base_motion.file = {shorten(self.file, PATH)}", vessel, duration)
        return self.sea.notes() if self.sea is not None else {}

    def _sum(self, sea: dict[str, SineSum]) -> Base:
        none = SineSum(np.empty(0), np.empty(0), np.empty(0))
        width = max(len(getattr(self, name)) + len(sea.get(name, none).amplitudes) for name in AXES)
        table, offsets = np.zeros((3, 6, width)), np.zeros(6)
        for i, name in enumerate(AXES):
            axis_motion, waves = getattr(self, name), sea.get(name, none)
            offsets[i] = sum(part.offset for part in axis_motion)
            for row, key in enumerate(("amplitude", "frequency", "phase")):
                column = [*(getattr(part, key) for part in axis_motion), *waves[row]]
                table[row, i, : len(column)] = column
        return Base(offsets, *table)
