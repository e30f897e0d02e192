"""A scene in motion, one control period at a time: what `simulate` and the plant node both step."""

import copy
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.files.errors import SceneError, shorten, unknown_key
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.columns import stack_columns
from crane_sim.simulation.derived import world_points
from crane_sim.simulation.hardware import HardwareRun
from crane_sim.simulation.initial_state import (
    make_initial,
    restart_under_drives,
    restart_within_step,
    resume,
    with_initial,
)
from crane_sim.simulation.metrics import Metrics
from crane_sim.simulation.status import SimulationError, check_status, events_of, noted_events
from crane_sim.stepping.periods import (
    RunUnderWay,
    StoredIntegration,
    continuous_step,
    entries,
    zero_order_hold_step,
)
from crane_sim.stepping.rows import row_width

__all__ = ["Plant", "SimulationError", "check_status", "events_of", "noted_events"]

BLOCK = 512
# rad/s or m/s, below which a joint counts as at rest: a swinging payload still deflects its brake
SLOW = 5e-3
RESTED = 0.1  # s


class Plant:
    """The plant of a scene, from its initial state onwards.

    Attributes:
        k: control periods passed.
        q, v: joint positions and velocities (nq,), in the order of scene.joint_names.
        rates_before: velocities (nq,) at the start of the last period.
        seen: (q, v) as the scene's sensors measure them, the true ones where it has none.
        applied: efforts applied at the start of the last period (nu,), after limits and brakes.
        faults: names of the faults that the scene may have.
    """

    def __init__(self, scene: Scene, picklable: bool = False) -> None:
        """Put the crane in its initial state.

        Args:
            scene: what moves.
            picklable: whether it can be pickled, at the price of the memory of all states of the
                run; it can be copied by `copy.deepcopy` in any case.

        Raises:
            SceneError: there is something else than a Scene.
        """
        if not isinstance(scene, Scene):
            raise SceneError(
                f"scene = {shorten(scene)}: must be a Scene, as `crane_sim.load_scene` returns"
            )
        self.scene, self._picklable = scene, picklable
        self._hold_step, self._follow_step = (
            zero_order_hold_step.with_own_calls(),
            continuous_step.with_own_calls(),
        )
        self._driven = [scene.joint_names.index(name) for name in scene.actuated]
        self.faults: tuple[str, ...] = scene.hardware.names if scene.hardware is not None else ()
        self.reset()

    def reset(self, q: Sequence[float] | None = None, v: Sequence[float] | None = None) -> None:
        """Return to t = 0 in the given or the scene's initial state, and forget the run.

        Args:
            q: joint positions (nq,), the scene's own when left out.
            v: joint velocities (nq,), likewise.

        Raises:
            SceneError: the crane cannot be in that state; the plant is unchanged.
        """
        # the scene with the state that this run began in
        self._start = scene = with_initial(self.scene, q, v)
        self.seen: tuple[tuple[float, ...], tuple[float, ...]]
        integration, self.q, self.v, self.seen, self._hardware = make_initial(scene)
        # the integration that ended within the period that begins, until one succeeds
        self._failed: Any = None
        self.rates_before = self.v
        self.k, self._flushed, self._saturated, self._still, self._braking = 0, 0, 0, 0, False
        # the last step was one under the scene's own source: it may have passed the period
        self._has_followed = False
        self.applied: tuple[float, ...] = (0.0,) * len(scene.actuated)
        rows = np.empty((BLOCK, row_width(scene.model, len(self.q), len(self.applied))))
        self._run = RunUnderWay(
            scene.method,
            scene.model,
            _stored(integration),
            scene.period,
            scene.steps,
            rows,
            scene.initial_q,
        )
        self._metrics = Metrics(scene, scene.model, integration.x, self._picklable)

    def __copy__(self) -> "Plant":
        """Return a plant of its own in the same state: its arrays are not shared."""
        return copy.deepcopy(self)

    @property
    def model(self) -> Any:
        """The crane's parameters at present."""
        return self._run.p

    @property
    def t(self) -> float:
        """Time [s] since the scene's start."""
        return self.k * self.scene.period

    @property
    def payload(self) -> tuple[float, float, float]:
        """Position of the payload in the world [m]."""
        nodes, _ = world_points(self.scene.model, self.t, np.array(self.q), np.array(self.v))
        return tuple(nodes[-1].tolist())

    @property
    def integration(self) -> Any:
        """The integration under way, with its counters of evaluations and steps."""
        return self._run.integration.load(self.k)

    @property
    def saturated(self) -> int:
        """Periods in which a command was limited."""
        return self._saturated + (self._hardware.saturated if self._hardware is not None else 0)

    @property
    def braking(self) -> bool:
        """Whether brakes hold all actuated joints, and drives are off, from the next period on."""
        return self._braking

    @braking.setter
    def braking(self, on: bool) -> None:
        if on == self._braking:
            return
        hardware = self._prepare_brakes()
        hardware.brake(on)
        self._braking, self._still = on, 0

    def _prepare_brakes(self) -> HardwareRun:
        """Return the hardware with brakes that may act from now on.

        They do work within a period: the model needs a meter.
        """
        if self._hardware is None:
            self._hardware = HardwareRun(self._start)
            self._hardware.set_initial_effort(self.applied)
        if self.model.energy_meter is None:
            self._flush()
            metered = system.with_meter(self.model, False)
            integration = resume(metered, self.integration, self.t, self.q, self.v)
            self._run = self._run._replace(p=metered, integration=_stored(integration))
            self._change_metrics(self._hardware)
        return self._hardware

    def _change_metrics(self, hardware: HardwareRun, energy: float = 0.0) -> None:
        """Continue the metrics with the present model and payload.

        The payload's change supplied `energy` [J].
        """
        of_payload = partial(hardware.model_with_payload, mass=hardware.payload_mass)
        scene = replace(self._start, model=of_payload(self.scene.model))
        self._metrics.change(scene, of_payload(self.model), self.q, energy)

    @property
    def at_rest(self) -> bool:
        """Whether the actuated joints rest, or, while the brakes hold, have rested for a while."""
        if self._braking:
            return self._still * self.scene.period >= RESTED
        return self._rests()

    def _rests(self) -> bool:
        return all(abs(self.v[i]) < SLOW for i in self._driven)

    def set_fault(self, name: str, on: bool) -> None:
        """Activate or clear a fault from the next period on, whatever its schedule.

        Raises:
            ValueError: there is no such fault; the message is one line.
        """
        if self._hardware is None or name not in self.faults:
            known = unknown_key(name, self.faults, "fault")
            raise ValueError(
                known if self.faults else f"unknown fault {name!r}: the scene has none"
            )
        if on and self._hardware.applies_brake(name):
            self._prepare_brakes()
        self._hardware.override_fault(name, on)

    def advance(self, u: Sequence[float] | None = None) -> None:
        """Integrate over one control period.

        Args:
            u: efforts (nu,) held over the period; None when the equations evaluate the scene's own
                source. While the brakes hold, they are ignored.

        Raises:
            ValueError: there are not nu efforts, or none for a scene without a source; the message
                is one line.
            SimulationError: the integration failed; the plant stays at the start of the period.
        """
        reached, (q, v), measured, applied = self._integrate(self._take_efforts(u))
        if not reached:
            self._failed = self._run.integration.load(self.k + 1)
            check_status(self._failed, self.model)
        self._failed, self._has_followed = None, u is None
        self.rates_before, self.q, self.v, self.seen, self.applied = self.v, q, v, measured, applied
        self.k += 1
        self._still = self._still + 1 if self._braking and self._rests() else 0
        if self.k % BLOCK == 0:
            self._flush()

    def _take_efforts(self, u: Sequence[float] | None) -> tuple[float, ...] | None:
        if u is None:
            if self.scene.sampled and not self._braking:
                raise ValueError(
                    f"u: is missing; scene {self.scene.name} takes efforts every period"
                )
            return None
        try:
            count = len(u)
        except TypeError:
            message = f"u = {shorten(u)}: must be a number for each actuated joint: (x,), a tuple"
            raise ValueError(message) from None
        if count != len(self._driven):
            driven = ", ".join(self.scene.actuated) or "none"
            raise ValueError(
                f"u = {shorten(u)}: has {count} values; joints that take efforts: {driven}"
            )
        return tuple(map(float, u))

    def _integrate(self, u: tuple[float, ...] | None) -> tuple[bool, Any, Any, tuple[float, ...]]:
        """Return (whether the period's end was reached, (q, v), (q, v) as seen, efforts)."""
        if self._hardware is not None:
            return self._integrate_with_hardware(self._hardware, u)
        if u is None:
            reached, joints, applied, u = self._follow_step(self._run, self.scene.source, self.k)
        else:
            if self._has_followed:
                self._restart_at_period()
            reached, joints, applied = self._hold_step(self._run, u, self.k)
        self._saturated += applied != u
        return reached, joints, joints, applied

    def _restart_at_period(self, mass: float = 0.0) -> None:
        """Restart at the period's start if a step of the scene's own source has passed it.

        Args:
            mass: of the payload in that step [kg], where a fault may change it.
        """
        method, integration = self.scene.method, self.integration
        if integration.t <= self.t:
            return
        if (drives := self._hardware) is None:
            restarted = restart_within_step(
                method, self.model, self.scene.source, integration, self.t
            )
        else:
            crane = drives.model_with_payload(self.model, mass)
            restarted = restart_under_drives(
                method, crane, drives.state, drives.inputs, integration, self.t
            )
        self._run.integration.store(self.k, restarted)

    def _integrate_with_hardware(
        self, hardware: HardwareRun, u: tuple[float, ...] | None
    ) -> tuple[bool, Any, Any, tuple[float, ...]]:
        driven = (
            (None, u)
            if u is not None
            else (hardware.inputs, hardware.open_loop_command(self.t, self.q, self.v))
        )
        mass, energy = hardware.payload_mass, hardware.payload_energy
        if self._has_followed and u is not None:
            self._restart_at_period(mass)
        reached, joints, measured, applied = hardware.step(self._run, *driven, self.k)
        if hardware.payload_mass != mass:
            if not reached:  # the next attempt begins with the other payload
                self._restart_at_period(mass)
            self._flush()
            self._change_metrics(hardware, hardware.payload_energy - energy)
        return reached, joints, measured if self.scene.hardware is not None else joints, applied

    def _flush(self) -> None:
        """Let the metrics take the periods that have passed since the last time."""
        t = np.arange(self._flushed, self.k, dtype=np.float64) * self.scene.period
        first = self._flushed % BLOCK
        self._metrics.extend(t, self._run.rows[first : first + len(t)])
        self._flushed = self.k

    def summary(self) -> dict[str, Any]:
        """Return the run's metrics up to now: keys and meanings of `Metrics.summary`."""
        self._flush()
        ended = self.integration if self._failed is None else self._failed
        metrics = self._metrics.summary(self.t, self.q, self.v, ended, self.saturated)
        further = self._hardware.summary() if self._hardware is not None else {}
        return metrics | noted_events(ended, self.model, self.t, self._failed is not None) | further


def _stored(integration: Any) -> StoredIntegration:
    """Return an integration at its start, in arrays."""
    log = integration.event_log
    columns = stack_columns([entries(integration)] * 2)
    return StoredIntegration(columns, None if log is None else log.rows, integration.scratch)
