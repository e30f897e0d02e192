"""The hardware of one run: its memory, and what is told of it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crane_sim.hardware.brake_defaults import fit
from crane_sim.hardware.chance import word
from crane_sim.hardware.drives import DELAY as DRIVE_DELAY
from crane_sim.hardware.drives import ORIGIN
from crane_sim.hardware.equipment import Equipment, no_equipment
from crane_sim.hardware.faults import AS_PLANNED, Log
from crane_sim.hardware.passing import (
    BOOKS,
    BRAKED,
    BRAKING,
    GIVEN,
    LIMITED,
    LOST_SAMPLES,
    MASS,
    Hardware,
    Memory,
    first_look,
    given,
    hardware_step,
)
from crane_sim.hardware.payloads import laden
from crane_sim.hardware.sensors import DELAY
from crane_sim.scene import Scene

LOG = 1000
"""Changes of faults that are kept."""
SHOWN = 20
"""Changes of faults in the summary."""


class Rig:
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
        books = np.zeros(BOOKS)
        books[MASS] = found.reload.mass if found.reload is not None else 0.0
        self.memory = Memory(
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
        return first_look(model, self.hardware, self.memory, flow, period)

    def demand(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the efforts (nu,) that the scene's open-loop inputs demand at time t [s]; none while brakes hold."""
        source = self._scene.source
        if type(source) is tuple:
            return source
        if self.memory.books[BRAKING] or source is None:
            return (0.0,) * self.memory.drives.shape[1]
        return given(source, t, q, v)

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
        return laden(self.hardware.reload, model, mass)

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
