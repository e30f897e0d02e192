"""Deprecated name of the command `crane shot`, for one release: `python -m crane_sim.recording.picture RUN OUT`."""

import os
import sys

if __name__ == "__main__":
    print("python -m crane_sim.recording.picture is called crane shot now", file=sys.stderr)
    recording, output, *options = sys.argv[1:]
    program = "import sys; from crane_sim.cli import main; sys.exit(main())"
    os.execv(sys.executable, [sys.executable, "-c", program, "shot", recording, "-o", output, *options])
