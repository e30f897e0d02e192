"""The action FollowJointTrajectory over the codec, in lockstep and in real time.

It is tested where control_msgs is importable.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from action_msgs.msg import GoalStatus
from bench_graph import NodeProcess, Remote, graph, remote, wait_until
from rclpy.action.client import ActionClient
from speed_trolley import DOCUMENT
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from crane_sim import load_scene, simulate
from crane_sim.ros.controller.trajectory_action import NAME
from crane_sim.ros.controller.trajectory_goal import GoalCode
from crane_sim.scenes.scene import Scene

pytestmark = [
    pytest.mark.skipif(
        find_spec("control_msgs") is None,
        reason="control_msgs is absent (./crane interfaces builds it)",
    ),
]
NS_PER_S = 10**9
START, TIME, END = 1.0, 3.0, 0.6  # s by the stamp, s from there, m
STOP = 2.0  # s
# the client, which a paused run would not send its first state again
RECORDER = "expected_recorders:=1"


class Answer(NamedTuple):
    """The end of a goal."""

    status: int
    code: int
    line: str


class Client:
    """An action client in lockstep with a paused run: nothing moves but by `advance`.

    Attributes:
        feedback: what has come.
    """

    def __init__(self, plant: NodeProcess, node: Remote) -> None:
        """Wait for the action."""
        self.plant, self.node, self.feedback = plant, node, list[Any]()
        self._period = node.states[0]  # ns: the stamp of the first state
        self._action: Any = import_module("control_msgs.action").FollowJointTrajectory
        self._client = ActionClient(node.node, self._action, NAME)
        assert self._client.wait_for_server(30.0)

    def send(self, time: float, *position: float, start: float = 0.0, **fields: Any) -> Any:
        """Send a goal of one point, at rest; return its handle."""
        point = JointTrajectoryPoint(
            positions=position, velocities=[fields.pop("velocity", 0.0)] * len(position)
        )
        point.time_from_start.sec, point.time_from_start.nanosec = divmod(
            round(time * NS_PER_S), NS_PER_S
        )
        trajectory = JointTrajectory(
            joint_names=fields.pop("joint_names", ["trolley"]), points=[point]
        )
        trajectory.header.stamp.sec, trajectory.header.stamp.nanosec = divmod(
            round(start * NS_PER_S), NS_PER_S
        )
        goal = self._action.Goal(trajectory=trajectory, **fields)
        sent = self._client.send_goal_async(
            goal, lambda message: self.feedback.append(message.feedback)
        )
        wait_until(sent.done, "the answer to the goal")
        handle: Any = sent.result()
        assert handle.accepted
        return handle

    def answer(self, handle: Any) -> Answer:
        """Wait for the result of a goal."""
        result = handle.get_result_async()
        wait_until(result.done, "the result")
        answer: Any = result.result()
        return Answer(answer.status, answer.result.error_code, answer.result.error_string)

    def cancel(self, handle: Any) -> None:
        """Cancel a goal."""
        cancelled = handle.cancel_goal_async()
        wait_until(cancelled.done, "the answer to the cancellation")

    def advance(self, seconds: float) -> None:
        """Let the paused run move on, and wait for the state where it stands then."""
        steps = round(seconds * NS_PER_S / self._period)
        due = self.node.states[-1] + steps * self._period
        self.node.take_steps(steps)
        wait_until(lambda: self.node.states[-1] == due, "the state after the steps")

    def reset(self) -> None:
        """Let the run begin anew, and wait for its first state."""
        assert self.node.reset() == "ok"
        wait_until(lambda: self.node.states[-1] == self._period, "the first state")

    def wait_executing(self, handle: Any) -> None:
        """Wait for the status of a goal, which is latched.

        The server has matched the topic of feedback before it.
        """
        wait_until(lambda: handle.status == GoalStatus.STATUS_EXECUTING, "the status of the goal")

    def check_feedback(self) -> None:
        """Check that feedback came in order, twenty times a second; a slow client may miss some."""
        stamps = [
            message.header.stamp.sec * NS_PER_S + message.header.stamp.nanosec
            for message in self.feedback
        ]
        assert stamps and stamps == sorted(set(stamps)) and stamps[0] >= START * NS_PER_S
        assert all((stamp - START * NS_PER_S) % (NS_PER_S // 20) == 0 for stamp in stamps)
        for message in self.feedback:
            assert message.joint_names == ["trolley"]
            assert (
                message.desired.positions[0] - message.actual.positions[0]
                == message.error.positions[0]
            )

    def motion(self) -> tuple[float, float]:
        """Return position and velocity of the trolley in the newest state."""
        return self.node.positions[-1][0], self.node.velocities[-1][0]


def tolerance(name: str = "trolley", position: float = 0.0, **limits: float) -> Any:
    """Return a tolerance of a joint or coordinate."""
    return import_module("control_msgs.msg").JointTolerance(name=name, position=position, **limits)


@contextmanager
def running(
    scene: Scene, folder: Path, monkeypatch: pytest.MonkeyPatch, *arguments: str
) -> Iterator[Client]:
    """Yield a client of a run that has begun; `arguments` are parameters of its plant."""
    file = folder / "scene.yaml"
    scene.dump(file)
    mode = [argument for argument in arguments if argument.startswith("mode:=")]
    with graph(folder, monkeypatch) as (domain, env), remote(domain) as node:
        with (
            NodeProcess(
                "crane_sim.ros.plant_node", env, f"scene:={file}", RECORDER, *arguments
            ) as plant,
            NodeProcess(
                "crane_control.nodes.controller_node",
                env,
                f"scene:={file}",
                f"stop_time:={STOP}",
                *mode,
            ) as controller,
        ):
            for process in (plant, controller):
                process.await_event("ready")
                process.send("go")
            wait_until(lambda: bool(node.states), "the first state")
            yield Client(plant, node)


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    """Yield a client of a run in lockstep that is paused."""
    folder = tmp_path_factory.mktemp("run")
    with (
        pytest.MonkeyPatch.context() as monkeypatch,
        running(load_scene(DOCUMENT), folder, monkeypatch, "paused:=true") as client,
    ):
        yield client


@pytest.fixture
def client(shared: Client) -> Client:
    """Return a client of a run that is paused at its first state."""
    shared.reset()
    shared.feedback.clear()
    return shared


def test_a_cancelled_goal_stops_the_joints(client: Client) -> None:
    """A cancelled goal ends at once, also in a pause; the trolley comes to rest half its way on."""
    handle = client.send(6.0, 1.5)
    client.advance(3.0)
    before, speed = client.motion()
    client.cancel(handle)
    assert client.answer(handle)[:2] == (GoalStatus.STATUS_CANCELED, GoalCode.SUCCESSFUL)
    client.advance(STOP + 0.5)
    after, rest = client.motion()
    assert speed > 0.3 and abs(rest) < 0.1 * speed  # the payload still swings, and pulls
    # the drive lags by some 0.1 s
    assert after - before == pytest.approx(0.5 * speed * STOP, abs=0.1 * speed)


@pytest.mark.long
def test_the_reference_is_where_the_path_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The topic of the reference follows a goal at once, and goes on with it.

    Recordings and bags take this topic.

    The controller's own messages are no trajectories for it: the goal succeeds.
    """
    points = [
        {"positions": [x], "velocities": [0.0], "time_from_start": t}
        for x, t in ((0.0, 0.0), (END, TIME))
    ]
    path = {"kind": "trajectory", "of": "joints", "joint_names": ["trolley"], "points": points}
    scene, ends = (
        load_scene(DOCUMENT | {"reference": {"path": path}, "duration": 3600.0}),
        list[float](),
    )

    def comes_again() -> bool:
        # s, after which it is published again: the subscription may not have been matched before
        client.advance(1.0)
        return ends.count(0.1) >= 2

    with running(scene, tmp_path, monkeypatch, "paused:=true") as client:
        client.node.node.create_subscription(
            JointTrajectory,
            "joint_trajectory",
            lambda message: ends.append(message.points[0].positions[0]),
            10,
        )
        client.advance(0.5)
        handle = client.send(1.0, 0.1)
        client.advance(2.5)
        assert client.answer(handle).status == GoalStatus.STATUS_SUCCEEDED
        wait_until(comes_again, "the reference of the goal")
    assert ends == sorted(ends, reverse=True) and set(ends) <= {END, 0.1}


def test_a_newer_goal_takes_over_at_its_start(client: Client) -> None:
    """The older goal is followed until a newer one begins, which preempts it, and succeeds."""
    older = client.send(4.0, 2.0)
    client.advance(0.1)
    newer = client.send(1.0, 0.1, start=0.5)
    client.advance(0.3)
    client.wait_executing(older)
    client.advance(0.3)
    answer = client.answer(older)
    assert (
        answer[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.INVALID_GOAL)
        and "newer goal" in answer.line
    )
    client.advance(1.0)
    assert client.answer(newer).status == GoalStatus.STATUS_SUCCEEDED


def test_tolerances_end_a_goal(client: Client) -> None:
    """A joint out of its tolerance on the way, or too long so at the end, ends the goal by code."""
    fast = client.send(0.2, 1.0, path_tolerance=[tolerance(position=0.05)])
    client.advance(1.0)
    answer = client.answer(fast)
    assert answer[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.PATH_TOLERANCE_VIOLATED)
    assert "trolley: the position deviates by" in answer.line and "tolerance 0.05" in answer.line
    leeway = import_module("builtin_interfaces.msg").Duration(nanosec=100_000_000)
    late = client.send(
        0.2, 1.0, goal_tolerance=[tolerance(position=0.01)], goal_time_tolerance=leeway
    )
    client.advance(0.5)
    assert client.answer(late)[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.GOAL_TOLERANCE_VIOLATED)


def test_a_tolerance_of_accelerations(client: Client) -> None:
    """A path that jerks the drive beyond its ramp deviates in acceleration, by a period's mean."""
    rough = client.send(1.0, 0.5, path_tolerance=[tolerance(acceleration=0.5)])
    client.advance(0.5)
    answer = client.answer(rough)
    assert answer[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.PATH_TOLERANCE_VIOLATED)
    assert "trolley: the acceleration deviates by" in answer.line
    smooth = client.send(4.0, 0.5, path_tolerance=[tolerance(acceleration=5.0)])
    client.advance(4.1)
    assert client.answer(smooth).status == GoalStatus.STATUS_SUCCEEDED


@pytest.mark.long
def test_a_goal_of_the_payload(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that leads the payload follows goals of its x and y like the scene's path, bit for bit.

    They are checked, too.

    One that names joints is refused, one that the payload cannot follow ends by its tolerance.
    """
    changes, period = {"duration": 1.0}, 0.004
    scene = load_scene("knuckle_tracking", changes)
    begin, end = (1.35, 0.0), (1.34, 0.02)
    with running(scene, tmp_path, monkeypatch, "paused:=true") as client:
        limits = [tolerance("x", 0.05), tolerance("y", 0.05)]
        handle = client.send(
            0.6,
            *end,
            start=0.2,
            joint_names=["x", "y"],
            path_tolerance=limits,
            goal_tolerance=limits,
        )
        wrong = client.answer(client.send(1.0, 0.0, joint_names=["slew"]))
        assert (
            wrong[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.INVALID_JOINTS)
            and "must be x, y" in wrong.line
        )
        client.wait_executing(handle)
        assert client.node.pause(False) == "ok"
        assert client.answer(handle)[:2] == (GoalStatus.STATUS_SUCCEEDED, GoalCode.SUCCESSFUL)
        run = client.plant.await_event("done")["summary"]["state_sha256"]
    assert client.feedback and client.feedback[0].joint_names == ["x", "y"]
    points = [
        {"positions": x, "velocities": [0.0] * 2, "time_from_start": t}
        for x, t in ((begin, 0.0), (end, 0.6))
    ]
    path = {
        "kind": "trajectory",
        "joint_names": ["x", "y"],
        "start": 0.2 - period,
        "points": points,
    }
    assert (
        run
        == simulate(load_scene("knuckle_tracking", changes | {"reference.path": path})).summary[
            "state_sha256"
        ]
    )


@pytest.mark.long
def test_goals_in_real_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In real time goals are reached, preempted, cancelled, and ended by their tolerances.

    The crane of a cancelled goal stops.
    """
    scene = load_scene(DOCUMENT | {"duration": 3600.0})
    with running(scene, tmp_path, monkeypatch, "mode:=realtime") as client:
        reached = client.answer(client.send(1.0, 0.1, goal_tolerance=[tolerance(position=0.05)]))
        assert reached[:2] == (GoalStatus.STATUS_SUCCEEDED, GoalCode.SUCCESSFUL)
        older = client.send(60.0, 2.0)
        newer = client.send(60.0, 4.0)
        assert client.answer(older)[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.INVALID_GOAL)
        wait_until(lambda: client.motion()[1] > 0.02, "the trolley on its way")
        client.cancel(newer)
        assert client.answer(newer).status == GoalStatus.STATUS_CANCELED
        wait_until(lambda: abs(client.motion()[1]) < 0.005, "rest")
        late = client.answer(client.send(0.1, 0.0, path_tolerance=[tolerance(position=0.01)]))
        assert late[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.PATH_TOLERANCE_VIOLATED)


def test_a_reset_ends_a_goal_and_the_law_begins_anew(client: Client) -> None:
    """After a reset the goal that was followed is over, and the trolley stays at the start."""
    handle = client.send(1.0, 1.0)
    client.advance(0.5)
    client.reset()
    assert client.answer(handle)[:2] == (GoalStatus.STATUS_ABORTED, GoalCode.INVALID_GOAL)
    client.advance(0.5)
    assert client.motion() == (0.0, 0.0)


def test_a_goal_is_followed_as_the_path_of_a_scene(client: Client) -> None:
    """The run with a goal is that of `simulate` with the goal as the scene's path, bit for bit.

    Wrong goals that come in between end with their codes, and change nothing. The last test of the
    shared run: it ends.
    """
    client.advance(0.5)
    handle = client.send(TIME, END, start=START, path_tolerance=[tolerance(position=0.2)])
    wrong: list[tuple[GoalCode, dict[str, Any]]] = [
        (GoalCode.INVALID_JOINTS, {"joint_names": ["hook"]}),
        (GoalCode.INVALID_JOINTS, {"joint_names": []}),
        (GoalCode.INVALID_GOAL, {"velocity": 0.1}),
        (GoalCode.INVALID_GOAL, {"position": float("nan")}),
        (GoalCode.INVALID_GOAL, {"goal_tolerance": [tolerance(position=-0.5)]}),
        (GoalCode.INVALID_JOINTS, {"goal_tolerance": [tolerance("hook", 0.5)]}),
        (GoalCode.OLD_HEADER_TIMESTAMP, {"start": 0.1, "time": 0.2}),
    ]
    for code, fields in wrong:
        request = {"time": 1.0, "position": 1.0} | fields
        answer = client.answer(client.send(request.pop("time"), request.pop("position"), **request))
        assert answer[:2] == (GoalStatus.STATUS_ABORTED, code) and answer.line, (
            code,
            fields,
            answer,
        )
    client.wait_executing(handle)
    assert client.node.pause(False) == "ok"
    answer = client.answer(handle)
    assert answer[:2] == (GoalStatus.STATUS_SUCCEEDED, GoalCode.SUCCESSFUL)
    points = [
        {"positions": [x], "velocities": [0.0], "time_from_start": t}
        for x, t in ((0.0, 0.0), (END, TIME))
    ]
    path = {
        "kind": "trajectory",
        "of": "joints",
        "joint_names": ["trolley"],
        "start": START - 0.01,
        "points": points,
    }
    expected = simulate(load_scene(DOCUMENT | {"reference": {"path": path}})).summary[
        "state_sha256"
    ]
    assert client.plant.await_event("done")["summary"]["state_sha256"] == expected
    client.check_feedback()
