"""The services and the action of simulation_interfaces, where that package is importable.

They are in the plant's namespace.
"""

from collections.abc import Callable, Generator
from importlib import import_module
from typing import Any

from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.node import Node

from crane_sim.ros.common.messages import describe_missing
from crane_sim.ros.plant.entities import Entities
from crane_sim.ros.plant.entity_services import EntityServices
from crane_sim.ros.plant.run_control import RunControl
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.ros.plant.standard_operations import (
    Code,
    Feature,
    Outcome,
    StandardOperations,
    write_outcome,
)

_PACKAGE = "simulation_interfaces"
_FRAMES = "frames of a crane have no extent; the description has drawings"
_MOVES = (
    "frames of a crane move by its equations; reset_positions of ~/reset_simulation puts the "
    "joints anywhere"
)
_CRANE = "entities are the frames of the crane, no more and no fewer"
_SCENE = "the world is the scene that the plant was started with"
_POSES = "a scene has no named poses"
_UNSUPPORTED = {
    "set_entity_state": ("SetEntityState", _MOVES),
    "set_entity_info": ("SetEntityInfo", _CRANE),
    "get_entity_bounds": ("GetEntityBounds", _FRAMES),
    "spawn_entity": ("SpawnEntity", _CRANE),
    "spawn_entities": ("SpawnEntities", _CRANE),
    "delete_entity": ("DeleteEntity", _CRANE),
    "get_spawnables": ("GetSpawnables", _CRANE),
    "get_named_poses": ("GetNamedPoses", _POSES),
    "get_named_pose_bounds": ("GetNamedPoseBounds", _POSES),
    "load_world": ("LoadWorld", _SCENE),
    "unload_world": ("UnloadWorld", _SCENE),
    "get_current_world": ("GetCurrentWorld", _SCENE),
    "get_available_worlds": ("GetAvailableWorlds", _SCENE),
}
"""Kind of each service for what a crane does not do, and why it is not supported."""
_OF_ENTITY = ("set_entity_state", "set_entity_info", "get_entity_bounds", "delete_entity")


def missing_package() -> str:
    """Return one line on why there are no standard services, empty where there are."""
    try:
        import_module(f"{_PACKAGE}.srv")
    except ImportError:
        return describe_missing(_PACKAGE)
    return ""


def offer(node: Node, control: RunControl, simulation: SimulationRun, prefix: str) -> None:
    """Offer the standard services, where their package is installed.

    Args:
        node: offers them.
        control, simulation: of the run.
        prefix: begins the names of frames, and of entities.
    """
    if missing_package():
        return
    entities = Entities(simulation.plant, prefix)
    EntityServices(node, _PACKAGE, entities, lambda: simulation.stamp)
    kinds = import_module(f"{_PACKAGE}.srv")
    for name, (kind, why) in _UNSUPPORTED.items():
        if hasattr(kinds, kind):  # earlier versions have fewer
            known = entities if name in _OF_ENTITY else None
            node.create_service(getattr(kinds, kind), name, _refusal(why, known))
    StandardServices(node, StandardOperations(control))


def _refusal(why: str, entities: Entities | None) -> Callable[[Any, Any], Any]:
    """Return the callback of an unsupported service: 0; of an unknown entity 2, not found."""

    def refuse(request: Any, response: Any) -> Any:
        if entities is not None and request.entity not in entities.names:
            return write_outcome(response, entities.not_found(request.entity))
        return write_outcome(response, Outcome(Code.FEATURE_UNSUPPORTED, why))

    return refuse


class StandardServices:
    """Services for features, the simulation state, steps and reset.

    They are `get_simulator_features`, `get_` and `set_simulation_state`, `step_simulation`,
    `reset_simulation`.

    Also the action `simulate_steps`. `Feature` lists what the plant supports.
    """

    def __init__(self, node: Node, operations: StandardOperations) -> None:
        """Offer the services."""
        self._operations = operations
        self._stepping = False  # by the action
        kinds, actions = import_module(f"{_PACKAGE}.srv"), import_module(f"{_PACKAGE}.action")
        node.create_service(
            kinds.GetSimulatorFeatures, "get_simulator_features", self._get_features
        )
        node.create_service(kinds.GetSimulationState, "get_simulation_state", self._get_state)
        node.create_service(kinds.SetSimulationState, "set_simulation_state", self._set_state)
        node.create_service(kinds.StepSimulation, "step_simulation", self._step)
        node.create_service(kinds.ResetSimulation, "reset_simulation", self._reset)
        self._action: Any = actions.SimulateSteps
        self._server = ActionServer(
            node,
            self._action,
            "simulate_steps",
            self._simulate_steps,
            goal_callback=self._accept_goal,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def _get_features(self, _: Any, response: Any) -> Any:
        response.features.features = list(map(int, Feature))
        response.features.custom_info = (
            "time and state are reset together; names of topics and services: docs/ros.md"
        )
        return response

    def _get_state(self, _: Any, response: Any) -> Any:
        response.state.state = int(self._operations.state())
        return write_outcome(response, Outcome(Code.OK))

    def _set_state(self, request: Any, response: Any) -> Any:
        return write_outcome(response, self._operations.set_state(request.state.state))

    def _step(self, request: Any, response: Any) -> Any:
        if self._stepping:
            busy = "the action simulate_steps takes steps; cancel it, or wait for its result"
            return write_outcome(response, Outcome(Code.OPERATION_FAILED, busy))
        return write_outcome(response, self._operations.step(request.steps))

    def _reset(self, request: Any, response: Any) -> Any:
        return write_outcome(response, self._operations.reset(request.scope))

    def _accept_goal(self, _: Any) -> GoalResponse:
        if self._stepping:
            return GoalResponse.REJECT
        self._stepping = True  # here, not where it begins: a second goal may come in between
        return GoalResponse.ACCEPT

    async def _simulate_steps(self, goal: ServerGoalHandle) -> Any:
        """Take a goal's steps one by one; between them serve callbacks, as of its cancellation."""
        try:
            outcome = await self._take_steps(goal, goal.request.steps)
        finally:
            self._stepping = False
        if goal.is_cancel_requested:
            goal.canceled()
        elif outcome.code == Code.OK:
            goal.succeed()
        else:
            goal.abort()
        return write_outcome(self._action.Result(), outcome)

    async def _take_steps(self, goal: ServerGoalHandle, number: int) -> Outcome:
        outcome = self._operations.step(0)
        for done in range(1, number + 1):
            if outcome.code == Code.OK:
                outcome = self._operations.step(1)
            if outcome.code != Code.OK or goal.is_cancel_requested:
                break
            goal.publish_feedback(
                self._action.Feedback(completed_steps=done, remaining_steps=number - done)
            )
            await _NextSpin()
        return outcome


class _NextSpin:
    """Awaited, it lets the executor serve other callbacks first."""

    def __await__(self) -> Generator[None, None, None]:
        yield
