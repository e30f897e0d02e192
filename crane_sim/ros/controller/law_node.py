"""Nodes that run a law: the common part of `controller` and `tracker`."""

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from crane_sim import load_scene
from crane_sim.laws import Law, LawError
from crane_sim.ros.common.nodes import ServingNode
from crane_sim.ros.controller.responder import OutputTopic, Responder
from crane_sim.ros.controller.states import ExecutionTime, State
from crane_sim.ros.controller.trajectory_input import TrajectoryInput
from crane_sim.scenes.scene import Scene


class LawNode(Responder):
    """A law that answers each state of `joint_states` with a command or a setpoint.

    Equal states get the same answer.

    The law is built anew when the plant is reset, which shows in a stamp that does not increase.
    """

    def __init__(
        self,
        node: ServingNode,
        settings: SimpleNamespace,
        make_law: Callable[[SimpleNamespace], Any],
        output: OutputTopic,
    ) -> None:
        """Build the law and evaluate a second one once, so that the first answer is not slower."""
        scene = scene_of(settings)
        self._settings, self._make_law = settings, make_law
        self._law: Any = make_law(settings)
        # compiles, and leaves our law as it is
        make_law(settings)(0.0, scene.initial_q, scene.initial_v)
        self._last_state: State | None = None  # against which a reset is detected
        self._execution_time = ExecutionTime(node)
        self._trajectories = TrajectoryInput(node, scene, self._law)
        super().__init__(node, scene, output, settings.expected_recorders)

    def on_spin(self) -> None:
        """Publish diagnostics when they are due."""
        if self._execution_time.is_due():
            warning, values = self._diagnose()
            refused = {f"refused: {source}": number for source, number in self.refused().items()}
            self._execution_time.publish(warning, {**values, **refused})

    def _on_state(self, state: State) -> None:
        last = self._last_state
        if last and state.stamp <= last.stamp and state != last:
            self._law, self._last_state = self._make_law(self._settings), None
            self._reset()
        self._answer(state)

    def _ask_law(self, state: State) -> tuple[float, ...] | None:
        """Return the law's efforts (nu,) at a state; None, with the fault set, where it fails."""
        self._law = self._trajectories.apply_to(self._law, state.t)
        try:
            return self._execution_time.evaluate(self._law, state, len(self._scene.actuated))
        except LawError as error:
            self.fault = str(error)
            return None

    def _diagnose(self) -> tuple[str, Mapping[str, object]]:
        """Return a warning, empty for none, and diagnostics beside the law's execution time."""
        return "", {}

    def _reset(self) -> None:
        """Drop what belongs to the run before a reset of the plant."""
        raise NotImplementedError

    def _answer(self, state: State) -> None:
        """Publish the answer to a state, if there is one; set `_last_state`."""
        raise NotImplementedError


def scene_of(settings: SimpleNamespace) -> Scene:
    """Return the scene of the parameters, with the law of the parameters."""
    return load_scene(settings.scene, {"control.law": settings.law} if settings.law else None)


def make_law(settings: SimpleNamespace) -> Law:
    """Return the law before its first state; raises ValueError where the scene has none."""
    law = scene_of(settings).law
    if law is None:
        raise ValueError(f"scene {settings.scene} has no control law: give it a group control")
    return law
