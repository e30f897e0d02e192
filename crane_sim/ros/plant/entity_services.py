"""The services of simulation_interfaces about entities: names, motions and kinds of the parts of the crane."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rclpy.node import Node

from crane_sim.description.transforms import WORLD, quaternion_of
from crane_sim.ros.common import messages
from crane_sim.ros.plant.entities import Category, Entities
from crane_sim.ros.plant.standard_operations import Code, Outcome, write_outcome
from crane_sim.ros.plant.state_publisher import set_quaternion, set_vector

_DESCRIPTIONS = {Category.ROBOT: "a frame of the crane", Category.DYNAMIC_OBJECT: "the payload"}
_OK = Outcome(Code.OK)


def offer_entities(node: Node, package: str, entities: Entities, stamp: Callable[[], int]) -> None:
    """Offer `get_entities`, `get_entity_state`, `get_entities_states` and `get_entity_info`.

    Args:
        node: offers them.
        package: of messages.
        entities: of the plant.
        stamp: returns that of the newest state [ns].
    """
    kinds, make_state = import_module(f"{package}.srv"), import_module(f"{package}.msg").EntityState

    def list_names(request: Any, response: Any) -> Any:
        outcome, response.entities = _select(entities, request.filters)
        return write_outcome(response, outcome)

    def get_states(request: Any, response: Any) -> Any:
        outcome, response.entities = _select(entities, request.filters)
        states = _states(entities, response.entities, [make_state() for _ in response.entities], stamp())
        response.states = states
        return write_outcome(response, outcome)

    def get_state(request: Any, response: Any) -> Any:
        if request.entity not in entities.names:
            return write_outcome(response, entities.not_found(request.entity))
        _states(entities, [request.entity], [response.state], stamp())
        return write_outcome(response, _OK)

    def get_info(request: Any, response: Any) -> Any:
        if request.entity not in entities.names:
            return write_outcome(response, entities.not_found(request.entity))
        category = entities.category(request.entity)
        response.info.category.category, response.info.description = int(category), _DESCRIPTIONS[category]
        return write_outcome(response, _OK)

    node.create_service(kinds.GetEntities, "get_entities", list_names)
    node.create_service(kinds.GetEntityState, "get_entity_state", get_state)
    node.create_service(kinds.GetEntitiesStates, "get_entities_states", get_states)
    node.create_service(kinds.GetEntityInfo, "get_entity_info", get_info)


def _select(entities: Entities, filters: Any) -> tuple[Outcome, list[str]]:
    """Return how the selection ends, and the names of the entities that pass."""
    if filters.tags.tags or filters.bounds.type:
        return Outcome(Code.FEATURE_UNSUPPORTED, "filters: possible: filter, categories; not tags, bounds"), []
    categories = [category.category for category in filters.categories]
    try:
        return _OK, entities.select(filters.filter, categories)
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
