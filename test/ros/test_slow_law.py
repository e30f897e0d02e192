"""A law that takes its time in lockstep: it lives, and so it keeps the crane."""

import time
from pathlib import Path

import pytest
from bench_graph import JOINTS, NodeProcess, graph, remote, wait_until

from crane_sim import load_scene

TIME = 1.0  # s that the law needs for an answer, more than three leases
STEPS = 3
FIRST, SECOND = [1.0] * len(JOINTS), [2.0] * len(JOINTS)


@pytest.mark.slow
def test_a_slow_law_keeps_the_crane(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers that take several leases are taken in lockstep, and those of somebody quicker who came later are not."""
    load_scene("knuckle_setpoint", {"duration": 1e5}).dump(tmp_path / "scene.yaml")
    options = (f"scene:={tmp_path / 'scene.yaml'}", "commanded:=true", "expected_controllers:=2")
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain, "slow") as slow, remote(domain) as quick:
        with NodeProcess("crane_sim.ros.plant_node", env, *options) as plant:
            plant.await_event("ready")
            plant.order("go")
            wait_until(lambda: bool(slow.states))
            for step in range(STEPS):
                stamp = slow.states[-1]

                def heard(stamp: int = stamp, step: int = step) -> bool:
                    """Answer until that is heard: the plant's ears for several publishers may still be unknown."""
                    slow.send(stamp, FIRST)
                    time.sleep(0.05)
                    return len(slow.efforts) > step

                wait_until(heard)
                quick.answers = SECOND
                time.sleep(TIME)
            assert [effort[0] for effort in slow.efforts] == FIRST[:1] * STEPS
            assert any(
                "command of /knuckle/remote refused: /knuckle/slow commands" in line for _, line in slow.warnings
            )
