"""Lockstep speed against a bare echo of the same two messages: `crane bench lockstep`."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crane_bench.speed.measurement import describe_spread, machine, ratio
from crane_sim import load_scene
from crane_sim.orchestration import run
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

KINDS = ("echo", "lockstep", "lockstep, recorded")
_ECHO_TIMEOUT = 120.0  # s of silence until an echo counts as failed


def echo(scene: "Scene") -> float:
    """Return the steps per second of a bare echo with as many messages as a run of `scene`.

    Args:
        scene: gives joint names, period and number of steps.

    Raises:
        RuntimeError: the two processes did not meet, or died.
    """
    with (
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        reserve_domain() as domain,
        ProcessGroup(node_environment(domain, Path(folder))) as group,
    ):
        scene_file = Path(folder, "scene.yaml")
        scene.dump(scene_file)
        common = {"scene": str(scene_file), "steps": scene.steps}
        ping = group.start(
            "ping", "crane_bench.nodes.echo_node", scene.crane, common | {"role": "ping"}
        )
        pong = group.start(
            "pong", "crane_bench.nodes.echo_node", scene.crane, common | {"role": "pong"}
        )
        while not (ping.ready and pong.ready):
            _wait(group)
        ping.send("go")
        while ping.summary is None:
            _wait(group)
        return ping.summary["steps_per_second"]


def _wait(group: ProcessGroup) -> None:
    reported = group.listen(_ECHO_TIMEOUT)
    if failed := [child.name for child in group.children if child.fault]:
        raise RuntimeError(f"the echo failed: {failed[0]} is gone")
    if not reported:
        raise RuntimeError(f"the echo failed: no message for {_ECHO_TIMEOUT:g} s")


def lockstep(scene: "Scene", record: Path | None = None, mcap: Path | None = None) -> float:
    """Return the steps per second of a lockstep run of `scene`, recorded where a file is named.

    Raises:
        RuntimeError: the run failed; the message is one line.
    """
    summary = run(scene, record=record, mcap=mcap)
    if "error" in summary:
        raise RuntimeError(summary["error"])
    return summary["steps_per_second"]


def speeds(scene: "Scene", rounds: int, recorder: bool) -> dict[str, list[float]]:
    """Return steps per second by kind and round; kinds are interleaved, so drift affects all."""
    rates: dict[str, list[float]] = {kind: [] for kind in KINDS[: 3 if recorder else 2]}
    with tempfile.TemporaryDirectory(prefix="crane_sim-") as folder:
        for _ in range(rounds):
            rates["echo"].append(echo(scene))
            rates["lockstep"].append(lockstep(scene))
            if recorder:
                rates["lockstep, recorded"].append(lockstep(scene, Path(folder, "bench.rrd")))
    return rates


def measure_lockstep(
    name: str = "knuckle_setpoint", duration: float = 100.0, rounds: int = 5, recorder: bool = True
) -> dict[str, Any]:
    """Return steps per second of echoes and runs, and ratios to the echo, round by round.

    Args:
        name: scene of the catalogue, with a sampled law.
        duration: simulated seconds per round.
        rounds: of every kind, interleaved.
        recorder: measure runs with a recorder, too.

    Raises:
        RuntimeError: an echo or a run failed; the message is one line.
    """
    scene = load_scene(name, {"duration": duration})
    rates = speeds(scene, rounds, recorder)
    return {
        "scene": name,
        "steps_per_round": scene.steps,
        "rounds": rounds,
        "steps_per_second": {kind: describe_spread(values) for kind, values in rates.items()},
        "ratio_to_echo": {kind: ratio(values, rates["echo"]) for kind, values in rates.items()},
        "machine": machine(),
    }


def format_lockstep(results: dict[str, Any]) -> list[str]:
    """Return the medians and their ratios to the echo in lines."""
    steps, rounds = results["steps_per_round"], results["rounds"]
    lines = [
        f"steps per second over Fast DDS, {steps} steps a round, median of {rounds} interleaved "
        "rounds"
    ]
    for kind, speed in results["steps_per_second"].items():
        factor, spread = (
            results["ratio_to_echo"][kind]["median"],
            f"({speed['least']:.0f} to {speed['most']:.0f})",
        )
        lines.append(f"  {kind:<20} {speed['median']:6.0f}  {spread:<16} {factor:5.2f} x the echo")
    return [
        *lines,
        "echo: bare publish and answer of the same two messages, coded as plant and controller "
        "code them",
    ]
