"""What is found by name: laws, commands and views that installed packages declare.

A layer asks for a name; which function that is, a package's `setup.py` says, this one's or one of
your own. Groups: `crane_sim.laws` (`crane_sim.laws`), `crane_sim.commands` (of `crane`; click
commands) and `crane_sim.views` (functions of a run: `record`, `plot` and `show` are what these
methods of a run call).
"""

import sys
from collections.abc import Callable
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from crane_sim.files.errors import SceneError


def find_extensions(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group."""
    return _search(group, tuple(sys.path))


@lru_cache(maxsize=8)
def _search(group: str, search_path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    """Return a group's entry points on the search path, cached: it takes milliseconds."""
    return tuple(entry_points(group=group))


def find_view(name: str) -> Callable[..., Any]:
    """Return a view of runs; raises SceneError where no installed package has it."""
    for entry in find_extensions("crane_sim.views"):
        if entry.name == name:
            return entry.load()
    raise SceneError(
        f"{name}: no package that is installed here shows a run so; install crane_sim again"
    )
