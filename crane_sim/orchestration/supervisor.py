"""The supervisor of a run, from the start of its nodes to the last step, with fail-over."""

import signal
import time
from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

from crane_sim.environment import describe_unusual
from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.roles import Role

READY_TIMEOUT = 120.0  # s without a report allowed while the nodes compile and discover each other
_REPORT_TIMEOUT = 60.0  # s; a running plant reports ten times a second
_POLL = 0.1  # s between two checks of deadlines
_STOPPED_POLL = 1.0  # s between two checks for stopped processes
_ANSWER_TIMEOUT = 10.0  # s for which a plant waits for our own controller until that is killed
_SUMMARY_TIMEOUT = 10.0  # s for the plant to report its summary after an early end
_SHUTDOWN_SUMMARY_TIMEOUT = 0.8  # s for that once a shutdown is requested


class RunError(RuntimeError):
    """The run cannot go on; the message is one line."""


class Callbacks(NamedTuple):
    """Callbacks of a run; see `orchestration.run`."""

    on_progress: Callable[[int], object]  # steps done
    on_news: Callable[[str], object]  # one line
    on_activated: Callable[[str, int], object]  # name of a role, process id of its active node from
    # now on


class Supervisor:
    """Waits for stages of a run; ends it on a time-out, a fault or an interruption."""

    def __init__(
        self,
        group: ProcessGroup,
        roles: Sequence[Role],
        interrupts: list[int],
        callbacks: Callbacks,
        timeout: float,
    ) -> None:
        """Supervise a run.

        Args:
            group: its processes.
            roles: their roles, the plant's first.
            interrupts: signals that have been received.
            callbacks: called with what happens.
            timeout: s without a command of the user's own node until the run ends.
        """
        self._group, self._roles, self._interrupts = group, roles, interrupts
        self._callbacks, self._timeout = callbacks, timeout
        self._waiting_since = 0.0
        self._announced: dict[str, int] = {}
        self._notices: set[str] = set()
        self._stopped: dict[int, str] = {}  # names by process id, as announced
        self._next_check = 0.0  # instant of the monotonic clock [s]
        self.plant = roles[0].active

    def wait_ready(self) -> None:
        """Wait until all nodes are ready; raises RunError when one fails."""
        timeout = READY_TIMEOUT if self._own_controller else max(READY_TIMEOUT, self._timeout)
        self._wait_until(
            self._all_ready, self._check_faults, timeout, "waiting for the nodes to meet"
        )
        self._announce_active()

    def run(self) -> None:
        """Start the plant's steps, and wait for its summary; raises RunError if there is none."""
        self.plant.send("go")
        self._wait_until(
            lambda: self.plant.summary is not None,
            self._recover,
            _REPORT_TIMEOUT,
            "waiting for the plant",
        )

    def stop_early(self) -> None:
        """Order the plant to end early, and wait for its summary."""
        if self.plant.ready:
            self.plant.send("finish")
            self.drain([self.plant], _SUMMARY_TIMEOUT, _SHUTDOWN_SUMMARY_TIMEOUT)

    def drain(
        self, children: Sequence[Child], timeout: float, shutdown_timeout: float = inf
    ) -> None:
        """Read reports until the children are done or exited, at most for `timeout` seconds.

        Once a shutdown is requested, no longer than `shutdown_timeout` seconds and than the time
        that is left.
        """
        start = time.monotonic()
        while any(child.summary is None and not child.exited for child in children):
            limit = shutdown_timeout if self._group.shutting_down else timeout
            if time.monotonic() - start > limit or self._group.time_left <= 0.0:
                return
            self._group.listen(_POLL)
            self._announce_stopped()
            self.pass_notices_on()

    def pass_notices_on(self) -> None:
        """Report what nodes have said: of several that say the same, the first one."""
        for child in self._group.children:
            while child.notices:
                line = child.notices.pop(0)
                if line not in self._notices:
                    self._notices.add(line)
                    self._callbacks.on_news(line)

    def fail_over(self, role: Role) -> bool:
        """Let a standby take over a role after an exit, and report it; False where it cannot."""
        reason = f"{role.name}: {role.active.fault}"
        if not role.fail_over(self.plant.step):
            return False
        self._callbacks.on_news(f"{reason}; replaced")
        self._announce_active()
        self._waiting_since = self._waiting_since and time.monotonic()
        return True

    @property
    def shutting_down(self) -> bool:
        """Whether a shutdown was requested."""
        return self._group.shutting_down

    @property
    def time_left(self) -> float:
        """See `ProcessGroup`."""
        return self._group.time_left

    @property
    def _own_controller(self) -> Role | None:
        return next((role for role in self._roles if role.name == "controller"), None)

    def _wait_until(
        self, done: Callable[[], bool], check: Callable[[], None], timeout: float, what: str
    ) -> None:
        deadline = time.monotonic() + timeout
        while not done():
            if self._interrupts:
                self._group.request_shutdown()
                raise RunError("interrupted")
            if self._group.listen(_POLL):
                self._callbacks.on_progress(self.plant.step)
                self.pass_notices_on()
                deadline = time.monotonic() + timeout
            if not done():
                check()
            self._announce_stopped()
            if time.monotonic() > deadline:
                raise RunError(f"{what}: no report for {timeout:g} s{self._describe_silence()}")

    def _announce_stopped(self) -> None:
        """Report each process that a signal has stopped, once; it is checked every second."""
        if time.monotonic() < self._next_check:
            return
        self._next_check = time.monotonic() + _STOPPED_POLL
        before, self._stopped = self._stopped, self._group.find_stopped()
        for pid, name in self._stopped.items() - before.items():
            self._callbacks.on_news(
                f"{name}: a signal has stopped process {pid}; `kill -CONT {pid}` lets it go on"
            )

    def _describe_silence(self) -> str:
        """Return which processes have not answered, and possible reasons; empty if unknown."""
        stopped = [f"{name} is stopped" for name in self._stopped.values()]
        missing = [
            f"{child.name} is not ready" for child in self._group.children if not child.ready
        ]
        return "".join(f"; {reason}" for reason in stopped or missing) + describe_unusual()

    def _all_ready(self) -> bool:
        return all(role.active.ready and role.standbys_ready for role in self._roles)

    def _check_faults(self) -> None:
        for child in self._group.children:
            if child.fault:
                self._group.request_shutdown()
                hint = "" if child.fatal else describe_unusual()
                raise RunError(f"{child.name}: {child.fault}{hint}")

    def _recover(self) -> None:
        if self.plant.fault:
            self._group.request_shutdown()
            raise RunError(f"plant: {self.plant.fault}")
        for role in self._roles[1:]:
            if role.active.fault and not role.failure and not self.fail_over(role):
                self._degrade(role)
            if reason := role.maintain_standbys():
                self._callbacks.on_news(reason)
        self._announce_active()
        self._check_timeout()

    def _announce_active(self) -> None:
        """Report each new active process once it has an id: a node being forked has none."""
        for role in self._roles:
            pid = role.active.pid
            if pid and self._announced.get(role.name) != pid:
                self._announced[role.name] = pid
                self._callbacks.on_activated(role.name, pid)

    def _degrade(self, role: Role) -> None:
        """Go on without a role that has failed."""
        if role.name == "recorder":
            self._callbacks.on_news(f"{role.failure}; the run goes on unrecorded")
        else:
            self._callbacks.on_news(f"{role.failure}; the crane is braked to rest")
            self.plant.send(f"brake {role.failure}")

    def _check_timeout(self) -> None:
        """Report that the plant waits for a command; act after the time-out.

        Our own controller is then killed; otherwise the run ends.
        """
        if not self.plant.waiting:
            if self._waiting_since:
                self._callbacks.on_news("the plant goes on")
            self._waiting_since = 0.0
            return
        if not self._waiting_since:
            self._waiting_since = time.monotonic()
            self._callbacks.on_news(f"the plant waits: {self.plant.waiting}")
        own_controller, waiting_time = self._own_controller, time.monotonic() - self._waiting_since
        if not all(role.active.active for role in self._roles):
            # a pause or a deactivation is on purpose, and no failure
            self._waiting_since = time.monotonic()
        elif own_controller and waiting_time > _ANSWER_TIMEOUT:
            self._waiting_since = time.monotonic()  # the next one has as long
            # it is alive and does not answer: it is replaced like a dead one
            self._callbacks.on_news(
                f"the controller is killed: {self.plant.waiting}, and {_ANSWER_TIMEOUT:g} s more"
            )
            own_controller.active.send_signal(signal.SIGKILL)
        elif not own_controller and waiting_time > self._timeout:
            raise RunError(f"plant: {self.plant.waiting}; that was {self._timeout:g} s ago")
