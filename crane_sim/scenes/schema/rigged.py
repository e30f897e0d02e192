"""Base class of scene files of cranes whose payload hangs on one rope and further links, below any support."""

from collections.abc import Sequence
from math import hypot
from typing import Any

import numpy as np

from crane_sim.models.stops import Stops
from crane_sim.models.supports.hoist import MasslessHoist, MotionHoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.support import Support
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.suspended.torsion import Torsion
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.exchange import LoadEvent, exchange_of, windages_of
from crane_sim.scenes.schema.groups import Friction
from crane_sim.scenes.schema.integrator import needs_frequency
from crane_sim.scenes.schema.load_file import LoadFile
from crane_sim.scenes.schema.oscillation import swing_frequency
from crane_sim.scenes.schema.rigging import Link, chain_of, check_equipment, twist_frequency


class RiggedFile(LoadFile):
    """The groups of all such cranes: what hangs below the support."""

    swing_friction: Friction = None  # friction of the swing joints, of the rope at the tip
    links: tuple[Link, ...] = ()  # further links below the rope, from the top
    events: tuple[LoadEvent, ...] = ()  # exchanges of the payload at given times

    @property
    def _torsion(self) -> Torsion | None:
        return getattr(self, "rope").torsion  # noqa: B009  (every schema declares its own)

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        return windages_of(self.payload, self.events)

    def _lowest_below(self, height: float, longest: float) -> float:
        """Return the result of `lowest_pressure` below a tip at this height [m] on at most this length of rope [m]."""
        payloads = [self.payload, *(event.payload for event in self.events)]
        bodies = [payload.attachment for payload in payloads], [payload.windage for payload in payloads]
        levers = [hypot(*(arm or (0.0,))) for arm in bodies[0]]
        centres = [hypot(*(part.centre or (0.0,))) if part is not None else 0.0 for part in bodies[1]]
        return height - longest - sum(link.length for link in self.links) - max(levers) - max(centres)

    def _twist_frequency(self, mobility: float) -> float:
        """Return the largest frequency or decay rate [rad/s] of a payload on the rope's torsion, 0 without.

        The mobility is that of the tip's yaw [1/(kg m²)].
        """
        payloads = [self.payload, *(event.payload for event in self.events)]
        return twist_frequency(self._torsion, [payload.inertia for payload in payloads if payload.inertia], mobility)

    def _swing_frequency(self, length: float, mobility: Any) -> float:
        """Return a bound [rad/s] of the frequencies of all payloads on rope and links that hang still.

        Only for methods that depend on it, else 0.

        Args:
            length: of the rope [m].
            mobility: of its upper end (4, 4): x, y, z [1/kg], and yaw.
        """
        if not needs_frequency(self.integrator):
            return 0.0
        lengths, masses = [length, *(link.length for link in self.links)], [link.mass for link in self.links]
        payloads = [self.payload, *(event.payload for event in self.events)]
        upper = float(np.linalg.eigvalsh(mobility[:3, :3])[-1])
        return max(swing_frequency(lengths, masses, upper, payload, self.gravity) for payload in payloads)

    def suspended_crane(
        self,
        support: Support,
        length: float,
        hoist: MasslessHoist | MotionHoist | ReevedHoist | None,
        stops: Stops | None,
        joints: Sequence[str],
    ) -> SuspendedCrane:
        """Return the parameters of the crane.

        Args:
            support: with its drives.
            length: of the rope at t = 0 [m].
            hoist: drive of the rope; None: its length stays.
            stops: conditions that end a run.
            joints: those whose motors add their inertia.

        Raises:
            SceneError: groups contradict each other.
        """
        check_equipment(self, self.payload, joints)
        load, exchange = exchange_of(self.payload, self.events)
        return SuspendedCrane(
            support,
            chain_of(length, self.links, load.mass),
            load,
            hoist,
            self.gravity,
            self.payload_drag,
            base=self.base(),
            force=self.force(),
            stops=stops,
            wind=self.airflow(),
            exchange=exchange,
            torsion=self._torsion,
            swing_friction=self.swing_friction,
        )
