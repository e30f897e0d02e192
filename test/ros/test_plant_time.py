"""The plant's time over ROS: waiting, single steps, resets, and the clock."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from bench_graph import JOINTS, PERIOD, NodeProcess, Remote, graph, remote, wait_until
from rcl_interfaces.msg import Parameter as Message
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, SetParametersAtomically
from rclpy.parameter import Parameter

from crane_sim import load_scene

PLANT = "crane_sim.ros.plant_node"
ZERO = [0.0] * len(JOINTS)


@pytest.fixture(scope="module")
def endless(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a scene file whose run does not end by itself."""
    file = tmp_path_factory.mktemp("scene") / "endless.yaml"
    load_scene("knuckle_setpoint", {"duration": 1e5}).dump(file)
    return str(file)


@pytest.fixture(scope="module")
def bench(
    endless: str, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[NodeProcess, Remote]]:
    """Yield a plant in lockstep that publishes its first state, and a silent node of the test."""
    with (
        pytest.MonkeyPatch.context() as monkeypatch,
        graph(tmp_path_factory.mktemp("log"), monkeypatch) as (domain, env),
    ):
        options = (f"scene:={endless}", "commanded:=true", "step_timeout:=0.2", "resends:=2")
        with remote(domain) as client, NodeProcess(PLANT, env, *options) as plant:
            plant.await_event("ready")
            plant.send("go")
            wait_until(lambda: bool(client.states))
            yield plant, client


@pytest.fixture
def paused(bench: tuple[NodeProcess, Remote]) -> Iterator[Remote]:
    """Yield the node of the test, beside a plant that is paused at its first state."""
    _, client = bench
    client.answers = None
    client.pause(True)
    assert (client.set(step_count=1, reset_positions=[], reset_velocities=[]), client.reset()) == (
        "",
        "ok",
    )
    wait_until(lambda: client.states[-1] == PERIOD)
    yield client
    client.pause(False)


def test_arrays_of_numbers_are_described_as_doubles(bench: tuple[NodeProcess, Remote]) -> None:
    """So is the parameter before it is set, and once set to an empty array or one of integers."""
    _, client = bench
    about = DescribeParameters.Request(names=["reset_positions"])
    odd = [
        ParameterValue(type=ParameterType.PARAMETER_BYTE_ARRAY),
        ParameterValue(
            type=ParameterType.PARAMETER_INTEGER_ARRAY, integer_array_value=[1, 0, 0, 1, 0, 0]
        ),
        ParameterValue(type=ParameterType.PARAMETER_STRING_ARRAY),
    ]
    for value in (None, *odd):
        if value is not None:
            request = SetParametersAtomically.Request(
                parameters=[Message(name="reset_positions", value=value)]
            )
            assert client.request(
                SetParametersAtomically, "plant/set_parameters_atomically", request
            ).result.successful
        descriptors = client.request(
            DescribeParameters, "plant/describe_parameters", about
        ).descriptors
        assert descriptors[0].type == ParameterType.PARAMETER_DOUBLE_ARRAY
    assert "parameter reset_positions is 1; it must be an array of finite numbers" in client.set(
        reset_positions=1
    )


def test_a_plant_without_answers_waits(bench: tuple[NodeProcess, Remote]) -> None:
    """Without commands lockstep reports that it waits, and resumes with the first valid one.

    It serves calls while it waits.
    """
    plant, client = bench
    why = plant.await_event("waiting")["why"]
    assert why.startswith("no valid command for state 1 within 0.6 s")
    wait_until(
        lambda: client.modes[-1] == 2 and any(message == why for _, message in client.warnings)
    )
    assert (client.pause(True), client.pause(False)) == ("ok", "ok")
    assert client.modes[-1] == 2  # it still waits
    client.answers = ZERO
    client.send(PERIOD, ZERO)
    plant.await_event("resumed")
    wait_until(lambda: client.modes[-1] == 1 and client.states[-1] > 10 * PERIOD)
    wait_until(lambda: client.warnings[-1][1] == "running")


def test_many_steps_in_one_call(paused: Remote) -> None:
    """A paused plant takes `step_count` steps, and answers how many when commands are missing."""
    client = paused
    assert client.step() == "the command for state 1 has not come yet"
    assert "step_count out of range" in client.set(step_count=0)
    client.answers = ZERO
    client.take_steps(50)
    wait_until(lambda: client.states[-1] == 51 * PERIOD)
    client.answers = None
    assert client.set(step_count=50) == ""
    assert client.step().startswith(
        ("0 of 50 steps: the command for state", "1 of 50 steps: the command for state")
    )


def test_reset_to_a_state(paused: Remote) -> None:
    """A reset goes to the parameters' state, else to the scene's, and refuses an incomplete one."""
    client = paused
    first, elsewhere = client.positions[-1], [0.3, 0.4, 0.1, 3.0, 0.0, 0.0]
    assert client.set(reset_positions=elsewhere) == ""
    assert client.reset() == "ok"
    # converted to and fro
    wait_until(lambda: client.positions[-1] == pytest.approx(elsewhere, abs=1e-12))
    assert client.set(reset_positions=[1.0]) == ""
    assert client.reset() != "ok"
    assert client.set(reset_positions=[]) == ""
    assert client.reset() == "ok"
    wait_until(lambda: client.positions[-1] == first)
    assert client.states[-1] == PERIOD


def test_a_newcomer_in_a_pause_gets_the_state(paused: Remote) -> None:
    """A node that joins a run paused on an answered state gets that state without a step."""
    paused.answers = ZERO
    paused.take_steps(1)
    with remote(paused.context.get_domain_id(), "late") as late:
        wait_until(lambda: late.states[-1:] == [2 * PERIOD], "the state where the run stands")


def test_the_clock_is_published_before_the_run(
    endless: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A node on simulation time that starts before the run has a clock; its timers follow it."""
    sim_time = {"parameter_overrides": [Parameter("use_sim_time", value=True)]}
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain, **sim_time) as client:
        ticks: list[int] = []
        client.node.create_timer(
            0.1, lambda: ticks.append(client.node.get_clock().now().nanoseconds)
        )
        with NodeProcess(PLANT, env, f"scene:={endless}", "commanded:=true") as plant:
            wait_until(lambda: client.node.get_clock().now().nanoseconds == PERIOD)
            plant.await_event("ready")
            client.answers = ZERO
            plant.send("go")
            wait_until(lambda: len(ticks) >= 5)
    steps = [later - sooner for sooner, later in zip(ticks, ticks[1:], strict=False)]
    assert ticks == sorted(ticks) and all(step > 0 for step in steps)
    # the executor may come late
    assert (ticks[-1] - ticks[0]) / len(steps) == pytest.approx(10 * PERIOD, rel=0.5)


@pytest.mark.long
@pytest.mark.parametrize("mode", ["realtime", "open loop"])
def test_single_steps_without_a_controller(
    mode: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In real time and open loop, too, a paused plant can be reset, stepped and resumed."""
    document = load_scene("knuckle_setpoint", {"duration": 1e5}).to_dict()
    if mode == "open loop":
        del document["control"]
    load_scene(document).dump(tmp_path / "scene.yaml")
    options = (
        f"scene:={tmp_path / 'scene.yaml'}",
        f"mode:={'realtime' if mode == 'realtime' else 'lockstep'}",
    )
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        with NodeProcess(PLANT, env, *options, "step_count:=7") as plant:
            plant.await_event("ready")
            plant.send("go")
            wait_until(lambda: bool(client.states))
            assert (client.pause(True), client.reset()) == ("ok", "ok")
            wait_until(lambda: client.states[-1] == PERIOD)
            assert client.step() == "ok"
            wait_until(lambda: client.states[-1] == 8 * PERIOD)
            assert client.pause(False) == "ok"
            wait_until(lambda: client.states[-1] > 10 * PERIOD)
