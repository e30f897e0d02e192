"""Two cranes on one clock: two plants in two namespaces, each with its controller.

They step together.
`examples/in_domain 7 python examples/two_cranes.py` prints the summary of each as JSON, by
namespace. The first plant publishes /clock; neither is ever more than one period ahead of the
other, and each passes through the states that it passes through alone. When a node fails the others
are ended, too, and the exit code is 1.
"""

import json
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from typing import IO

PATIENCE = 10.0  # s for a node to end in order, before it is killed
CRANES = {
    "harbour": "knuckle_setpoint",
    "hall": "overhead_energy",
}  # namespace: scene, with a law and a period


def node(
    module: str, crane: str, log: IO[str] | None = None, **parameters: object
) -> subprocess.Popen[str]:
    """Start a node of a crane, which writes its log to the terminal or to a file."""
    command = [
        sys.executable,
        "-m",
        module,
        "--ros-args",
        "-r",
        f"__ns:=/{crane}",
        "-p",
        f"scene:={CRANES[crane]}",
    ]
    command += [
        part
        for name, value in parameters.items()
        for part in ("-p", f"{name}:={json.dumps(value)}")
    ]
    return subprocess.Popen(command, stderr=log, text=True)


def summary(log: IO[str]) -> dict:
    """Return what a plant logged at its end."""
    log.seek(0)
    lines = log.read().splitlines()
    summaries = [line[line.index("{") :] for line in lines if "state_sha256" in line]
    return (
        json.loads(summaries[0])
        if summaries
        else {"error": lines[-1] if lines else "it logged nothing"}
    )


def end(*nodes: subprocess.Popen[str]) -> None:
    """End the nodes: interrupted first, and killed if they do not exit."""
    for process in nodes:
        process.terminate()
    deadline = time.monotonic() + PATIENCE
    for process in nodes:
        try:
            process.wait(max(deadline - time.monotonic(), 0.0))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def main() -> int:
    """Run both to their ends; return the exit code."""
    stopped: list[
        int
    ] = []  # SIGINT and SIGTERM, looked for in between: every node that was started is ended, too
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda came, _: stopped.append(came))
    with ExitStack() as stack:
        logs = {crane: stack.enter_context(tempfile.TemporaryFile("w+")) for crane in CRANES}
        plants, controllers = [], []
        for number, (crane, log) in enumerate(logs.items()):
            others = ",".join(other for other in CRANES if other != crane)
            plants.append(
                node("crane_sim.ros.plant_node", crane, log, beside=others, clock=number == 0)
            )
            controllers.append(node("crane_control.nodes.controller_node", crane))
        try:
            while any(plant.poll() is None for plant in plants) and not (
                stopped or failed(*plants, *controllers)
            ):
                time.sleep(0.05)
            code = int(bool(stopped) or failed(*plants, *controllers))
        finally:
            end(*plants, *controllers)
        print(json.dumps({crane: summary(log) for crane, log in logs.items()}))
    return code


def failed(*nodes: subprocess.Popen[str]) -> bool:
    """Whether a node has failed."""
    return any(process.poll() for process in nodes)


if __name__ == "__main__":
    sys.exit(main())
