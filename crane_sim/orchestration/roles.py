"""Roles of a run: the active process of each, its standbys, and the state handed over to them."""

import json
import time
from collections.abc import Mapping
from typing import NamedTuple

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process_group import ProcessGroup

_STANDBYS = 2  # a second process may be killed before the next standby has started
# fail-overs while the plant takes no step; the next process would fail at the same state
_RESTART_LIMIT = 3


class RoleSpec(NamedTuple):
    """The node of a role and its parameters."""

    name: str
    module: str
    namespace: str
    settings: Mapping[str, object]


class Role:
    """A role of a run with one active process and, where it is replicated, standbys.

    Attributes:
        active: the active process; one that has exited until the fail-over.
        restarts: number of fail-overs.
        failure: why there is no active process any more, one line; empty while there is one.
    """

    def __init__(self, group: ProcessGroup, spec: RoleSpec, restart: bool = False) -> None:
        """Start the active process; one that is to `restart` after a failure gets standbys."""
        self.name, self.restarts, self.failure = spec.name, 0, ""
        # the plant's step at the last failure, and their number
        self._failure_step, self._failures_at_step = -1, 0
        self._group, self._spec, self._started = group, spec, 1
        self.active = group.start(spec.name, spec.module, spec.namespace, spec.settings)
        self._standbys: list[Child] = []
        self._restart = restart

    @property
    def standbys_ready(self) -> bool:
        """Whether all standbys are ready."""
        return all(child.ready for child in self._standbys)

    def start_standby(self) -> None:
        """Start the first standby, where the role has any."""
        if self._restart:
            self._add_standby()

    def fail_over(self, step: int) -> bool:
        """Make a standby the active process after an exit, with the plant at `step`.

        Returns False where that cannot be, or would not help: the role has failed.
        """
        self.failure = self.failure or self._reason_to_give_up(step)
        if self.failure:
            return False
        if not self._standbys:
            self._add_standby()
        # the first ready one
        exited, self.active = self.active, max(self._standbys, key=lambda child: child.ready)
        self._standbys.remove(self.active)
        self.restarts += 1
        self.active.send(f"go {self._resume_state(exited)}".strip())
        self._group.remove(exited)
        return True

    def maintain_standbys(self) -> str:
        """Start a standby where there are too few; return why that is given up, or empty."""
        for lost in [child for child in self._standbys if child.exited]:
            self._standbys.remove(lost)
            self._group.remove(lost)
            if lost.fatal or not lost.ready:
                self._restart = False  # the next one would fail, too
                return f"{self.name}: no more replacements: {lost.fault}"
        if self._restart and len(self._standbys) < _STANDBYS:
            self._add_standby()
        return ""

    def _reason_to_give_up(self, step: int) -> str:
        """Return the reason, one line, against a fail-over; empty where a standby may succeed."""
        reason = f"{self.name}: {self.active.fault}"
        if self.active.fatal or not (self._restart or self._standbys):
            return reason
        self._failures_at_step = self._failures_at_step + 1 if step == self._failure_step else 1
        self._failure_step = step
        given_up = (
            f"{reason}; {_RESTART_LIMIT} replacements in a row died with the plant at step {step}"
        )
        return given_up if self._failures_at_step > _RESTART_LIMIT else ""

    def _add_standby(self) -> None:
        self._started += 1
        spec, alias = self._spec, f"{self.name}_{self._started}"
        self._standbys.append(
            self._group.start(alias, spec.module, spec.namespace, self._standby_settings())
        )

    def _standby_settings(self) -> Mapping[str, object]:
        return {**self._spec.settings, "autostart": False}

    def _resume_state(self, exited: Child) -> str:
        """Return the state in which the next active process resumes, one line."""
        return ""


class RecorderRole(Role):
    """The recorder's role: the next one resumes after the last step known to be on the disk.

    Attributes:
        path: of the recording, empty where there is none.
        mcap: of the bag, empty where there is none.
        start_time: s of the system's clock; older files are not of this run.
    """

    def __init__(self, group: ProcessGroup, spec: RoleSpec, restart: bool = False) -> None:
        """See `Role`."""
        self.start_time = time.time()
        self.path, self.mcap = str(spec.settings["path"]), str(spec.settings["mcap"])
        super().__init__(group, spec, restart)

    def _standby_settings(self) -> Mapping[str, object]:
        return {
            **self._spec.settings,
            "standby": True,
            "resets": self.active.resets,
            "live_port": 0,
        }

    def _resume_state(self, exited: Child) -> str:
        successor = self.active
        successor.step, successor.recorded, successor.lost_commands = (
            exited.step,
            exited.recorded,
            exited.lost_commands,
        )
        successor.last_bag_step, successor.resets = exited.last_bag_step, exited.resets
        steps = {
            "after": exited.step,
            "recorded": exited.recorded,
            "last_bag_step": exited.last_bag_step,
        }
        steps |= {"lost_commands": exited.lost_commands}
        return json.dumps(
            steps
            | {"resets": exited.resets}
            | {"since": self.start_time, "number": self.restarts + 1}
        )
