"""The former name of `crane_sim.recording.rerun.screenshot`, for one release."""

import runpy
import sys

if __name__ == "__main__":
    print("crane_sim.recording.picture is called crane_sim.recording.rerun.screenshot now", file=sys.stderr)
    runpy.run_module("crane_sim.recording.rerun.screenshot", run_name="__main__")
