"""Code blocks of a documentation page, executed in order, in a folder that looks like the tree.

A fence says by its language and title what its block is:

- `sh`: commands, which all succeed. Two that follow one another with the titles "one terminal" and
  "another terminal" run at the same time; the other terminal's gets Ctrl-C as soon as the first
  one's are done.
- any language with a file's name for a title: that file, written.
- `python`: statements, in one namespace for the page.
- `yaml`: a scene that runs; with the title "in SCENE" groups that are put into this scene of the
  catalogue.
- `text`: what something looks like; `console`: commands that need a screen, a network or another
  machine. Neither is executed.
"""

import os
import re
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from process_helpers import run_to_completion, started_program

import crane_sim
from crane_sim.files.catalogue import scene_files

ROOT = Path(__file__).parents[2]
TREE = ("crane", ".venv", "examples", "config", "docs")  # what commands of the pages name
SHOWN = ("text", "console")
EXECUTED = ("sh", "python", "yaml")
PERIODS = 3  # that a scene of a page runs
TERMINALS = ("one terminal", "another terminal")
_GRACE = 40.0  # s from Ctrl-C to SIGKILL
_AGAIN = 10.0  # s after which a person presses Ctrl-C again
_FENCE = re.compile(
    r'^```(\w*)(?: title="([^"\n]*)")?[ ]*\n(.*?)^```[ ]*$', re.MULTILINE | re.DOTALL
)
_DOMAIN = re.compile(r"(?<=--domain-id )7\b|(?<=in_domain )7\b")  # the ROS domain of all pages


class Block(NamedTuple):
    """A block of a page."""

    line: int  # of its fence, from 1
    language: str
    title: str
    text: str

    @property
    def is_file(self) -> bool:
        """Whether its title is the name of a file."""
        return bool(re.fullmatch(r"[\w./]+\.\w+", self.title))


def blocks_of(page: Path) -> list[Block]:
    """Return the fenced blocks of a page."""
    text = page.read_text()
    found = [
        Block(text.count("\n", 0, m.start()) + 1, m[1], m[2] or "", m[3])
        for m in _FENCE.finditer(text)
    ]
    assert 2 * len(found) == len(re.findall(r"^ *```", text, re.MULTILINE)), (
        f"{page}: a fence that is not understood"
    )
    return found


def execute(page: Path, folder: Path, domain: int) -> int:
    """Execute the blocks of a page in a folder, ROS commands in a domain; return how many."""
    for name in TREE:
        Path(folder, name).symlink_to(ROOT / name)
    namespace: dict[str, Any] = {}
    pending, count = iter(blocks_of(page)), 0
    for block in pending:
        where = f"{page.name}:{block.line}"
        if block.is_file:
            Path(folder, block.title).parent.mkdir(exist_ok=True)
            Path(folder, block.title).write_text(block.text)
        elif block.language == "sh":
            other = next(pending).text if block.title == TERMINALS[0] else ""
            run_commands(block.text, other, folder, domain)
        elif block.language == "python":
            exec(compile(block.text, where, "exec"), namespace)
        elif block.language == "yaml":
            run_scene(block)
        count += block.language not in SHOWN
    return count


def run_commands(text: str, other: str, folder: Path, domain: int) -> None:
    """Run a terminal's commands, and another one's meanwhile; fails if one of the former does."""
    first, second = (
        ["bash", "-euo", "pipefail", "-c", _DOMAIN.sub(str(domain), each)] for each in (text, other)
    )
    if not other:
        run_to_completion(first, cwd=folder, check=True)
        return
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with started_program(second, cwd=folder, **pipes) as process:
        try:
            run_to_completion(first, cwd=folder, check=True)
        finally:
            said = interrupt(process)
        assert "Error" not in said.replace("ExternalShutdownException", ""), said


def interrupt(process: subprocess.Popen[str]) -> str:
    """Press Ctrl-C until a program ends; return what it printed.

    Plain rclpy can lose a signal.
    """
    deadline = time.monotonic() + _GRACE
    while True:
        os.killpg(process.pid, signal.SIGINT)
        try:
            return process.communicate(timeout=_AGAIN)[0]
        except subprocess.TimeoutExpired:
            if time.monotonic() > deadline:
                raise


def run_scene(block: Block) -> None:
    """Run a scene, or groups in a scene of the catalogue, for a few periods."""
    document = yaml.safe_load(block.text)
    if block.title.startswith("in "):
        document = merge(yaml.safe_load(scene_files()[block.title[3:]].read_text()), document)
    scene = crane_sim.load_scene(document)
    crane_sim.simulate(scene, duration=PERIODS * scene.period)


def merge(document: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Return a document with changes, in groups of both key by key."""
    both = {
        key: merge(document[key], value)
        for key, value in changes.items()
        if _are_groups(document.get(key), value)
    }
    return document | changes | both


def _are_groups(*values: Any) -> bool:
    return all(isinstance(value, dict) for value in values)


def commands_of(text: str) -> Iterator[list[str]]:
    """Yield the words of every call of `./crane` in a block."""
    for line in text.splitlines():
        call = re.search(r"\./crane (.*)", line.partition(" #")[0])
        if call:
            yield call[1].split()
