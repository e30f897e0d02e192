"""A bag of `--mcap` gives the run back: scene, versions from metadata, steps from messages."""

import tracemalloc
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from bag_samples import TOPICS_OF_RUN, properties_of, write_bag
from mcap_samples import EFFORT_CODEC, STATE_CODEC, TOPICS

import crane_sim
from crane_sim.recording.bag import OPTIONAL_TOPICS, REQUIRED_TOPICS, decode_steps
from crane_sim.recording.bag_messages import read_messages
from crane_sim.recording.digest import with_digest
from crane_sim.recording.layout import layout_of_scene, text_properties
from crane_sim.recording.mcap.bag import Bag
from crane_sim.recording.mcap.reader import RUN, read_metadata
from crane_sim.recording.replay import replay
from crane_sim.ros.common.serialization import EFFORT, JointStateCodec
from crane_sim.simulation.hardware import measure
from crane_sim.simulation.rollout import Rollout


@cache
def recorded_run() -> Rollout:
    """Return the run whose bags are written."""
    return crane_sim.simulate("knuckle_setpoint", duration=0.1)


def test_a_bag_gives_the_run_back(tmp_path: Path) -> None:
    """Arrays are the run's bit for bit, derived ones as in its recording; commands repeat it."""
    run = crane_sim.read_recording(write_bag(tmp_path / "run.mcap", recorded_run()))
    same = crane_sim.read_recording(recorded_run().record(tmp_path / "run.rrd"))
    for name in (
        "t",
        "q",
        "v",
        "u",
        "commands",
        "reference",
        "payload",
        "tensions",
        "swing",
        "kinetic",
        "potential",
    ):
        assert np.array_equal(getattr(run, name), getattr(same, name)), name
    assert np.array_equal(run.frames.nodes, same.frames.nodes)
    assert run.scene_values == same.scene_values and run.versions == same.versions and run.finished
    outcome = replay(run)
    assert outcome.difference is None and outcome.steps == len(recorded_run().commands)


@pytest.mark.parametrize("told", [True, False])
def test_true_states_are_taken_where_a_bag_has_them(told: bool, tmp_path: Path) -> None:
    """Bags of cranes with sensors have true and measured states; older bags only measured ones."""
    run = crane_sim.simulate(
        "knuckle_setpoint", duration=0.1, overrides={"sensors": {"all": {"noise": 1e-3}}}
    )
    topics = TOPICS | (
        {"true_states": TOPICS["joint_states"]._replace(name="/knuckle/true_states")}
        if told
        else {}
    )
    bag = Bag(
        tmp_path / "run.mcap",
        topics,
        run.scene.period_ns,
        properties=text_properties(layout_of_scene(run.scene, "")),
    )
    shown = measure(run.scene, run.q[:-1], run.v[:-1])
    for k, effort in enumerate(run.u[: len(shown)]):
        stamp = (k + 1) * run.scene.period_ns
        bag.callbacks()["joint_states"](
            STATE_CODEC.encode(stamp, *np.hsplit(shown[k], 2), np.zeros(6))
        )
        bag.callbacks()["applied_effort"](EFFORT_CODEC.encode(stamp, effort))
        if told:
            bag.callbacks()["true_states"](
                STATE_CODEC.encode(stamp, run.q[k], run.v[k], np.zeros(6))
            )
    bag.finish({})
    read = crane_sim.read_recording(tmp_path / "run.mcap")
    assert np.array_equal(read.q, run.q[:-1] if told else shown[:, :6])
    assert np.array_equal(read.q_measured, shown[:, :6]) if told else read.q_measured is None
    assert read.properties["derived"] == (
        "from the true state" if told else "from what the sensors show"
    )


def test_only_topics_that_are_read_are_in_memory(tmp_path: Path) -> None:
    """Other topics' messages, such as 64 MB of pictures, are not kept, and count as readable."""
    period, picture = recorded_run().scene.period_ns, bytes(1 << 20)
    bag = Bag(tmp_path / "run.mcap", TOPICS, period)
    write = bag.callbacks()
    for k in range(1, 65):
        write["joint_states"](STATE_CODEC.encode(k * period, *np.zeros((3, 6))))
        write["robot_description"](picture)
    bag.finish({})
    read_messages(tmp_path / "run.mcap", ("joint_states",))  # imports
    tracemalloc.start()
    contents = read_messages(tmp_path / "run.mcap", ("joint_states",))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(contents.messages) == 64 and not contents.damage
    # a chunk is one picture, a few copies of which are there while it is read
    assert peak < 16 << 20


def test_what_a_bag_lacks_is_said_in_one_line(tmp_path: Path) -> None:
    """A bag without scene, without efforts, or cut off, is refused in a line on what is missing.

    The line names the file, too.
    """
    whole = write_bag(tmp_path / "whole.mcap", recorded_run()).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: 3 * len(whole) // 4])
    for file, line in (
        (write_bag(tmp_path / "foreign.mcap", recorded_run(), {}), "has no scene"),
        (
            write_bag(tmp_path / "states.mcap", recorded_run(), leave_out="applied_effort"),
            "no messages of a topic applied_effort",
        ),
        (cut, "no messages of a topic joint_states"),
    ):
        with pytest.raises(crane_sim.SceneError, match=line) as error:
            crane_sim.read_recording(file)
        assert str(error.value).startswith(f"{file}: ") and "\n" not in str(error.value)


def test_metadata_come_back(tmp_path: Path) -> None:
    """Metadata come back as they were, non-ASCII and empty values too, under their own name."""
    values = {"scene_file": "größe: 1\n", "empty": ""}
    path = write_bag(tmp_path / "run.mcap", recorded_run(), values)
    assert read_metadata(path, RUN) == with_digest(values) and read_metadata(path, "another") == {}


def test_periods_in_which_brakes_act_have_no_command(tmp_path: Path) -> None:
    """Held commands of NaN, as of a braking lockstep, leave earlier periods their commands."""
    run = recorded_run()
    braked = {len(run.commands) - 1, len(run.commands)}  # steps
    topics = TOPICS_OF_RUN | {
        "held_command": TOPICS["applied_effort"]._replace(name="/knuckle/held_command")
    }
    bag = Bag(
        tmp_path / "run.mcap", topics, run.scene.period_ns, properties=properties_of(recorded_run())
    )
    callbacks, codec = bag.callbacks(), JointStateCodec(run.scene.actuated, EFFORT)
    for k, command in enumerate(run.commands):
        stamp = (k + 1) * run.scene.period_ns
        callbacks["joint_states"](STATE_CODEC.encode(stamp, run.q[k], run.v[k], np.zeros(6)))
        callbacks["joint_commands"](codec.encode(stamp, command))
        if k + 1 in braked:
            callbacks["held_command"](codec.encode(stamp, np.full_like(command, np.nan)))
        callbacks["applied_effort"](EFFORT_CODEC.encode(stamp, run.u[k]))
    bag.finish({})
    rows = decode_steps(
        run.scene, read_messages(tmp_path / "run.mcap", REQUIRED_TOPICS, OPTIONAL_TOPICS).messages
    ).rows
    assert {row.step for row in rows if row.braked} == braked
    for row in rows:
        assert row.demanded == (None if row.step in braked else tuple(run.commands[row.step - 1]))


def test_a_bag_of_another_node_s_commands_has_no_law(tmp_path: Path) -> None:
    """A run whose commands came from elsewhere is read as such, not as one of the scene's law."""
    scene = recorded_run().scene.with_external_commands()
    external = write_bag(
        tmp_path / "run.mcap", recorded_run(), text_properties(layout_of_scene(scene, ""))
    )
    run = crane_sim.read_recording(external)
    assert run.law == "external" and run.lyapunov is None
    assert (
        crane_sim.read_recording(write_bag(tmp_path / "own.mcap", recorded_run())).lyapunov
        is not None
    )
