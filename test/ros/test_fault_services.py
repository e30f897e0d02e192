"""The plant's services for faults."""

from pathlib import Path

import pytest
from bench_graph import NodeProcess, graph, remote, wait_until
from std_srvs.srv import SetBool

from crane_sim import load_scene


@pytest.mark.slow
def test_a_service_for_every_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`~/faults/NAME` begins a fault with the next state, and ends it; joint states are those of the sensors."""
    file, dark = tmp_path / "scene.yaml", {"dark": {"kind": "sensor_loss", "joint": "boom"}}
    load_scene("knuckle_setpoint", {"duration": 1e5, "faults": dark}).dump(file)
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        options = (f"scene:={file}", "commanded:=true")
        with NodeProcess("crane_sim.ros.plant_node", env, *options) as plant:
            plant.await_event("ready")
            plant.send("go")
            client.answers = [0.0] * 4
            wait_until(lambda: len(client.states) > 3)
            assert client.pause(True) == "ok"
            for on in (True, False):
                answer = client.request(SetBool, "plant/faults/dark", SetBool.Request(data=on))
                assert answer.success and answer.message.startswith(f"dark is {'on' if on else 'off'} from t = ")
                count = len(client.states)
                wait_until(lambda: client.step() == "ok")
                wait_until(lambda count=count: len(client.states) > count)
                assert (client.positions[-1][1] == 0.0) == on and client.positions[-1][2] != 0.0
