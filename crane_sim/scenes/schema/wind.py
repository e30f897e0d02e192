"""The group `wind` of a scene file: a mean by height, and gusts."""

from collections.abc import Mapping
from math import cos, log, sin
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, NonNegative, Positive, Seed
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.groups import Group, tagged_union_validator
from crane_sim.trajectories.turbulence import (
    SPECTRA,
    Band,
    Spectrum,
    band_of,
    beyond,
    default_cut_off,
    draw_gust,
    line_energies,
)
from crane_sim.trajectories.wind import Gust, Kink, LogarithmicLaw, PowerLaw, Wind

COMPONENTS = ("along the mean", "across it", "upwards")
SLOWEST, FASTEST = 0.01, 200.0  # m/s
TOLERANCE = 0.01  # of a spectrum above its formula, beyond which the summary warns
Speed = Annotated[NonNegative, Field(le=FASTEST)]
Intensity = Annotated[NonNegative, Field(le=10.0)]
Height = Annotated[Positive, Field(ge=0.01, le=1e4)]
Length = Annotated[Positive, Field(ge=0.01, le=1e6)]
Profile = Annotated[
    Any,
    tagged_union_validator(
        "law", {"power": PowerLaw, "logarithmic": LogarithmicLaw}, optional=True
    ),
]


class GustGroup(Group):
    """Gusts of three components: sinusoids of random phases with a spectrum of turbulence.

    They do not depend on the place, and repeat after a period that is longer than the run where it
    can be.
    """

    spectrum: Literal["kaimal", "dryden", "von_karman"]  # Kaimal as in IEC 61400-1; the others as
    # in MIL-HDBK-1797
    intensity: Intensity | None = None  # -, standard deviation along the mean over the mean speed;
    # the other two components in the standard's ratio to it: 0.8 and 0.5 of Kaimal's
    deviations: tuple[Speed, Speed, Speed] | None = None  # m/s, in place of `intensity`: standard
    # deviations along the mean, across it, upwards
    lengths: tuple[Length, Length, Length] | None = None  # m, length scales of the components, as
    # the standard defines them; left out: the standard's at `wind.height`
    cut_off: Positive | None = None  # Hz, highest frequency: what is beyond is added below, so that
    # the variance stays, and the summary warns where that is more than 1 %; left out: of each
    # component the frequency with 0.8 % beyond it
    seed: Seed | None = None  # -, of the phases; left out: the scene's own

    def scales(self, speed: float, height: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return (standard deviations [m/s], length scales [m]) of the components.

        Args:
            speed: mean at the reference height [m/s].
            height: the reference height [m].

        Raises:
            SceneError: settings are missing or contradict each other.
        """
        spectrum = SPECTRA[self.spectrum]
        if (self.intensity is None) == (self.deviations is None):
            raise SceneError("wind.gusts: take either intensity or deviations, one of the two")
        if speed < SLOWEST and (speed > 0.0 or self.deviations is not None):
            raise SceneError(
                f"wind.gusts: a mean of {SLOWEST:g} m/s or more carries them, here wind.speed = "
                f"{speed:g}"
            )
        low, high = spectrum.heights
        if not low <= height <= high and None in (self.deviations, self.lengths):
            raise SceneError(
                f"wind.height = {height:g}: the scales of {self.spectrum} are known from {low:g} "
                f"to {high:g} m; "
                "give wind.gusts.deviations and wind.gusts.lengths"
            )
        along = (self.intensity or 0.0) * speed
        deviations = self.deviations or tuple(along * ratio for ratio in spectrum.ratios(height))
        return deviations, self.lengths or spectrum.lengths(height)

    def draw(
        self, speed: float, height: float, seed: int, duration: float
    ) -> tuple[Gust | None, Gust | None, Gust | None]:
        """Return the components for a run of `duration` [s]; `seed` is for gusts without one.

        Raises:
            SceneError: settings contradict each other.
        """
        deviations, lengths = self.scales(speed, height)
        own, spectrum, gusts = (
            seed if self.seed is None else self.seed,
            SPECTRA[self.spectrum],
            list[Any](),
        )
        for i, (deviation, length) in enumerate(zip(deviations, lengths, strict=True)):
            gusts.append(None)
            if deviation > 0.0:
                band = self._band(spectrum, i, length / speed, duration)
                energies = line_energies(spectrum, i, length / speed, band)
                gusts[i] = draw_gust(energies, deviation, band, np.random.default_rng((own, 1 + i)))
        return gusts[0], gusts[1], gusts[2]

    def _band(self, spectrum: Spectrum, component: int, scale: float, duration: float) -> Band:
        cut_off = self.cut_off or default_cut_off(spectrum, component) / scale
        try:
            return band_of(scale, cut_off, duration)
        except ValueError as error:
            raise SceneError(f"wind.gusts.cut_off = {cut_off:g}: {error}") from None

    def notes(
        self, speed: float, height: float, seed: int, gusts: tuple[Gust | None, ...]
    ) -> dict[str, Any]:
        """Return (what was drawn, for the summary, with warnings); arguments of `draw`."""
        lengths, warnings = self.scales(speed, height)[1], []
        for i, (gust, length) in enumerate(zip(gusts, lengths, strict=True)):
            if gust is not None and self.cut_off is not None:
                part = beyond(SPECTRA[self.spectrum], i, self.cut_off * length / speed)
                more = part / (1.0 - part)
                if more > TOLERANCE:
                    warnings.append(
                        f"wind.gusts.cut_off = {self.cut_off:g}: {100.0 * part:.3g} % of the "
                        f"variance {COMPONENTS[i]} "
                        f"is beyond; below it the spectrum is {100.0 * more:.3g} % above its "
                        "formula"
                    )
        drawn = [0.0 if gust is None else float(np.std(gust.nodes[:, 0])) for gust in gusts]
        periods = [None if gust is None else len(gust.nodes) / gust.rate for gust in gusts]
        entry = {
            "seed": seed if self.seed is None else self.seed,
            "deviations": drawn,
            "lengths": list(lengths),
        }
        return {"gusts": entry | {"repeat_after": periods}, "warnings": warnings}


class WindGroup(Group):
    """Wind on bodies with a `windage`, by ½ ρ C A |v| v, v being relative to the body.

    The speed 0 is no wind at all, as if group and windages were absent.
    """

    speed: Speed  # m/s, mean at the height `height`
    direction: Angle = 0.0  # rad, where the mean blows to, counter-clockwise from x of the world: 0
    # along x, 90 deg along y; cranes in the plane take the force's part in their plane
    height: Height = 10.0  # m, reference height above the ground, of `speed` and of the scales of
    # gusts
    profile: Profile = None  # the mean by height; left out: the same at all heights
    origin_height: Annotated[NonNegative, Field(le=1e4)] = 0.0  # m, of the world's origin above the
    # ground
    density: Annotated[Positive, Field(le=100.0)] = 1.225  # kg/m³, of the air
    gusts: GustGroup | None = None  # turbulence; left out: the wind is steady

    def check_ground(self, height: float) -> None:
        """Raise SceneError where the mean is by height and the payload is below ground.

        The payload is `height` [m] above the origin.
        """
        if self.profile is not None and self.origin_height + height < 0.0:
            raise SceneError(
                f"wind.origin_height = {self.origin_height:g}: the payload starts {-height:.4g} m "
                "below the origin, "
                "in the ground, where wind.profile has no mean"
            )

    def wind(self, seed: int, duration: float, kinked: bool = False) -> Wind:
        """Return the wind in a run of `duration` [s]; `seed` is for gusts without one.

        Where it is `kinked`, steps end where the payload passes the lowest height of the profile.

        Raises:
            SceneError: settings contradict each other.
        """
        law = self.profile
        if isinstance(law, LogarithmicLaw) and not log(self.height / law.roughness) > 0.0:
            raise SceneError(
                f"wind.profile.roughness = {law.roughness:g}: must be less than height = "
                f"{self.height:g}"
            )
        if law is not None and self.height < law.lowest:
            lowest = f"wind.profile.lowest = {law.lowest:g}, below which the mean is the same"
            raise SceneError(f"wind.height = {self.height:g}: must not be less than {lowest}")
        gusts = (None, None, None)
        if self.gusts is not None:
            gusts = self.gusts.draw(self.speed, self.height, seed, duration)
        direction = (cos(self.direction), sin(self.direction))
        kink = Kink() if kinked else None
        return Wind(
            self.speed, self.height, law, direction, self.origin_height, self.density, gusts, kink
        )

    def notes(self, wind: Wind, seed: int) -> dict[str, Any]:
        """Return the summary's entry on the wind: settings, what was drawn, and warnings."""
        entry: dict[str, Any] = {"speed": self.speed, "direction": self.direction}
        if self.gusts is None:
            return {"wind": entry}
        drawn = self.gusts.notes(self.speed, self.height, seed, wind.gusts)
        warnings = drawn.pop("warnings")
        return {"wind": entry | drawn} | ({"warnings": warnings} if warnings else {})


def blows(
    group: WindGroup | None, windages: Mapping[str, AnyWindage | None], still_drag: bool
) -> bool:
    """Return whether a wind presses on anything.

    Args:
        group: the wind, None without.
        windages: of the bodies, by key of the scene.
        still_drag: whether the payload has a drag of still air.

    Raises:
        SceneError: there is a windage without wind, wind without a windage, or a drag of still air
            besides.
    """
    present = {key: windage for key, windage in windages.items() if windage is not None}
    if group is None:
        if present:
            raise SceneError(
                f"{next(iter(present))}: is for wind, and there is none; leave it out, or give a "
                "wind of speed 0"
            )
        return False
    if not present:
        raise SceneError(f"wind: presses on nothing; give one of {', '.join(windages)}")
    if group.gusts is not None:
        group.gusts.scales(group.speed, group.height)
    active = group.speed > 0.0 and any(
        part[0] * part.drag_coefficient > 0.0 for part in present.values()
    )  # area, or width
    if still_drag and active:
        raise SceneError(
            "payload_drag: is drag of still air, and there is a wind; take payload.windage in its "
            "place"
        )
    return active
