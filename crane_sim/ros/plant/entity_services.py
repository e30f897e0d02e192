"""The entity services of simulation_interfaces: names, motions and kinds of a crane's parts."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rclpy.node import Node

from crane_sim.description.rotations import quaternion_of
from crane_sim.description.transforms import WORLD
from crane_sim.ros.common import messages
from crane_sim.ros.plant.entities import Category, Entities
from crane_sim.ros.plant.standard_operations import Code, Outcome, write_outcome
from crane_sim.ros.plant.state_publisher import set_quaternion, set_vector

_DESCRIPTIONS = {Category.ROBOT: "a frame of the crane", Category.DYNAMIC_OBJECT: "the payload"}
_OK = Outcome(Code.OK)


class EntityServices:
    """Services `get_entities`, `get_entity_state`, `get_entities_states` and `get_entity_info`."""

    def __init__(
        self, node: Node, package: str, entities: Entities, stamp: Callable[[], int]
    ) -> None:
        """Offer them, of a package of messages; `stamp` returns that of the newest state [ns]."""
        self._entities, self._stamp = entities, stamp
        kinds, self._state = (
            import_module(f"{package}.srv"),
            import_module(f"{package}.msg").EntityState,
        )
        node.create_service(kinds.GetEntities, "get_entities", self._list)
        node.create_service(kinds.GetEntityState, "get_entity_state", self._get_state)
        node.create_service(kinds.GetEntitiesStates, "get_entities_states", self._get_states)
        node.create_service(kinds.GetEntityInfo, "get_entity_info", self._get_info)

    def _list(self, request: Any, response: Any) -> Any:
        outcome, response.entities = self._select(request.filters)
        return write_outcome(response, outcome)

    def _get_states(self, request: Any, response: Any) -> Any:
        outcome, names = self._select(request.filters)
        response.entities = names
        response.states = _states(
            self._entities, names, [self._state() for _ in names], self._stamp()
        )
        return write_outcome(response, outcome)

    def _get_state(self, request: Any, response: Any) -> Any:
        if request.entity not in self._entities.names:
            return write_outcome(response, self._entities.not_found(request.entity))
        _states(self._entities, [request.entity], [response.state], self._stamp())
        return write_outcome(response, _OK)

    def _get_info(self, request: Any, response: Any) -> Any:
        if request.entity not in self._entities.names:
            return write_outcome(response, self._entities.not_found(request.entity))
        category = self._entities.category(request.entity)
        response.info.category.category, response.info.description = (
            int(category),
            _DESCRIPTIONS[category],
        )
        return write_outcome(response, _OK)

    def _select(self, filters: Any) -> tuple[Outcome, list[str]]:
        """Return how the selection ends, and the names of the entities that pass."""
        if filters.tags.tags or filters.bounds.type:
            return Outcome(
                Code.FEATURE_UNSUPPORTED, "filters: possible: filter, categories; not tags, bounds"
            ), []
        categories = [category.category for category in filters.categories]
        try:
            return _OK, self._entities.select(filters.filter, categories)
        except ValueError as error:
            return Outcome(Code.OPERATION_FAILED, str(error)), []


def _states(entities: Entities, names: list[str], states: list[Any], stamp: int) -> list[Any]:
    """Return the states, with the present motion of the entities of these names, stamped [ns]."""
    if not names:
        return states
    motions, accelerations = entities.motions(), entities.accelerations()
    for name, state in zip(names, states, strict=True):
        motion, acceleration = motions[name], accelerations[name]
        state.header.frame_id = WORLD
        messages.set_stamp(state.header.stamp, stamp)
        set_vector(state.pose.position, motion.position)
        set_quaternion(state.pose.orientation, quaternion_of(motion.rotation))
        set_vector(state.twist.linear, motion.velocity)
        set_vector(state.twist.angular, motion.angular_velocity)
        set_vector(state.acceleration.linear, acceleration.linear)
        set_vector(state.acceleration.angular, acceleration.angular)
    return states
