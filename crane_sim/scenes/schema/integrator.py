"""Integration method of a scene: an automatic choice, or its own checked for fast motions."""

from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.files.types import Positive
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.gauss import Gauss
from crane_sim.integrators.gauss16 import Gauss16
from crane_sim.integrators.leapfrog import Leapfrog
from crane_sim.integrators.rodas import Rodas


class Auto(NamedTuple):
    """`rodas` for stiff cables, `gauss` for long horizons, else `dop853`; the summary says why.

    With `rtol`: `rodas` for stiff cables, `gauss16` at 1e-8 and below where nothing is sampled or
    switches and no chain hangs below, else `dop853`.
    """

    rtol: Positive | None = None  # -, relative tolerance, the absolute one is a hundredth of it;
    # left out: the method's


class MethodRequirements(NamedTuple):
    """A scene's requirements on its integration method."""

    frequency: float | None  # rad/s, of the stiffest motion; None: not known
    swing_angle: float  # rad, of the slowest swing over the run
    elastic: bool
    smooth: bool  # nothing switches, nothing has a kink and nothing is sampled
    duration: float  # s
    continuous: bool = False  # a law drives it that the equations evaluate


# rad/s, of springs, from which an implicit method is faster (measured: bench/stiff.py)
STIFF_FREQUENCY = 2e4
# relative tolerance, from which on order 16 in lanes is faster (measured: `crane bench`)
TIGHT = 1e-8
LONG_HORIZON = 1e4  # rad, of swinging, from which a bounded energy error matters more than speed
GAUSS_STEP_FACTOR = 0.08
"""Step of the Gauss method times the frequency: energy errors of 1e-10 (measured: `crane reproduce
hardcases`)."""

MAX_RTOL = 0.1  # relative tolerance, beyond which no digit is right
# relative tolerance, a hundred roundings of a double: below, error estimates are rounding
MIN_RTOL = 2.3e-14
MIN_STEP = 1e-9  # s, the resolution of stamps


def needs_frequency(method: Any) -> bool:
    """Return whether the method depends on the stiffest motion, as without step control."""
    return isinstance(method, Auto) or hasattr(method, "safe_step")


def choose_method(
    method: Any, requirements: MethodRequirements, model: Any = None
) -> tuple[Any, str | None]:
    """Return (method, reason of an automatic choice or None); model None: its state is no array.

    Raises:
        SceneError: a fixed step is too large for the stiffest motion, or a setting is out of range.
    """
    _check_range(method)
    if isinstance(method, Auto):
        return _choice(requirements, method.rtol, system.rhs_into.has_implementation(type(model)))
    largest = getattr(method, "safe_step", None)
    if largest is None or not requirements.frequency:  # without motion any step is safe
        return method, None
    safe = largest(requirements.frequency)
    if method.step > safe:
        raise SceneError(
            f"integrator.step = {method.step:g}: too large for the stiffest motion, "
            f"{requirements.frequency:.4g} rad/s; the largest safe step of this method is "
            f"{safe:.3g} s, "
            "and dop853 chooses its own"
        )
    return method, None


def implicit(method: Any, requirements: MethodRequirements) -> bool:
    """Return whether a scene's method solves linear systems, which takes an array as state."""
    return isinstance(choose_method(method, requirements)[0], Rodas)


def check_fit(method: Any, model: Any, continuous: bool) -> None:
    """Raise SceneError when a method cannot integrate the model's state or take the source."""
    if isinstance(method, Leapfrog) and not system.position_count.has_implementation(type(model)):
        raise SceneError(
            "integrator.method = 'leapfrog': takes overhead cranes of several links; this one "
            "dop853"
        )
    if not isinstance(method, Rodas):
        return
    if not system.rhs_into.has_implementation(type(model)):
        raise SceneError(
            "integrator.method = 'rodas': solves for states that are arrays; this crane takes "
            "dop853"
        )
    if continuous and system.compute_jacobian.has_implementation(type(model)):
        raise SceneError(
            "control.period = 'continuous': method rodas takes sampled laws on this crane; give a "
            "period"
        )


def _check_range(method: Any) -> None:
    rtol, step = getattr(method, "rtol", None) or MAX_RTOL, getattr(method, "step", MIN_STEP)
    if rtol > MAX_RTOL:
        raise SceneError(f"integrator.rtol = {rtol:g}: must be at most {MAX_RTOL:g}")
    if rtol < MIN_RTOL:
        raise SceneError(
            f"integrator.rtol = {rtol:g}: must be at least {MIN_RTOL:g}: a double has 16 digits"
        )
    if getattr(method, "atol", 1.0) == 0.0:
        raise SceneError(
            "integrator.atol = 0: must be greater than 0: what is zero has no relative error"
        )
    if step < MIN_STEP:
        raise SceneError(f"integrator.step = {step:g}: must be at least {MIN_STEP:g} s")


def _choice(
    requirements: MethodRequirements, rtol: float | None, long_state: bool
) -> tuple[Any, str]:
    frequency, tolerances = requirements.frequency, () if rtol is None else (rtol, 0.01 * rtol)
    if (
        frequency is not None
        and requirements.elastic
        and frequency > STIFF_FREQUENCY
        and not requirements.continuous
    ):
        return Rodas(*tolerances), f"rodas: the springs are stiff ({frequency:.3g} rad/s)"
    if rtol is not None and rtol <= TIGHT and requirements.smooth and not long_state:
        return Gauss16(
            *tolerances
        ), "gauss16: a tight tolerance, and nothing switches or is sampled"
    if rtol is not None:
        return DOP853(*tolerances), "dop853: the default where a tolerance is given"
    if (
        frequency
        and requirements.smooth
        and requirements.swing_angle > LONG_HORIZON
        and not requirements.elastic
    ):
        step = GAUSS_STEP_FACTOR / frequency
        return Gauss(
            step
        ), f"gauss with a step of {step:.3g} s: a long horizon ({requirements.duration:g} s)"
    return DOP853(), "dop853: nothing stiff, no long horizon"
