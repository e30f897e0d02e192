"""Replays recordings without compilation; prints outcomes by name as JSON: `replays.py FILE ...`.

It runs with CRANE_SIM_INTERPRETED=1; an outcome is [steps, line on the difference, or null].
"""

import json
import sys
from pathlib import Path

import crane_sim
from crane_sim.recording.replay import replay


def main(files: list[str]) -> None:
    """Replay the recordings."""
    outcomes = {}
    for file in files:
        outcome = replay(crane_sim.read_recording(file))
        outcomes[Path(file).stem] = [outcome.steps, outcome.difference and str(outcome.difference)]
    print(json.dumps(outcomes))


if __name__ == "__main__":
    main(sys.argv[1:])
