"""Takes the nodes of a run from their start to the plant's last step, and mends on the way what can be mended."""

import signal
import time
from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.roles import Role

READY = 120.0  # s of silence allowed while the nodes compile and meet
_SILENCE = 60.0  # s; a running plant reports ten times a second
_TURN = 0.1  # s between two looks at the clock
_UNANSWERED = 10.0  # s that a plant waits for our own controller until that is taken for dead
_WIND_UP = 10.0, 0.8  # s for the plant to report after an early end; where somebody waits for it


class RunError(RuntimeError):
    """The run cannot go on; one line."""


class Callbacks(NamedTuple):
    """Whom a run tells what happens."""

    progress: Callable[[int], object]  # steps done
    news: Callable[[str], object]  # one line
    filled: Callable[[str, int], object]  # name of a place, process id of the node that fills it now


class Supervisor:
    """Waits for the crew to get somewhere, and gives up when that cannot be, or when the user interrupts."""

    def __init__(
        self, crew: ProcessGroup, posts: Sequence[Role], interrupts: list[int], telling: Callbacks, patience: float
    ) -> None:
        """Conduct a run.

        Args:
            crew: its processes.
            posts: their places, the plant's first.
            interrupts: signals that have come.
            telling: who is told.
            patience: s without a command of the user's own node until the run ends.
        """
        self._crew, self._posts, self._interrupts = crew, posts, interrupts
        self._telling, self._patience = telling, patience
        self._waiting_since = 0.0
        self._announced: dict[str, int] = {}
        self.plant = posts[0].active

    def wait_ready(self) -> None:
        """Wait until all are there; raises RunError when one fails."""
        silence = READY if self._own_controller else max(READY, self._patience)
        self._until(self._all_ready, self._all_sound, silence, "waiting for the nodes to meet")
        self._announce()

    def play(self) -> None:
        """Let the plant go, and wait for its summary; raises RunError when there will be none."""
        self.plant.order("go")
        self._until(lambda: self.plant.summary is not None, self._recover, _SILENCE, "waiting for the plant")

    def stop_early(self) -> None:
        """Let the plant end early."""
        if self.plant.ready:
            self.plant.order("finish")
            self.drain([self.plant], *_WIND_UP)

    def drain(self, children: Sequence[Child], patience: float, hurry: float = inf) -> None:
        """Listen until the children are done or gone, whatever the others do, but no longer than `patience` seconds.

        Where somebody waits for the end of the run, no longer than `request_shutdown` seconds, and than what is left
        till then.
        """
        began = time.monotonic()
        while any(child.summary is None and not child.gone for child in children):
            limit = hurry if self._crew.shutting_down else patience
            if time.monotonic() - began > limit or self._crew.left <= 0.0:
                return
            self._crew.listen(_TURN)

    def fail_over(self, post: Role) -> bool:
        """Fill a place whose holder has gone anew, and tell it; False where it stays vacant."""
        why = f"{post.name}: {post.active.fault}"
        if not post.fail_over(self.plant.step):
            return False
        self._telling.news(f"{why}; replaced")
        self._announce()
        self._waiting_since = self._waiting_since and time.monotonic()
        return True

    @property
    def shutting_down(self) -> bool:
        """Whether somebody waits for the end."""
        return self._crew.shutting_down

    @property
    def left(self) -> float:
        """Seconds until the processes are let go, inf while nobody waits for the end."""
        return self._crew.left

    @property
    def _own_controller(self) -> Role | None:
        return next((post for post in self._posts if post.name == "controller"), None)

    def _until(self, done: Callable[[], bool], look: Callable[[], None], silence: float, what: str) -> None:
        deadline = time.monotonic() + silence
        while not done():
            if self._interrupts:
                self._crew.request_shutdown()
                raise RunError("interrupted")
            if self._crew.listen(_TURN):
                self._telling.progress(self.plant.step)
                deadline = time.monotonic() + silence
            if not done():
                look()
            if time.monotonic() > deadline:
                raise RunError(f"{what}: nothing heard for {silence:g} s")

    def _all_ready(self) -> bool:
        return all(post.active.ready and post.standbys_ready for post in self._posts)

    def _all_sound(self) -> None:
        for child in self._crew.children:
            if child.fault:
                self._crew.request_shutdown()
                raise RunError(f"{child.name}: {child.fault}")

    def _recover(self) -> None:
        if self.plant.fault:
            self._crew.request_shutdown()
            raise RunError(f"plant: {self.plant.fault}")
        for post in self._posts[1:]:
            if post.active.fault and not post.failed and not self.fail_over(post):
                self._do_without(post)
            if why := post.maintain_standbys():
                self._telling.news(why)
        self._announce()
        self._check_timeout()

    def _announce(self) -> None:
        """Tell who fills a place, as soon as there is a process: a node that is just being forked has none."""
        for post in self._posts:
            pid = post.active.pid
            if pid and self._announced.get(post.name) != pid:
                self._announced[post.name] = pid
                self._telling.filled(post.name, pid)

    def _do_without(self, post: Role) -> None:
        if post.name == "recorder":
            self._telling.news(f"{post.failed}; the run goes on unrecorded")
        else:
            self._telling.news(f"{post.failed}; the crane is braked to rest")
            self.plant.order(f"brake {post.failed}")

    def _check_timeout(self) -> None:
        """Where the plant waits for a command: say so, and give up in the end."""
        if not self.plant.waiting:
            if self._waiting_since:
                self._telling.news("the plant goes on")
            self._waiting_since = 0.0
            return
        if not self._waiting_since:
            self._waiting_since = time.monotonic()
            self._telling.news(f"the plant waits: {self.plant.waiting}")
        own, silent = self._own_controller, time.monotonic() - self._waiting_since
        if not all(post.active.active for post in self._posts):
            self._waiting_since = time.monotonic()  # somebody wants it to stand, or them to be silent: nobody is dead
        elif own and silent > _UNANSWERED:
            self._waiting_since = time.monotonic()  # the next one has as long
            # It lives and does not answer: the way out is the same as for a dead one.
            own.active.send_signal(signal.SIGKILL)
        elif not own and silent > self._patience:
            raise RunError(f"plant: {self.plant.waiting}; that was {self._patience:g} s ago")
