"""Simulated drives, brakes, sensors and faults of one run.

Brake parameters that a scene does not specify are computed at the initial posture. The static load
is that at the mean of the disturbances (`crane_sim.scenes.averaging`), independent of a sea's state
at t = 0.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.hardware.faults import JOINT_STUCK, SCHEDULED, SENSOR_LOSS, FaultLog
from crane_sim.hardware.ideal_servos import IdealServos
from crane_sim.hardware.payloads import apply_payload_fault
from crane_sim.hardware.random import seed_to_uint64
from crane_sim.hardware.records import TOTALS, ideal_sensors, make_records
from crane_sim.hardware.reference_profiles import PHASES
from crane_sim.hardware.servos import Servos
from crane_sim.hardware.settings import BrakeSettings, HardwareConfig, ideal_hardware
from crane_sim.models.supports.flexible import without_bending
from crane_sim.models.supports.support import Support, trailing_count
from crane_sim.scenes.averaging import average_scene
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.dynamics import energy, joint_acceleration
from crane_sim.simulation.initial_demands import initial_demands
from crane_sim.simulation.status import MAX_EVENTS_IN_SUMMARY
from crane_sim.stepping.hardware_periods import (
    HardwareState,
    hardware_step,
    measure_states,
    sample_first_state,
)
from crane_sim.trajectories.breakpoints import unwrap, with_breakpoints
from crane_sim.trajectories.inputs import delay_inputs

Array = npt.NDArray[np.float64]


HOLDING_FACTOR = 2.0
"""Static loads of the initial posture that a brake can hold."""


BRAKE_DECELERATION = 2.0
"""rad/s² or m/s², deceleration by a brake in addition to the static load, all other joints
locked."""


MAX_JOINT_FREQUENCY = 100.0  # rad/s, of a joint on its brake's spring, all other joints locked


FREQUENCY_MARGIN = 4.0  # of fixed steps: factor of frequency between postures of different inertia


_BREAKAWAY_VELOCITY = 1e-9  # rad/s or m/s: velocity that breaks static friction


class JointMechanics(NamedTuple):
    """The actuated joints at the initial posture, (nu,) each, in units of their efforts."""

    inertia_others_free: Array  # inertia of a joint when all others are free
    inertia_others_locked: Array  # inertia of a joint when all others are locked
    static_load: Array  # efforts that hold the joints at rest


def fit_brakes(drives: Any, scene: Scene) -> None:
    """Write the parameters of the scene's brakes into the records of the drives (nu,)."""
    settings = scene.hardware.brake if scene.hardware is not None else BrakeSettings()
    spring = np.array([unit not in ("m/s", "m") for unit in scene.effort_units], dtype=float)
    drives.position_drive = [unit == "m" for unit in scene.effort_units]
    if not spring.any():
        return
    joints = joint_mechanics(scene)
    stiffness = (
        choose_brake_stiffness(scene, joints)
        if settings.frequency is None
        else joints.inertia_others_free * settings.frequency**2
    )
    drives.stiffness = spring * stiffness
    drives.damping = (
        spring * 2.0 * settings.damping * np.sqrt(stiffness * joints.inertia_others_free)
    )
    drives.capacity = spring * (
        HOLDING_FACTOR * np.abs(joints.static_load)
        + BRAKE_DECELERATION * joints.inertia_others_locked
    )
    if settings.capacity is not None:
        drives.capacity = spring * settings.capacity


def stiffened(model: Any, q: Array) -> tuple[Any, Array]:
    """Return (model, positions) without play of drives and bending, which hide joints' inertia.

    A model without them is returned as it is.
    """
    support = getattr(model, "support", None)
    if not isinstance(support, Support) or not trailing_count(support):
        return model, q
    return model._replace(support=without_bending(support)), q[: -trailing_count(support)]


def joint_mechanics(scene: Scene) -> JointMechanics:
    """Return the properties of the actuated joints at the initial posture."""
    nu = len(scene.actuated)
    actuated = [scene.joint_names.index(name) for name in scene.actuated]
    q, v = np.array(scene.initial_q), np.zeros(len(scene.joint_names))
    v[actuated] = _BREAKAWAY_VELOCITY
    model, places = stiffened(average_scene(scene).model, q)

    def accelerations(u: Any, direction: float = 1.0) -> Array:
        rates = direction * v[: len(places)]
        return np.array(joint_acceleration(model, 0.0, places, rates, tuple(map(float, u))))[
            actuated
        ]

    forwards = accelerations(np.zeros(nu))
    # without dry friction, whatever it holds
    at_rest = 0.5 * (forwards + accelerations(np.zeros(nu), -1.0))
    mobility: Array = np.column_stack([accelerations(unit) - forwards for unit in np.eye(nu)])
    static_load: Array = -np.linalg.lstsq(mobility, at_rest, rcond=None)[0].astype(np.float64)
    free: Array = 1.0 / np.maximum(np.diag(mobility), 1e-12)
    energy_at_rest, units = energy(scene, q, 0.0 * q, frame="base"), np.eye(len(q))[actuated]
    locked = [2.0 * (energy(scene, q, unit, frame="base") - energy_at_rest) for unit in units]
    forces = np.array([unit in ("N", "N m") for unit in scene.effort_units])
    return JointMechanics(free, np.where(forces, np.maximum(locked, free), free), static_load)


def holding_efforts(scene: Scene, config: HardwareConfig) -> Array:
    """Return the efforts (nu,) that hold the crane at rest, at which servo integrals begin."""
    integral = config.servos.stiffness > 0.0
    if not integral.any():
        return np.zeros(len(integral))
    return np.clip(
        integral * joint_mechanics(scene).static_load, config.drives.low, config.drives.high
    )


def choose_brake_stiffness(scene: Scene, joints: JointMechanics) -> Array:
    """Return spring stiffnesses (nu,) low enough for integration step and control period.

    The control period is that of the slip.
    """
    safe_step = getattr(scene.method, "safe_step", None)
    step_limit = (
        np.inf if safe_step is None else safe_step(1.0) / scene.method.step / FREQUENCY_MARGIN
    )
    period_limit = min(MAX_JOINT_FREQUENCY, 1.0 / scene.period)
    return np.minimum(
        joints.inertia_others_locked * period_limit**2, joints.inertia_others_free * step_limit**2
    )


MAX_FAULT_EVENTS = 1000
"""Fault events that are kept."""


class HardwareRun:
    """Drives, brakes, sensors and faults of one run.

    Attributes:
        state: parameters and state, which compiled code takes and changes.
        faults: names of the faults.
        inputs: what the equations evaluate in place of commands: the scene's open-loop inputs,
            behind the delays of drives that do not hold them; None where the scene is commanded.
        initial_demands: see there.
    """

    def __init__(self, scene: Scene) -> None:
        """Prepare the hardware at the start of a run."""
        config: HardwareConfig = scene.hardware or ideal_hardware(
            len(scene.joint_names), len(scene.actuated)
        )
        self._scene, self.faults = scene, config.names
        self._step = hardware_step.with_own_calls()
        self.state = _initial_hardware(scene, config)
        self.initial_demands = initial_demands(scene, config)
        set_initial_demands(
            self.state, np.array([self.initial_demands.get(name, 0.0) for name in scene.actuated])
        )
        self.inputs = None if scene.sampled else _delayed_inputs(scene, self.state)
        self._has_brakes = False
        if config.servos is not None:
            self.state.servos.loops.integral = holding_efforts(scene, config)
        if config.can_stick:
            self._fit_brakes()

    @property
    def _totals(self) -> Any:
        return self.state.totals[0]

    def _fit_brakes(self) -> None:
        if not self._has_brakes:
            fit_brakes(self.state.drives, self._scene)
            self._has_brakes = True

    def brake(self, on: bool) -> None:
        """Apply or release the brakes of all actuated joints, from the next period on."""
        if on:
            self._fit_brakes()
        self._totals.braking = on

    def set_initial_effort(self, efforts: Sequence[float]) -> None:
        """Set the efforts (nu,) that the drives begin with."""
        self.state.drives.start_effort = self.state.drives.delivered_effort = efforts

    def applies_brake(self, name: str) -> bool:
        """Return whether the fault of that name applies a brake."""
        return bool(self.state.faults.kind[self.faults.index(name)] == JOINT_STUCK)

    def override_fault(self, name: str, on: bool) -> None:
        """Activate or clear a fault from the next period on, independent of its schedule."""
        self.state.overrides[self.faults.index(name)] = float(on)

    def sample_first_state(self, model: Any, integration: Any, period: float) -> tuple[Any, Any]:
        """Sample the initial state; return (q, v) as the sensors measure them."""
        return sample_first_state(model, self.state, integration, period)

    def open_loop_command(
        self, t: float, q: tuple[float, ...], v: tuple[float, ...]
    ) -> tuple[float, ...]:
        """Return the value (nu,) of the scene's source at t [s], zero without; drives hold it."""
        source = unwrap(self._scene.source)
        if type(source) is tuple:
            return source
        return (
            (0.0,) * len(self.state.drives)
            if source is None
            else system.compute_command(source, t, q, v)
        )

    def step(self, run: Any, inputs: Any, command: tuple[float, ...], k: int) -> Any:
        """Integrate over period k; arguments and results of `hardware_step`."""
        return self._step(run, self.state, inputs, command, k)

    @property
    def saturated(self) -> int:
        """Periods in which a command was limited."""
        return int(self._totals.saturated)

    @property
    def payload_energy(self) -> float:
        """Energy [J] supplied by changes of the payload."""
        return 0.0 if self.state.payload_fault is None else float(self._totals.payload_energy)

    @property
    def payload_mass(self) -> float:
        """Present mass [kg] of the payload; 0 in scenes without faults of the payload."""
        return 0.0 if self.state.payload_fault is None else float(self._totals.payload_mass)

    def model_with_payload(self, model: Any, mass: float) -> Any:
        """Return the model with a payload of this mass [kg]."""
        return apply_payload_fault(self.state.payload_fault, model, mass)

    def events(self) -> list[dict[str, Any]]:
        """Return times [s] at which faults were activated or cleared."""
        log = self.state.log
        rows = log.rows[: int(log.total[0])].tolist()
        return [{"t": t, "name": self.faults[int(which)], "on": bool(on)} for t, which, on in rows]

    def summary(self) -> dict[str, Any]:
        """Return the entries of the hardware in the run's summary."""
        totals = self._totals
        metrics: dict[str, Any] = (
            {"faults": self.events()[:MAX_EVENTS_IN_SUMMARY]} if self.faults else {}
        )
        metrics |= {"lost_samples": int(totals.lost_samples)} if totals.lost_samples else {}
        metrics |= {"initial_demand": self.initial_demands} if self.initial_demands else {}
        tripped = {
            name: float(drive.overtravel)
            for name, drive in zip(self._scene.actuated, self.state.drives, strict=True)
            if drive.tripped
        }
        metrics |= {"overtravel": tripped} if tripped else {}
        return metrics | (
            {"braked_time": float(totals.braked) * self._scene.period} if totals.braked else {}
        )


def is_sensed(scene: Scene) -> bool:
    """Return whether measurements differ from the truth, or may come to differ."""
    return bool(sensed_coordinates(scene.hardware, len(scene.joint_names)))


def sensed_coordinates(equipment: HardwareConfig | None, nq: int) -> tuple[int, ...]:
    """Return the coordinates whose measurements differ from the truth, or may come to differ.

    Indices 0 .. nq-1 are the positions, nq + i is the velocity of coordinate i.
    """
    if equipment is None:
        return ()
    faulty = equipment.faults.joint[equipment.faults.kind <= SENSOR_LOSS].astype(int)
    real = np.flatnonzero(equipment.sensors != ideal_sensors(nq))
    return tuple(sorted({*real.tolist(), *faulty.tolist(), *(faulty + nq).tolist()}))


def measure(scene: Scene, q: Array, v: Array) -> Array:
    """Return measurements (K, 2 nq) of true states q, v (K, nq) at starts of the first periods.

    Their random numbers are functions of the period's number: these are the very values that the
    law got in the run, whose faults were those of the scene's schedule.
    """
    assert scene.hardware is not None
    measured = np.empty((len(q), 2 * q.shape[1]))
    states = (np.ascontiguousarray(each) for each in (q, v))
    measure_states(_initial_hardware(scene, scene.hardware), scene.period, *states, measured)
    return measured


def set_initial_demands(hardware: HardwareState, demands: Array) -> None:
    """Let the drives begin with the effects of demands (nu,) that were there for long."""
    drives, hardware.queue[:] = hardware.drives, demands
    drives.start_effort = np.clip(
        np.where(np.abs(demands) < drives.deadband, 0.0, demands), drives.low, drives.high
    )


def _delayed_inputs(scene: Scene, hardware: HardwareState) -> Any:
    """Return the scene's source behind the delays of drives that do not hold its values."""
    drives, before = hardware.drives, hardware.queue[0].tolist()
    delays = np.where(drives.has_state, 0, drives.delay) * scene.period
    if not delays.any() or type(scene.source) is tuple:
        return scene.source
    return with_breakpoints(
        delay_inputs(unwrap(scene.source), delays.tolist(), before), scene.model
    )


def _initial_servos(scene: Scene, loops: Any) -> Servos | None:
    """Return the servo drives at the start of a run; None if all drives are commanded efforts."""
    if loops is None:
        return None
    own = np.flatnonzero(loops.ideal)
    joints = np.array([scene.joint_names.index(scene.actuated[i]) for i in own])
    ideal = IdealServos(own, joints) if len(own) > 0 else None
    return Servos(loops.copy(), np.zeros((len(loops), PHASES, 4)), ideal)


def _initial_hardware(scene: Scene, config: HardwareConfig) -> HardwareState:
    """Return the hardware at the start of a run."""
    drives, sensors, n = config.drives, config.sensors, len(config.names)
    totals = make_records(TOTALS, 1)
    totals.payload_mass = (
        config.payload_fault.nominal_mass if config.payload_fault is not None else 0.0
    )
    return HardwareState(
        seed=seed_to_uint64(scene.seed),
        faults=config.faults,
        payload_fault=config.payload_fault,
        drives=drives.copy(),
        servos=_initial_servos(scene, config.servos),
        queue=np.zeros((1 + int(drives.delay.max(initial=0)), len(drives))),
        sensors=sensors.copy(),
        ring=np.zeros((1 + int(sensors.delay.max(initial=0)), len(sensors))),
        overrides=np.full(n, SCHEDULED),
        active=np.zeros(n),
        log=FaultLog(np.zeros((MAX_FAULT_EVENTS, 3)), np.zeros(1)),
        totals=totals,
    )
