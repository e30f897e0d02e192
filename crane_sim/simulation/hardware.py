"""The hardware of one run: its memory, and what is told of it.

The brakes of a scene in numbers: its own, and what it leaves open computed from the crane at its initial posture.

The static load is that at the mean of what disturbs the crane (`crane_sim.scenes.averaging`), whatever a sea does at t
= 0.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.hardware.brakes import CAPACITY, DAMPING, FOLLOWS, STIFFNESS
from crane_sim.hardware.drives import DELAY as DRIVE_DELAY
from crane_sim.hardware.drives import ORIGIN
from crane_sim.hardware.faults import AS_PLANNED, Log
from crane_sim.hardware.payloads import with_payload
from crane_sim.hardware.random import word
from crane_sim.hardware.sensors import DELAY
from crane_sim.hardware.settings import BrakeSettings, Equipment, no_equipment
from crane_sim.scenes.averaging import average_scene
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.dynamics import energy, joint_acceleration
from crane_sim.stepping.hardware_periods import (
    BRAKED,
    BRAKING,
    COUNTERS,
    GIVEN,
    LIMITED,
    LOST_SAMPLES,
    MASS,
    Hardware,
    HardwareState,
    first_sample,
    hardware_step,
    read_inputs,
)

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


def fit(board: Any, scene: Scene) -> None:
    """Write the scene's brakes onto a board of drives (DRIVE_ROWS, nu)."""
    settings = scene.hardware.brake if scene.hardware is not None else BrakeSettings()
    spring = np.array([unit not in ("m/s", "m") for unit in scene.effort_units], dtype=float)
    board[FOLLOWS] = [unit == "m" for unit in scene.effort_units]
    if not spring.any():
        return
    joints = mechanics(scene)
    stiffness = stiffness_of(scene, joints) if settings.frequency is None else joints.free * settings.frequency**2
    board[STIFFNESS] = spring * stiffness
    board[DAMPING] = spring * 2.0 * settings.damping * np.sqrt(stiffness * joints.free)
    board[CAPACITY] = spring * (HOLDING * np.abs(joints.load) + DECELERATION * joints.carried)
    if settings.capacity is not None:
        board[CAPACITY] = spring * settings.capacity


def mechanics(scene: Scene) -> Mechanics:
    """Return what the crane's equations tell of its actuated joints at the initial posture."""
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
        hardware, memory: what kernels take.
        faults: names.
    """

    def __init__(self, scene: Scene) -> None:
        """Prepare the hardware at the start of a run."""
        found: Equipment = scene.hardware or no_equipment(len(scene.joint_names), len(scene.actuated))
        self._scene, self.faults = scene, found.names
        self.hardware = Hardware(word(scene.seed), found.faults, found.reload)
        n, nu = len(found.names), found.drives.shape[1]
        books = np.zeros(COUNTERS)
        books[MASS] = found.reload.mass if found.reload is not None else 0.0
        self.memory = HardwareState(
            drives=found.drives.copy(),
            queue=np.zeros((1 + int(found.drives[DRIVE_DELAY].max(initial=0.0)), nu)),
            signals=found.signals.copy(),
            ring=np.zeros((1 + int(found.signals[DELAY].max(initial=0.0)), found.signals.shape[1])),
            orders=np.full(n, AS_PLANNED),
            present=np.zeros(n),
            log=Log(np.zeros((LOG, 3)), np.zeros(1)),
            books=books,
        )
        self._has_brakes = False
        if found.can_stick:
            self._fit_brakes()

    def _fit_brakes(self) -> None:
        if not self._has_brakes:
            fit(self.memory.drives, self._scene)
            self._has_brakes = True

    def brake(self, on: bool) -> None:
        """Apply or release the brakes of all actuated joints, from the next period on."""
        if on:
            self._fit_brakes()
        self.memory.books[BRAKING] = float(on)

    def drive(self, efforts: Sequence[float]) -> None:
        """Let the drives begin with the efforts (nu,) that they have."""
        self.memory.drives[ORIGIN] = efforts

    def order(self, name: str, on: bool) -> None:
        """Let a fault be there or not, from the next period on, whatever its times say."""
        self.memory.orders[self.faults.index(name)] = float(on)

    def look(self, model: Any, flow: Any, period: float) -> tuple[Any, Any]:
        """Let the sensors see the first state; return (q, v) as they show them."""
        return first_sample(model, self.hardware, self.memory, flow, period)

    def demand(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the efforts (nu,) that the scene's open-loop inputs demand at time t [s]; none while brakes hold."""
        source = self._scene.source
        if type(source) is tuple:
            return source
        if self.memory.books[BRAKING] or source is None:
            return (0.0,) * self.memory.drives.shape[1]
        return read_inputs(source, t, q, v)

    def step(self, method: Any, model: Any, demand: tuple[float, ...], *here: Any) -> Any:
        """Pass a period; `here` and what is returned are as of `passing.hardware_step`."""
        return hardware_step(method, model, self.hardware, self.memory, demand, *here)

    @property
    def saturated(self) -> int:
        """Periods in which a demand was limited."""
        return int(self.memory.books[LIMITED])

    @property
    def given(self) -> float:
        """Energy [J] that changes of the payload brought."""
        return float(self.memory.books[GIVEN])

    @property
    def mass(self) -> float:
        """Mass [kg] of the payload that hangs there now; 0 where no fault changes it."""
        return float(self.memory.books[MASS])

    def crane(self, model: Any, mass: float) -> Any:
        """Return the model with a payload of this mass [kg]."""
        return with_payload(self.hardware.reload, model, mass)

    def events(self) -> list[dict[str, Any]]:
        """Return when [s] which fault came or went."""
        log = self.memory.log
        rows = log.rows[: int(log.total[0])].tolist()
        return [{"t": t, "name": self.faults[int(which)], "on": bool(on)} for t, which, on in rows]

    def summary(self) -> dict[str, Any]:
        """Return what the run's summary has of the hardware."""
        books = self.memory.books
        told: dict[str, Any] = {"faults": self.events()[:SHOWN]} if self.faults else {}
        told |= {"lost_samples": int(books[LOST_SAMPLES])} if books[LOST_SAMPLES] else {}
        return told | ({"braked_time": float(books[BRAKED]) * self._scene.period} if books[BRAKED] else {})
