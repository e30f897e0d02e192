"""The children of a run: started, listened to, and ended in any case."""

import json
import selectors
import signal
import time
from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path
from types import TracebackType
from typing import Self

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process import ForkServer, Process, start_program

_TURN = 0.1  # s between two looks at whether somebody waits for the end
_PATIENCE = 5.0, 2.0  # s until SIGTERM, and from there until SIGKILL
_HURRY = 0.3, 0.2  # the same where somebody waits for the end: what matters has been reported by then
_LIMIT = 2.4  # s for all of an early end: whoever waits is promised 3 s, and the program itself has to end, too


class ProcessGroup:
    """The children of one run; leaving the block ends them all.

    Attributes:
        children: those who have not been dismissed.
        deadline: instant of the monotonic clock [s] by which all have ended; inf while nobody waits for that.
    """

    def __init__(self, env: Mapping[str, str], interrupts: Sequence[int] = ()) -> None:
        """Start nobody yet.

        Args:
            env: environment of all.
            interrupts: signals that have come, whenever one looks: who sends one waits for the end.
        """
        self.children: list[Child] = []
        self.deadline = inf
        self._env, self._interrupts = env, interrupts
        self._selector = selectors.DefaultSelector()
        self._nursery: ForkServer | None = None

    def __enter__(self) -> Self:
        """Enter the block."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """End every child."""
        if self._nursery:
            self._nursery.close()
        for child in self.children:
            child.order("finish")
            child.close_control_pipe()
        for child in self.children:
            child.wait_started()
            if self.shutting_down and not child.ready:
                child.send_signal(signal.SIGKILL)
        self._terminate_all()
        self._selector.close()

    def request_shutdown(self) -> None:
        """From now on somebody waits for the end."""
        self.deadline = min(self.deadline, time.monotonic() + _LIMIT)

    @property
    def shutting_down(self) -> bool:
        """Whether somebody waits for the end."""
        if self._interrupts:
            self.request_shutdown()
        return self.deadline < inf

    @property
    def left(self) -> float:
        """Seconds for what is to be done before the processes are let go; inf while nobody waits."""
        return self.deadline - sum(_HURRY) - time.monotonic() if self.shutting_down else inf

    def _terminate_all(self) -> None:
        """Wait, insist, and end who does not listen: all at once, whoever keeps us waiting."""
        living = self.children
        for stage, number in enumerate((signal.SIGTERM, signal.SIGKILL)):
            since = time.monotonic()
            while living and time.monotonic() < (limit := self._limit(since, stage)):
                instant = min(time.monotonic() + _TURN, limit)
                living = [child for child in living if not child.ended_by(instant)]
            for child in living:
                child.send_signal(number)
        for child in self.children:
            child.close()

    def _limit(self, since: float, stage: int) -> float:
        """Return the instant at which a stage of the end that began at `since` [s] is over, as far as one knows now."""
        hurried = self.shutting_down
        patience = _HURRY if hurried else _PATIENCE
        return min(since + patience[stage], self.deadline - sum(patience[stage + 1 :]))

    def start(self, name: str, module: str, namespace: str, settings: Mapping[str, object]) -> Child:
        """Start the node of `module` in `namespace` with the given parameters."""
        arguments = _arguments(namespace, settings)

        def start(control: int, report: int) -> Process:
            pipes = ["-p", f"control_fd:={control}", "-p", f"report_fd:={report}"]
            return start_program(module, [*arguments, *pipes], self._env, (control, report))

        return self._add(Child(name, start))

    def prepare_forks(self, scene_file: Path) -> None:
        """From now on, nodes of this scene can be forked."""
        self._nursery = ForkServer(scene_file, self._env)

    def fork(self, name: str, module: str, namespace: str, settings: Mapping[str, object]) -> Child:
        """Start a node as `start` does, of that `name` in ROS, too, and in a fraction of the time."""
        nursery = self._nursery
        if nursery is None:
            raise RuntimeError("no forks were prepared")
        arguments = [*_arguments(namespace, settings), "-r", f"__node:={name}"]
        return self._add(Child(name, lambda control, report: nursery.spawn(module, arguments, control, report)))

    def _add(self, child: Child) -> Child:
        self.children.append(child)
        self._selector.register(child.reports, selectors.EVENT_READ, child)
        return child

    def remove(self, child: Child) -> None:
        """Forget a child that has gone."""
        self.children.remove(child)
        child.close_control_pipe()
        child.close()

    def listen(self, timeout: float) -> bool:
        """Read what the children report within `timeout` seconds; whether there was anything."""
        if not self._selector.get_map():
            time.sleep(timeout)
        heard = self._selector.select(timeout)
        for key, _ in heard:
            key.data.read()
            if key.data.gone:
                self._selector.unregister(key.fd)
        return bool(heard)


def _arguments(namespace: str, settings: Mapping[str, object]) -> list[str]:
    parameters = [f"{key}:={json.dumps(value)}" for key, value in settings.items()]
    return ["--ros-args", "-r", f"__ns:=/{namespace}", *(word for each in parameters for word in ("-p", each))]
