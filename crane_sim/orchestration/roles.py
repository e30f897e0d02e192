"""The places of a run: who fills each, who stands by to fill it next, and what is handed over when that happens."""

import json
import time
from collections.abc import Mapping
from typing import NamedTuple

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process_group import ProcessGroup

_STANDBYS = 2  # who stand by: a second kill may come before the next one has started
_RESTART_LIMIT = 3  # replacements while the plant takes no step; the next one would meet the same


class RoleSpec(NamedTuple):
    """What a node is started with."""

    name: str
    module: str
    namespace: str
    settings: Mapping[str, object]


class Role:
    """A place that somebody fills, while others may stand by.

    Attributes:
        active: the child that fills it.
        restarts: how often it was filled anew.
        failed: why nobody fills it any more, one line; empty while somebody does.
    """

    def __init__(self, crew: ProcessGroup, place: RoleSpec, replaced: bool = False) -> None:
        """Start the holder and, where it is to be `replaced` when it dies, one that stands by."""
        self.name, self.restarts, self.failed = place.name, 0, ""
        self._at, self._row = -1, 0  # the plant's step at the last replacement, and how many there were at that one
        self._crew, self._place, self._started = crew, place, 1
        self.active = crew.start(place.name, place.module, place.namespace, place.settings)
        self._standbys: list[Child] = []
        self._replaced = replaced
        if replaced:
            self._add_standby()

    @property
    def standbys_ready(self) -> bool:
        """Whether all who should stand by do."""
        return all(child.ready for child in self._standbys)

    def fail_over(self, step: int) -> bool:
        """Let one that stands by follow a holder that has gone, with the plant at `step`.

        Returns False where that cannot be, or would not help: the place stays vacant.
        """
        self.failed = self.failed or self._reason_to_give_up(step)
        if self.failed:
            return False
        if not self._standbys:
            self._add_standby()
        gone, self.active = self.active, max(self._standbys, key=lambda child: child.ready)  # the first ready one
        self._standbys.remove(self.active)
        self.restarts += 1
        self.active.order(f"go {self._handover(gone)}".strip())
        self._crew.remove(gone)
        return True

    def maintain_standbys(self) -> str:
        """Start another one where too few stand by; return why that is given up."""
        for lost in [child for child in self._standbys if child.gone]:
            self._standbys.remove(lost)
            self._crew.remove(lost)
            if lost.fatal or not lost.ready:
                self._replaced = False  # the next one would do no better
                return f"{self.name}: no more replacements: {lost.fault}"
        if self._replaced and len(self._standbys) < _STANDBYS:
            self._add_standby()
        return ""

    def _reason_to_give_up(self, step: int) -> str:
        """Return why the place is to stay vacant, one line; empty where the next one may do better."""
        why = f"{self.name}: {self.active.fault}"
        if not self._replaced or self.active.fatal:
            return why
        self._at, self._row = step, self._row + 1 if step == self._at else 1
        given_up = f"{why}; {_RESTART_LIMIT} replacements in a row died with the plant at step {step}"
        return given_up if self._row > _RESTART_LIMIT else ""

    def _add_standby(self) -> None:
        self._started += 1
        place, alias = self._place, f"{self.name}_{self._started}"
        self._standbys.append(self._crew.fork(alias, place.module, place.namespace, self._standby_settings()))

    def _standby_settings(self) -> Mapping[str, object]:
        return {**self._place.settings, "autostart": False}

    def _handover(self, gone: Child) -> str:
        """Return what the next holder needs to know, one line."""
        return ""


class RecorderRole(Role):
    """The recorder's place: who follows goes on behind the last step that is known to be on the disk.

    Attributes:
        path: of the recording, empty where there is none.
        mcap: of the bag, empty where there is none.
        began: s of the system's clock: older files are not of this run.
    """

    def __init__(self, crew: ProcessGroup, place: RoleSpec, replaced: bool = False) -> None:
        """See `Role`."""
        self.began = time.time()
        self.path, self.mcap = str(place.settings["path"]), str(place.settings["mcap"])
        super().__init__(crew, place, replaced)

    def _standby_settings(self) -> Mapping[str, object]:
        return {**self._place.settings, "standby": True, "passes": self.active.passes, "live_port": 0}

    def _handover(self, gone: Child) -> str:
        heir = self.active
        heir.step, heir.recorded, heir.bagged, heir.passes = gone.step, gone.recorded, gone.bagged, gone.passes
        told = {"after": gone.step, "recorded": gone.recorded, "bagged": gone.bagged, "passes": gone.passes}
        return json.dumps(told | {"since": self.began, "number": self.restarts + 1})
