"""The hardware of one run, and its figures.

The brakes of a scene in numbers: its own, and what it leaves open computed from the crane at its initial posture.

The static load is that at the mean of what disturbs the crane (`crane_sim.scenes.averaging`), whatever a sea does at t
= 0.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.hardware.faults import AS_PLANNED, Log
from crane_sim.hardware.payloads import with_payload
from crane_sim.hardware.random import word
from crane_sim.hardware.records import TALLY, make_records
from crane_sim.hardware.settings import BrakeSettings, Equipment, no_equipment
from crane_sim.scenes.averaging import average_scene
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.dynamics import energy, joint_acceleration
from crane_sim.stepping.hardware_periods import Hardware, first_sample, hardware_step, read_inputs

Array = npt.NDArray[np.float64]


HOLDING = 2.0
"""Static loads of the initial posture that a brake holds."""


DECELERATION = 2.0
"""rad/s² or m/s², which a brake gives a joint beyond them, with all that it carries."""


FASTEST = 100.0  # rad/s, of a joint with all that it carries on the spring of its brake


MARGIN = 4.0  # of frequencies, between a posture's inertia and another's, where a step cannot adapt


_SLIPPING = 1e-9  # rad/s or m/s: what dry friction holds would answer no effort


class Mechanics(NamedTuple):
    """The actuated joints at the initial posture, (nu,) each, in units of their efforts."""

    free: Array  # inertia of a joint when all others are free
    carried: Array  # inertia when all others are locked
    load: Array  # what holds them at rest


def fit(drives: Any, scene: Scene) -> None:
    """Write the scene's brakes into the records of the drives (nu,)."""
    settings = scene.hardware.brake if scene.hardware is not None else BrakeSettings()
    spring = np.array([unit not in ("m/s", "m") for unit in scene.effort_units], dtype=float)
    drives.follows = [unit == "m" for unit in scene.effort_units]
    if not spring.any():
        return
    joints = mechanics(scene)
    stiffness = stiffness_of(scene, joints) if settings.frequency is None else joints.free * settings.frequency**2
    drives.stiffness = spring * stiffness
    drives.damping = spring * 2.0 * settings.damping * np.sqrt(stiffness * joints.free)
    drives.capacity = spring * (HOLDING * np.abs(joints.load) + DECELERATION * joints.carried)
    if settings.capacity is not None:
        drives.capacity = spring * settings.capacity


def mechanics(scene: Scene) -> Mechanics:
    """Return the properties of the actuated joints at the initial posture."""
    nu = len(scene.actuated)
    places = [scene.joint_names.index(name) for name in scene.actuated]
    q, v = np.array(scene.initial_q), np.zeros(len(scene.joint_names))
    v[places] = _SLIPPING
    model = average_scene(scene).model

    def answer(u: Any) -> Array:
        return np.array(joint_acceleration(model, 0.0, q, v, tuple(map(float, u))))[places]

    at_rest = answer(np.zeros(nu))
    mobility: Array = np.column_stack([answer(unit) - at_rest for unit in np.eye(nu)])
    load: Array = -np.linalg.lstsq(mobility, at_rest, rcond=None)[0].astype(np.float64)
    free: Array = 1.0 / np.maximum(np.diag(mobility), 1e-12)
    rest, units = energy(scene, q, 0.0 * q, frame="base"), np.eye(len(q))[places]
    moving = [2.0 * (energy(scene, q, unit, frame="base") - rest) for unit in units]
    forces = np.array([unit in ("N", "N m") for unit in scene.effort_units])
    return Mechanics(free, np.where(forces, np.maximum(moving, free), free), load)


def stiffness_of(scene: Scene, joints: Mechanics) -> Array:
    """Return springs (nu,) so stiff that references which slip once a period, and the steps, keep up with them."""
    safe = getattr(scene.method, "safe_step", None)
    most = np.inf if safe is None else safe(1.0) / scene.method.step / MARGIN
    wanted = min(FASTEST, 1.0 / scene.period)
    return np.minimum(joints.carried * wanted**2, joints.free * most**2)


LOG = 1000
"""Changes of faults that are kept."""


SHOWN = 20
"""Changes of faults in the summary."""


class HardwareRun:
    """Drives, brakes, sensors and faults of one run.

    Attributes:
        hardware: what kernels take and change.
        faults: names.
    """

    def __init__(self, scene: Scene) -> None:
        """Prepare the hardware at the start of a run."""
        equipment: Equipment = scene.hardware or no_equipment(len(scene.joint_names), len(scene.actuated))
        self._scene, self.faults = scene, equipment.names
        self.hardware = _start_hardware(scene.seed, equipment)
        self._has_brakes = False
        if equipment.can_stick:
            self._fit_brakes()

    @property
    def _tally(self) -> Any:
        return self.hardware.tallies[0]

    def _fit_brakes(self) -> None:
        if not self._has_brakes:
            fit(self.hardware.drives, self._scene)
            self._has_brakes = True

    def brake(self, on: bool) -> None:
        """Apply or release the brakes of all actuated joints, from the next period on."""
        if on:
            self._fit_brakes()
        self._tally.braking = on

    def drive(self, efforts: Sequence[float]) -> None:
        """Let the drives begin with the efforts (nu,) that they have."""
        self.hardware.drives.origin = efforts

    def order(self, name: str, on: bool) -> None:
        """Let a fault be there or not, from the next period on, whatever its times say."""
        self.hardware.orders[self.faults.index(name)] = float(on)

    def look(self, model: Any, flow: Any, period: float) -> tuple[Any, Any]:
        """Let the sensors see the first state; return (q, v) as they show them."""
        return first_sample(model, self.hardware, flow, period)

    def demand(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the efforts (nu,) that the scene's open-loop inputs demand at time t [s]; none while brakes hold."""
        source = self._scene.source
        if type(source) is tuple:
            return source
        if self._tally.braking or source is None:
            return (0.0,) * len(self.hardware.drives)
        return read_inputs(source, t, q, v)

    def step(self, method: Any, model: Any, demand: tuple[float, ...], *rest: Any) -> Any:
        """Pass a period; arguments and results are as of `hardware_step`."""
        return hardware_step(method, model, self.hardware, demand, *rest)

    @property
    def saturated(self) -> int:
        """Periods in which a demand was limited."""
        return int(self._tally.limited)

    @property
    def given(self) -> float:
        """Energy [J] that changes of the payload brought."""
        return float(self._tally.payload_energy)

    @property
    def mass(self) -> float:
        """Mass [kg] of the payload that hangs there now; 0 where no fault changes it."""
        return float(self._tally.payload_mass)

    def crane(self, model: Any, mass: float) -> Any:
        """Return the model with a payload of this mass [kg]."""
        return with_payload(self.hardware.payload_fault, model, mass)

    def events(self) -> list[dict[str, Any]]:
        """Return when [s] which fault came or went."""
        log = self.hardware.log
        rows = log.rows[: int(log.total[0])].tolist()
        return [{"t": t, "name": self.faults[int(which)], "on": bool(on)} for t, which, on in rows]

    def summary(self) -> dict[str, Any]:
        """Return what the run's summary has of the hardware."""
        tally = self._tally
        figures: dict[str, Any] = {"faults": self.events()[:SHOWN]} if self.faults else {}
        figures |= {"lost_samples": int(tally.lost_samples)} if tally.lost_samples else {}
        return figures | ({"braked_time": float(tally.braked) * self._scene.period} if tally.braked else {})


def _start_hardware(seed: int, equipment: Equipment) -> Hardware:
    """Return the hardware at the start of a run."""
    drives, sensors, n = equipment.drives, equipment.sensors, len(equipment.names)
    tallies = make_records(TALLY, 1)
    tallies.payload_mass = equipment.payload_fault.mass if equipment.payload_fault is not None else 0.0
    return Hardware(
        seed=word(seed),
        faults=equipment.faults,
        payload_fault=equipment.payload_fault,
        drives=drives.copy(),
        queue=np.zeros((1 + int(drives.delay.max(initial=0)), len(drives))),
        sensors=sensors.copy(),
        ring=np.zeros((1 + int(sensors.delay.max(initial=0)), len(sensors))),
        orders=np.full(n, AS_PLANNED),
        active=np.zeros(n),
        log=Log(np.zeros((LOG, 3)), np.zeros(1)),
        tallies=tallies,
    )
