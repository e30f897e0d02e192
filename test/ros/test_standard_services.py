"""The services and the action of simulation_interfaces over the codec, if it is importable."""

from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from bench_graph import NodeProcess, Remote, graph, remote, wait_until
from rclpy.action.client import ActionClient

from crane_sim import load_scene
from crane_sim.ros.plant.entities import Entities
from crane_sim.ros.plant.standard_operations import Code, Feature
from crane_sim.simulation.plant import Plant

pytestmark = pytest.mark.skipif(
    find_spec("simulation_interfaces") is None,
    reason="simulation_interfaces is absent (./crane interfaces builds it)",
)
SCENE = load_scene("pendulum_free", {"duration": 1e5})  # open loop
_FEEDBACK = 5.0  # s for feedback that has been sent
STOPPED, PLAYING, PAUSED, QUITTING, NO_WORLD = range(5)


class Simulator:
    """The standard services of a plant, called from a node of the test."""

    def __init__(self, plant: NodeProcess, client: Remote) -> None:
        """Call the services of `plant` by `client`."""
        self.plant, self._client, self._begun = plant, client, False
        self._kinds = import_module("simulation_interfaces.srv")
        self._action: Any = import_module("simulation_interfaces.action").SimulateSteps
        self._steps = ActionClient(client.node, self._action, "simulate_steps")

    def request(self, kind: str, name: str, /, **fields: Any) -> Any:
        """Call a service and return its answer."""
        types = getattr(self._kinds, kind)
        return self._client.request(types, name, types.Request(**fields))

    def begin(self) -> None:
        """Stop the run, which begins if no test has begun it: it stands at its first state."""
        if not self._begun:
            self.plant.send("go")
            wait_until(lambda: self.state == PLAYING, "the run")
            self._begun = True
        self.set_state(STOPPED)
        assert self.state == STOPPED
        self.wait_for_step(0)

    @property
    def state(self) -> int:
        """State of the simulation."""
        return self.request("GetSimulationState", "get_simulation_state").state.state

    def set_state(self, state: int) -> int:
        """Set the state of the simulation; return the result code."""
        wanted = import_module("simulation_interfaces.msg").SimulationState(state=state)
        return self.request(
            "SetSimulationState", "set_simulation_state", state=wanted
        ).result.result

    def step(self, **steps: int) -> Any:
        """Take steps; return the result."""
        return self.request("StepSimulation", "step_simulation", **steps).result

    def reset(self, scope: int) -> int:
        """Reset; return the result code."""
        return self.request("ResetSimulation", "reset_simulation", scope=scope).result.result

    def simulate(self, steps: int, cancel_after: int | None = None) -> tuple[int, int, list[int]]:
        """Send a goal, cancel it after some steps; return (goal status, result code, steps)."""
        assert self._steps.wait_for_server(30.0)
        completed: list[int] = []
        goal = self._action.Goal(steps=steps)
        sent = self._steps.send_goal_async(
            goal, lambda message: completed.append(message.feedback.completed_steps)
        )
        wait_until(sent.done, "the answer to the goal")
        handle: Any = sent.result()
        assert handle.accepted
        if cancel_after is not None:
            wait_until(lambda: len(completed) >= cancel_after, "feedback")
            handle.cancel_goal_async()
        result = handle.get_result_async()
        wait_until(result.done, "the result")
        answer: Any = result.result()
        if answer.status == GoalStatus.STATUS_SUCCEEDED:
            with suppress(
                AssertionError
            ):  # rclpy drops feedback that comes after the end of its goal
                wait_until(
                    lambda: completed[-1:] == [steps], "the feedback of all steps", _FEEDBACK
                )
        return answer.status, answer.result.result.result, completed

    def step_until_heard(self) -> int:
        """Take steps until their feedback comes, as discovery takes time; return how many."""
        for steps in range(1, 51):
            if self.simulate(1)[2]:
                return steps
        raise AssertionError("no feedback of 50 goals")

    def wait_for_step(self, step: int) -> None:
        """Wait until the newest joint state is that after `step` steps."""
        stamp = (step + 1) * SCENE.period_ns
        wait_until(lambda: self._client.states[-1:] == [stamp], f"the state of step {step}")

    @property
    def steps(self) -> int:
        """Steps taken up to the newest joint state."""
        return self._client.states[-1] // SCENE.period_ns - 1


@pytest.fixture(scope="module")
def simulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Simulator]:
    """Yield the services of a plant without commands, whose run has not begun, or is stopped."""
    folder = tmp_path_factory.mktemp("run")
    file = folder / "scene.yaml"
    SCENE.dump(file)
    with (
        pytest.MonkeyPatch.context() as monkeypatch,
        graph(folder, monkeypatch) as (domain, env),
        remote(domain) as client,
    ):
        matched = "expected_recorders:=1"  # the client: states of a run that is paused come once
        with NodeProcess("crane_sim.ros.plant_node", env, f"scene:={file}", matched) as plant:
            plant.await_event("ready")
            yield Simulator(plant, client)


def test_the_services_keep_their_contract(simulator: Simulator) -> None:
    """Features, states, steps and resets have the published codes, and move the crane as stated.

    The first test: the run has not begun.
    """
    features = simulator.request("GetSimulatorFeatures", "get_simulator_features").features
    assert list(features.features) == list(Feature) and "together" in features.custom_info
    assert simulator.state == STOPPED and simulator.set_state(PLAYING) == Code.INCORRECT_STATE
    simulator.begin()
    assert simulator.set_state(PLAYING) == Code.OK
    refused = simulator.step(steps=2)
    assert (refused.result, refused.error_message) == (
        Code.OPERATION_FAILED,
        "the simulation is not paused",
    )
    assert simulator.set_state(NO_WORLD) == Code.FEATURE_UNSUPPORTED
    assert [simulator.set_state(PAUSED) for _ in range(2)] == [
        Code.OK,
        Code.ALREADY_IN_TARGET_STATE,
    ]
    assert simulator.reset(1) == Code.FEATURE_UNSUPPORTED and simulator.state == PAUSED
    assert simulator.reset(0) == Code.OK
    simulator.wait_for_step(0)
    assert simulator.step().result == Code.OK  # the default of `steps` is 1
    simulator.wait_for_step(1)
    assert simulator.step(steps=9).result == Code.OK
    simulator.wait_for_step(10)
    assert simulator.set_state(STOPPED) == Code.OK and simulator.state == STOPPED
    simulator.wait_for_step(0)
    assert simulator.set_state(PLAYING) == Code.OK and simulator.state == PLAYING


FRAMES = ["base_link", "payload_link"]  # of a pendulum, and more


def test_entities_are_the_parts_of_the_crane(simulator: Simulator) -> None:
    """Frames have their names, kinds and motions; the payload moves as in the run.

    What is unknown has its code.
    """
    simulator.begin()
    assert simulator.step(steps=50).result == Code.OK
    messages = import_module("simulation_interfaces.msg")
    names = simulator.request("GetEntities", "get_entities").entities
    assert set(FRAMES) <= set(names)

    def select(**filters: Any) -> tuple[int, list[str]]:
        answer = simulator.request(
            "GetEntities", "get_entities", filters=messages.EntityFilters(**filters)
        )
        return answer.result.result, list(answer.entities)

    robot = [messages.EntityCategory(category=1)]
    assert select(filter="^payload|nothing$") == (Code.OK, ["payload_link"])
    assert select(categories=robot) == (Code.OK, [name for name in names if name != "payload_link"])
    assert select(filter="(") == (Code.OPERATION_FAILED, [])
    assert select(filter="(a{255}){255}") == (Code.OPERATION_FAILED, [])  # would take all memory
    assert select(tags=messages.TagsFilter(tags=["heavy"])) == (Code.FEATURE_UNSUPPORTED, [])
    assert select(bounds=messages.Bounds(type=3)) == (Code.FEATURE_UNSUPPORTED, [])
    states = simulator.request("GetEntitiesStates", "get_entities_states")
    payload = simulator.request("GetEntityState", "get_entity_state", entity="payload_link").state
    assert states.entities == names and states.states[names.index("payload_link")] == payload
    plant = Plant(SCENE)
    for _ in range(49):
        plant.advance()
    slower = velocity_of_payload(plant)
    plant.advance()
    position, velocity = payload.pose.position, payload.twist.linear
    # rounding
    assert [position.x, position.y, position.z] == pytest.approx(plant.payload, abs=1e-12)
    motion = Entities(plant, "").motions()["payload_link"]  # checked in test_frame_motion.py
    assert [velocity.x, velocity.y, velocity.z] == motion.velocity.tolist() and max(
        motion.velocity
    ) > 0.01
    last, mean = (velocity_of_payload(plant) - slower) / SCENE.period, payload.acceleration.linear
    faster = velocity_of_payload(plant)
    plant.advance()
    # in a period
    change = np.abs((velocity_of_payload(plant) - faster) / SCENE.period - last).max()
    assert [mean.x, mean.y, mean.z] == pytest.approx(last, abs=change) and change < 0.2 * max(
        map(abs, last)
    )
    stamp = payload.header.stamp
    assert (
        payload.header.frame_id == "world"
        and stamp.sec * 10**9 + stamp.nanosec == 51 * SCENE.period_ns
    )
    unknown = simulator.request("GetEntityState", "get_entity_state", entity="hook").result
    assert unknown.result == Code.NOT_FOUND and "payload_link" in unknown.error_message
    assert (
        simulator.request("GetEntityInfo", "get_entity_info", entity="hook").result.result
        == Code.NOT_FOUND
    )
    assert (
        simulator.request(
            "GetEntityInfo", "get_entity_info", entity="payload_link"
        ).info.category.category
        == 4
    )


UNSUPPORTED = {
    "set_entity_state": ("SetEntityState", {"entity": "payload_link", "set_pose": True}),
    "set_entity_info": ("SetEntityInfo", {"entity": "payload_link"}),
    "get_entity_bounds": ("GetEntityBounds", {"entity": "payload_link"}),
    "delete_entity": ("DeleteEntity", {"entity": "payload_link"}),
    "spawn_entity": ("SpawnEntity", {"name": "box"}),
    "spawn_entities": ("SpawnEntities", {}),
    "get_spawnables": ("GetSpawnables", {}),
    "get_named_poses": ("GetNamedPoses", {}),
    "get_named_pose_bounds": ("GetNamedPoseBounds", {"name": "home"}),
    "load_world": ("LoadWorld", {}),
    "unload_world": ("UnloadWorld", {}),
    "get_current_world": ("GetCurrentWorld", {}),
    "get_available_worlds": ("GetAvailableWorlds", {}),
}


def test_what_is_not_supported_says_so(simulator: Simulator) -> None:
    """Every other service answers unsupported, moves nothing, and is in no list of features."""
    simulator.begin()
    before = simulator.request("GetEntitiesStates", "get_entities_states").states
    for name, (kind, fields) in UNSUPPORTED.items():
        result = simulator.request(kind, name, **fields).result
        assert (result.result, bool(result.error_message)) == (Code.FEATURE_UNSUPPORTED, True), name
    for name in ("set_entity_state", "set_entity_info", "get_entity_bounds", "delete_entity"):
        assert (
            simulator.request(UNSUPPORTED[name][0], name, entity="hook").result.result
            == Code.NOT_FOUND
        ), name
    assert simulator.request("GetEntitiesStates", "get_entities_states").states == before
    features = simulator.request("GetSimulatorFeatures", "get_simulator_features").features.features
    setting, bounds, spawning, loading, entities = 11, 5, 0, 40, 50  # of SimulatorFeatures.msg
    assert not {setting, bounds, spawning, loading, entities} & set(features)
    kinds = {name for name in dir(import_module("simulation_interfaces.srv")) if name[0].isupper()}
    offered = {kind for kind, _ in UNSUPPORTED.values()} | SUPPORTED
    assert offered == {
        kind for kind in kinds if not kind.endswith(("_Request", "_Response", "_Event"))
    }


SUPPORTED = {
    "GetEntities",
    "GetEntityState",
    "GetEntitiesStates",
    "GetEntityInfo",
    "GetSimulatorFeatures",
}
SUPPORTED |= {"GetSimulationState", "SetSimulationState", "StepSimulation", "ResetSimulation"}


def velocity_of_payload(plant: Plant) -> np.ndarray:
    """Return the payload's velocity (3,) in the world."""
    return Entities(plant, "").motions()["payload_link"].velocity


def test_the_action_takes_steps_and_can_be_cancelled(simulator: Simulator) -> None:
    """A goal has feedback after each step, fails in a playing simulation, and can be cancelled.

    A cancelled goal ends early.
    """
    simulator.begin()
    assert simulator.set_state(PLAYING) == Code.OK
    assert simulator.simulate(3) == (GoalStatus.STATUS_ABORTED, Code.OPERATION_FAILED, [])
    assert simulator.set_state(STOPPED) == Code.OK
    simulator.wait_for_step(0)
    before = simulator.step_until_heard()
    *answer, completed = simulator.simulate(5)
    assert answer == [GoalStatus.STATUS_SUCCEEDED, Code.OK]
    # rclpy drops feedback that it takes with the result
    assert completed == [1, 2, 3, 4, 5][: len(completed)]
    simulator.wait_for_step(before + 5)
    status, _, completed = simulator.simulate(10_000_000, cancel_after=3)
    # a slow client may miss some
    assert status == GoalStatus.STATUS_CANCELED and completed == sorted(set(completed))
    assert simulator.state == PAUSED and simulator.steps < 10_000_000


def test_quitting_ends_the_plant(simulator: Simulator) -> None:
    """The state quitting is answered; the plant ends with exit code 0 and a summary without error.

    The last test: the plant has ended.
    """
    simulator.begin()
    assert simulator.set_state(PLAYING) == Code.OK
    assert simulator.set_state(QUITTING) == Code.OK
    assert "error" not in simulator.plant.await_event("done")["summary"]
    assert simulator.plant.process.wait(60.0) == 0  # it waits for no further request
