"""A slow law in lockstep: its command lease does not expire, as its publisher is alive.

By the lease it owns the crane.
"""

import time
from pathlib import Path

import pytest
from bench_graph import JOINTS, NodeProcess, graph, remote, wait_until

from crane_sim import load_scene

TIME = 1.0  # s that the law needs for an answer, more than three command leases
STEPS = 3
FIRST, SECOND = [1.0] * len(JOINTS), [2.0] * len(JOINTS)


@pytest.mark.slow
def test_a_slow_law_keeps_its_command_lease(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Answers slower than several leases are accepted in lockstep; a second publisher's are not.

    That one is faster, but later.
    """
    load_scene("knuckle_setpoint", {"duration": 1e5}).dump(tmp_path / "scene.yaml")
    options = (f"scene:={tmp_path / 'scene.yaml'}", "commanded:=true", "expected_controllers:=2")
    with (
        graph(tmp_path, monkeypatch) as (domain, env),
        remote(domain, "slow") as slow,
        remote(domain) as quick,
    ):
        with NodeProcess("crane_sim.ros.plant_node", env, *options) as plant:
            plant.await_event("ready")
            plant.send("go")
            wait_until(lambda: bool(slow.states))
            for step in range(STEPS):
                stamp = slow.states[-1]

                def send_answer(stamp: int = stamp, step: int = step) -> bool:
                    """Answer; return whether it applied: the plant may not be matched yet."""
                    slow.send(stamp, FIRST)
                    time.sleep(0.05)
                    return len(slow.efforts) > step

                wait_until(send_answer, f"the answer to state {step + 1}")
                quick.answers = SECOND
                time.sleep(TIME)
            assert [effort[0] for effort in slow.efforts] == FIRST[:1] * STEPS
            refused = "command of /knuckle/remote refused: /knuckle/slow owns the crane"
            wait_until(lambda: any(refused in line for _, line in slow.warnings), "the warning")
