"""Code that a recording, a bag or a study's folder names is executed only where someone says so."""

from pathlib import Path

import pytest
from command_line import crane_here
from mcap_samples import TOPICS

import crane_sim
from crane_sim import SceneError
from crane_sim import study as studies
from crane_sim.gym.environment import CraneEnv
from crane_sim.identification import read_measurements
from crane_sim.recording.comparison import compare
from crane_sim.recording.layout import layout_of_scene, text_properties
from crane_sim.recording.mcap.bag import Bag
from crane_sim.recording.replay import replay
from crane_sim.recording.run import RecordedRun
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec
from crane_sim.simulation.rollout import Rollout
from crane_sim.study.result import read_result

LAW = """
def build(settings, scene):
    gain = settings["gain"]
    return lambda t, q, v: (gain * (3.0 - q[0]) - 80.0 * v[0],)

def metrics(run):
    return {"own": 1.0}
"""
HOSTILE = "raise SystemExit('this file was executed')\n"
KINDS = ("rrd", "mcap")


def write_bag(run: Rollout, path: Path) -> Path:
    """Write the messages of a run into a bag."""
    scene = run.scene
    topics = TOPICS | {
        "joint_commands": TOPICS["applied_effort"]._replace(name="/overhead/joint_commands")
    }
    bag = Bag(path, topics, scene.period_ns, properties=text_properties(layout_of_scene(scene, "")))
    states, efforts = (
        JointStateCodec(scene.joint_names, STATE),
        JointStateCodec(scene.actuated, EFFORT),
    )
    for k, command in enumerate(run.commands):
        stamp = (k + 1) * scene.period_ns
        bag.callbacks()["joint_states"](
            states.encode(stamp, run.q[k], run.v[k], [0.0] * len(run.q[k]))
        )
        bag.callbacks()["joint_commands"](efforts.encode(stamp, command))
        bag.callbacks()["applied_effort"](efforts.encode(stamp, run.u[k]))
    bag.finish({})
    return path


@pytest.fixture
def recordings(tmp_path: Path) -> dict[str, Path]:
    """Return a recording and a bag of a run, whose law's file is a new one, not to be executed."""
    file = tmp_path / "own.py"
    file.write_text(LAW)
    control = {"law": f"{file}:build", "gain": 40.0}
    run = crane_sim.simulate("overhead_energy", duration=0.3, overrides={"control": control})
    made = {"rrd": run.record(tmp_path / "run.rrd"), "mcap": write_bag(run, tmp_path / "run.mcap")}
    file.write_text(HOSTILE)
    return made


def check_refusal(run: RecordedRun) -> None:
    """Check that a run's scene is refused in one line, and is loaded with a named law."""
    with pytest.raises(
        SceneError,
        match=r"own.py:build', which is executed only where it is named: load_scene\(law=",
    ):
        run.load_scene()
    with pytest.raises(SystemExit, match="this file was executed"):
        run.load_scene(run.law)


@pytest.mark.parametrize("kind", KINDS)
def test_a_law_is_executed_only_where_it_is_named(kind: str, recordings: dict[str, Path]) -> None:
    """A run is read, compared, identified from and replayed without executing its law's file.

    An environment is made of it likewise.
    """
    run = crane_sim.read_recording(recordings[kind])
    assert run.law.endswith("own.py:build") and len(run.t) == 30
    assert compare(run, recordings["rrd"]).differences[0]["payload"].largest == 0.0
    assert len(read_measurements(recordings[kind], crane_sim.load_scene("overhead_energy")).t) == 30
    CraneEnv(run.scene_values, max_effort=100.0).reset(seed=1)
    check_refusal(run)
    outcome = replay(run)
    assert outcome.difference is None and outcome.steps == 30
    with pytest.raises(SystemExit, match="this file was executed"):
        replay(run, run.law)
    Path(run.law.rpartition(":")[0]).write_text(LAW)
    assert replay(run, run.law).difference is None
    # with the law's settings
    assert crane_sim.simulate(run.load_scene(run.law)).q[:-1].tolist() == run.q.tolist()


def test_commands_execute_nothing(
    recordings: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """`plot`, `compare`, `report`, `replay` read the run; `replay --law` executes a named file."""
    run, page = str(recordings["mcap"]), str(tmp_path / "page.html")
    for command in (
        ("replay", run),
        ("plot", run, "-o", str(tmp_path / "plot.svg")),
        ("compare", run, str(recordings["rrd"])),
        ("report", run, "-o", page),
    ):
        done = crane_here(monkeypatch, capsys, *command)
        assert done.returncode == 0, done.stderr
    with pytest.raises(SystemExit, match="this file was executed"):
        crane_here(monkeypatch, capsys, "replay", run, "--law", f"{tmp_path}/own.py:build")


def test_a_continuous_law_is_named_where_it_is_needed(tmp_path: Path) -> None:
    """A run whose equations evaluated its law has no commands; its replay says it needs the law."""
    run = crane_sim.simulate(
        "overhead_energy", duration=0.1, overrides={"control.period": "continuous"}
    )
    read = crane_sim.read_recording(run.record(tmp_path / "run.rrd"))
    text = read.scene_text.replace("law: energy", f"law: {tmp_path}/own.py:build")
    foreign = RecordedRun(**vars(read) | {"properties": read.properties | {"scene_file": text}})
    with pytest.raises(SceneError, match="own.py:build', which is executed only where it is named"):
        replay(foreign)
    assert replay(foreign, "energy").difference is None


def test_a_study_that_is_read_executes_nothing(tmp_path: Path) -> None:
    """The metrics of a study's own function are read from its folder without the function."""
    file = tmp_path / "own.py"
    file.write_text(LAW)
    study = {
        "scene": "overhead_energy",
        "duration": 0.1,
        "parameters": {"trolley.mass": [10.0, 20.0]},
        "metrics": f"{file}:metrics",
    }
    studies.run(study, tmp_path / "study", workers=1)
    file.write_text(HOSTILE)
    assert read_result(tmp_path / "study").column("own").tolist() == [1.0, 1.0]
