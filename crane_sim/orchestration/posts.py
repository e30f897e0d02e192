"""The places of a run: who fills each, who stands by to fill it next, and what is handed over when that happens."""

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from crane_sim.orchestration.children import Child
from crane_sim.orchestration.crew import Crew
from crane_sim.recording.part_names import part_of, unfinished

_RESERVES = 2  # who stand by: a second kill may come before the next one has started


class Place(NamedTuple):
    """What a node is started with."""

    name: str
    module: str
    namespace: str
    settings: Mapping[str, object]


class Post:
    """A place that somebody fills, while others may stand by.

    Attributes:
        holder: the child that fills it.
        restarts: how often it was filled anew.
        vacant: why nobody fills it any more, one line; empty while somebody does.
    """

    def __init__(self, crew: Crew, place: Place, replaced: bool = False) -> None:
        """Start the holder and, where it is to be `replaced` when it dies, one that stands by."""
        self.name, self.restarts, self.vacant = place.name, 0, ""
        self._crew, self._place, self._started = crew, place, 1
        self.holder = crew.start(place.name, place.module, place.namespace, place.settings)
        self._reserves: list[Child] = []
        self._replaced = replaced
        if replaced:
            self._add_reserve()

    @property
    def reserves_ready(self) -> bool:
        """Whether all who should stand by do."""
        return all(child.ready for child in self._reserves)

    def relieve(self) -> bool:
        """Let one that stands by follow a holder that has gone; False where that cannot be, or would not help."""
        if not self._replaced or self.holder.gave_up:
            return False
        if not self._reserves:
            self._add_reserve()
        gone, self.holder = self.holder, max(self._reserves, key=lambda child: child.ready)  # the first ready one
        self._reserves.remove(self.holder)
        self.restarts += 1
        self._hand_over(gone)
        self.holder.order("go")
        self._crew.dismiss(gone)
        return True

    def look_after_reserves(self) -> str:
        """Start another one where too few stand by; return why that is given up."""
        for lost in [child for child in self._reserves if child.gone]:
            self._reserves.remove(lost)
            self._crew.dismiss(lost)
            if lost.gave_up or not lost.ready:
                self._replaced = False  # the next one would do no better
                return f"{self.name}: no more replacements: {lost.fault}"
        if self._replaced and len(self._reserves) < _RESERVES:
            self._add_reserve()
        return ""

    def _add_reserve(self) -> None:
        self._started += 1
        place, alias = self._place, f"{self.name}_{self._started}"
        settings = self._reserve_settings(self._started)
        self._reserves.append(self._crew.fork(alias, place.module, place.namespace, settings))

    def _reserve_settings(self, number: int) -> Mapping[str, object]:
        return {**self._place.settings, "autostart": False}

    def _hand_over(self, gone: Child) -> None:
        """Leave what the next holder needs to know."""


class RecorderPost(Post):
    """The recorder's place: who follows goes on behind the last step that is known to be on the disk.

    Attributes:
        path: of the recording, empty where there is none.
        mcap: of the bag, empty where there is none.
        began: s of the system's clock: older files are not of this run.
    """

    def __init__(self, crew: Crew, place: Place, folder: Path, replaced: bool = False) -> None:
        """See `Post`; what is handed over goes through files in `folder`."""
        self._folder, self._parts, self.began = folder, list[str](), time.time()
        self.path, self.mcap = str(place.settings["path"]), str(place.settings["mcap"])
        super().__init__(crew, place, replaced)

    def _reserve_settings(self, number: int) -> Mapping[str, object]:
        return {**self._place.settings, "handover": str(self._folder / f"handover_{number}.json"), "live_port": 0}

    def _hand_over(self, gone: Child) -> None:
        self.holder.step, self.holder.recorded, self.holder.bagged = gone.step, gone.recorded, gone.bagged
        if self.path:
            self._parts.append(str(unfinished(part_of(self.path, self.restarts))))
        told = {"after": gone.step, "recorded": gone.recorded, "bagged": gone.bagged}
        told |= {"parts": self._parts, "number": self.restarts + 1}
        number = self.holder.name.removeprefix(f"{self.name}_")
        (self._folder / f"handover_{number}.json").write_text(json.dumps(told))
