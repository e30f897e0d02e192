"""Replays recordings without compilation and prints, as JSON, the outcome of each by its name: `replays.py FILE ...`.

It runs with NUMBA_DISABLE_JIT=1; an outcome is [steps, line on the difference, or null].
"""

import json
import sys
from importlib import import_module
from pathlib import Path

import plain_arrays

import crane_sim


def main(files: list[str]) -> None:
    """Replay the recordings."""
    import_module("crane_sim.simulation.rollout")  # with all integrators, of which `plain_arrays` replaces parts
    plain_arrays.install()
    replay = import_module("crane_sim.recording.replay").replay
    outcomes = {}
    for file in files:
        outcome = replay(crane_sim.read_recording(file))
        outcomes[Path(file).stem] = [outcome.steps, outcome.difference and str(outcome.difference)]
    print(json.dumps(outcomes))


if __name__ == "__main__":
    main(sys.argv[1:])
