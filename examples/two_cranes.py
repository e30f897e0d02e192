"""Two cranes on one clock: two plants in two namespaces, each with its controller, that step together.

`examples/in_domain 7 python examples/two_cranes.py` prints the summary of each as JSON, by namespace. The first plant
publishes /clock; neither is ever more than one period ahead of the other, and each passes through the states that it
passes through alone.
"""

import json
import signal
import subprocess
import sys

CRANES = {"harbour": "knuckle_setpoint", "hall": "overhead_energy"}  # namespace: scene, with a law and a period


def node(module: str, crane: str, **parameters: object) -> subprocess.Popen[str]:
    """Start a node of a crane."""
    command = [sys.executable, "-m", module, "--ros-args", "-r", f"__ns:=/{crane}", "-p", f"scene:={CRANES[crane]}"]
    command += [part for name, value in parameters.items() for part in ("-p", f"{name}:={json.dumps(value)}")]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def summary(log: str) -> dict:
    """Return what a plant logged at its end."""
    lines = [line[line.index("{") :] for line in log.splitlines() if "state_sha256" in line]
    return json.loads(lines[0]) if lines else {"error": log}


def main() -> None:
    """Run both to their ends."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # as Ctrl-C does: the nodes end, too
    plants, controllers = {}, []
    for number, crane in enumerate(CRANES):
        others = ",".join(other for other in CRANES if other != crane)
        plants[crane] = node("crane_sim.ros.plant_node", crane, beside=others, clock=number == 0)
        controllers.append(node("crane_control.controller_node", crane))
    try:
        print(json.dumps({crane: summary(plant.communicate()[1]) for crane, plant in plants.items()}))
    finally:
        for process in (*plants.values(), *controllers):
            process.terminate()
            process.wait()


if __name__ == "__main__":
    main()
