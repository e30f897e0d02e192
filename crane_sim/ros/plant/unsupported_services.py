"""The services of simulation_interfaces for what a crane does not do: each is answered, with one line on why not."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rclpy.node import Node

from crane_sim.ros.plant.entities import Entities
from crane_sim.ros.plant.standard_operations import Code, Outcome, write_outcome

_FRAMES = "frames of a crane have no extent; the description has drawings"
_MOVES = "frames of a crane move by its equations; reset_positions of ~/reset_simulation puts the joints anywhere"
_CRANE = "entities are the frames of the crane, no more and no fewer"
_SCENE = "the world is the scene that the plant was started with"
_POSES = "a scene has no named poses"
_SERVICES = {
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
"""Kind of each service, and why it is not supported."""
_OF_ENTITY = ("set_entity_state", "set_entity_info", "get_entity_bounds", "delete_entity")


def offer_unsupported(node: Node, package: str, entities: Entities) -> None:
    """Offer those that the package has: 0, feature unsupported; of an unknown entity 2, not found."""
    kinds = import_module(f"{package}.srv")
    for name, (kind, why) in _SERVICES.items():
        if hasattr(kinds, kind):  # earlier versions have fewer
            node.create_service(getattr(kinds, kind), name, _refusal(why, entities if name in _OF_ENTITY else None))


def _refusal(why: str, entities: Entities | None) -> Callable[[Any, Any], Any]:
    def refuse(request: Any, response: Any) -> Any:
        if entities is not None and request.entity not in entities.names:
            return write_outcome(response, entities.not_found(request.entity))
        return write_outcome(response, Outcome(Code.FEATURE_UNSUPPORTED, why))

    return refuse
