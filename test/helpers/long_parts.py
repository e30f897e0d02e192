"""Parts of the long tests, together all of them; consecutive commits run one after the other."""

import hashlib
import subprocess
from pathlib import Path

import pytest

PARTS = 4
CHOICES = ("auto", *map(str, range(PARTS)))


def part_of(test_id: str) -> str:
    """Return a test's part: a function of its id without the file, so that files can be split."""
    digest = hashlib.sha256(test_id.partition("::")[2].encode()).digest()
    return str(int.from_bytes(digest) % PARTS)


def part_of_commit(folder: Path) -> str:
    """Return the part that is due: by the number of commits; 0 without git.

    In a shallow clone it is by the commit's hash.
    """
    shallow = _ask_git(folder, "rev-parse", "--is-shallow-repository") == "true"
    count = (
        _ask_git(folder, "rev-parse", "HEAD")
        if shallow
        else _ask_git(folder, "rev-list", "--count", "HEAD")
    )
    return str(int(count or "0", 16 if shallow else 10) % PARTS)


def _ask_git(folder: Path, *arguments: str) -> str:
    try:
        answer = subprocess.run(
            ["git", "-C", folder, *arguments], capture_output=True, text=True, timeout=60.0
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return answer.stdout.strip() if answer.returncode == 0 else ""


def choose_part(config: pytest.Config) -> None:
    """Replace `--part auto` by the part that is due, and print it.

    A worker has that of its controller.
    """
    if hasattr(config, "workerinput"):
        config.option.part = config.workerinput["part"]
    if config.option.part is None or hasattr(config, "workerinput"):
        return
    if config.option.part == "auto":
        config.option.part = part_of_commit(config.rootpath)
    others = ", ".join(part for part in CHOICES[1:] if part != config.option.part)
    print(
        f"of the long tests part {config.option.part} of 0 .. {PARTS - 1}; the others: --part "
        f"{others}",
        flush=True,
    )


def deselect_other_parts(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Remove the long tests that are not of the chosen part."""
    if config.option.part is None:
        return
    others = {
        item
        for item in items
        if item.get_closest_marker("long") and part_of(item.nodeid) != config.option.part
    }
    config.hook.pytest_deselected(items=list(others))
    items[:] = [item for item in items if item not in others]
