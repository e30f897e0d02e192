"""The environment that the simulator runs in: a source tree's own, which the script `crane` makes, or another one."""

import sys
from pathlib import Path

from crane_sim.files.catalogue import config_folder


def is_of_this_tree() -> bool:
    """Return whether the script `crane` of this tree made the environment: its stamp names the tree."""
    made = Path(sys.prefix, "crane.stamp")
    return made.is_file() and made.read_text().splitlines()[-1] == str(config_folder().parent)


def how_to_install(group: str, extra: str = "") -> str:
    """Return the command that installs a group of packages; elsewhere that is pip, and the `extra` of that name."""
    return f"./crane install {group}" if is_of_this_tree() else f"pip install 'crane_sim[{extra or group}]'"
