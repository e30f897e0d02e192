"""How the process of a node ends."""

import sys

from process_helpers import run_to_completion

PROGRAM = """
import os, signal, sys
from crane_sim.ros.common import node_host

class Late:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)

late = Late()  # freed after Python has taken back its handlers of signals
sys.exit(node_host.main("late", {}, lambda host, settings: None))
"""


def test_a_signal_on_the_way_out_changes_no_exit_code(ros_environment: dict[str, str]) -> None:
    """A node that has done its work ends with 0, even if SIGINT comes while Python ends."""
    done = run_to_completion([sys.executable, "-c", PROGRAM], env=ros_environment)
    assert done.returncode == 0, done.stderr
