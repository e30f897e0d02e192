"""Groups of packages: which there are, and when they are installed."""

import io
import re
import sys
from contextlib import nullcontext
from importlib.metadata import metadata
from pathlib import Path

import pytest

from crane_sim.cli.commands import app
from crane_sim.cli.package_groups import GROUPS, install_groups
from crane_sim.files.errors import SceneError
from crane_sim.files.installation import how_to_install

REQUIREMENTS = Path(__file__).parents[2] / "requirements"
FAKE_PYTHON = "#!/bin/sh\necho \"$@\" >>'{log}'\nexit {code}\n"


class Terminal(io.StringIO):
    """A text stream that is a terminal."""

    def isatty(self) -> bool:
        """Return True."""
        return True


def pins_of(group: str) -> set[str]:
    """Return the pinned versions of a lock file, with their conditions."""
    return {
        line.rstrip(" \\\n")
        for line in (REQUIREMENTS / f"{group}.lock").open()
        if re.match(r"\S+==", line)
    }


def make_environment(folder: Path, monkeypatch: pytest.MonkeyPatch, code: int = 0) -> Path:
    """Make a fake environment of this tree the running one; return its log of Python's calls."""
    (folder / "crane.stamp").write_text(f"0 0\n{REQUIREMENTS.parent}\n")
    python, calls = folder / "python", folder / "calls"
    python.write_text(FAKE_PYTHON.format(log=calls, code=code))
    python.chmod(0o755)
    calls.touch()
    monkeypatch.setattr(sys, "prefix", str(folder))
    monkeypatch.setattr(sys, "executable", str(python))
    return calls


def test_every_group_agrees_with_a_run() -> None:
    """Each group has both files, pins with hashes, and the versions of a run's packages."""
    run = {pin.partition("==")[0]: pin for pin in pins_of("run") if ";" not in pin}
    for group in GROUPS:
        assert (REQUIREMENTS / f"{group}.in").is_file()
        pins = pins_of(group)
        assert pins
        for pin in pins:
            name = pin.partition("==")[0]
            assert run.get(name, pin).partition(" ;")[0] == pin.partition(" ;")[0]
        text = (REQUIREMENTS / f"{group}.lock").read_text()
        assert text.count("--hash=sha256:") >= len(pins) and "://" not in text


def test_a_group_is_installed_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first call installs the group's lock file, the second nothing, a new file again."""
    calls = make_environment(tmp_path, monkeypatch)
    install_groups("gym")
    install_groups("gym")
    assert len(calls.read_text().splitlines()) == 1 and "gym.lock" in calls.read_text()
    (tmp_path / "groups" / "gym.sha256").write_text("of an older lock file")
    install_groups("gym")
    assert len(calls.read_text().splitlines()) == 2


@pytest.mark.parametrize(("answer", "installed"), [("n", False), ("y", True), ("", True)])
def test_a_terminal_is_asked(
    answer: str, installed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is installed that the user refuses; one line says what is missing.

    Yes is the default.
    """
    calls, screen = make_environment(tmp_path, monkeypatch), Terminal()
    monkeypatch.setattr(sys, "stdin", Terminal(f"{answer}\n"))
    monkeypatch.setattr(sys, "stderr", screen)
    with (
        nullcontext()
        if installed
        else pytest.raises(SceneError, match=r"^the packages for studies: [^\n]* install")
    ):
        install_groups("study")
    assert bool(calls.read_text()) == installed
    assert (
        "install the packages for studies: tune, clusters and sensitivity of sweep (240 MB)?"
        in screen.getvalue()
    )


def test_a_failed_installation_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where pip fails, the line names the lock file and the log, and the next call tries again."""
    calls = make_environment(tmp_path, monkeypatch, code=1)
    for _ in range(2):
        with pytest.raises(
            RuntimeError, match=r"study\.lock could not be installed.*install\.log"
        ) as failure:
            install_groups("study")
        assert "\n" not in str(failure.value)
    assert len(calls.read_text().splitlines()) == 2


@pytest.mark.parametrize(
    "command",
    [
        "report .",
        "plot nothing.rrd",
        "identify overhead_energy nothing.rrd --parameters payload.mass",
        "tune nothing.yaml",
        "docs nothing",
        "reproduce nothing --save .",
        "describe --sites --save . --scene nothing",
        "bench --scene nothing --save .",
        "soak page --save .",
    ],
)
def test_input_is_checked_first(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A command whose input is not there says so, and has installed nothing."""
    calls = make_environment(tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError):
        app(command.split(), standalone_mode=False)
    assert not calls.read_text()


def test_other_environments_are_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where ./crane did not make the environment for this tree, nothing is installed.

    `crane install` says so.
    """
    calls = make_environment(tmp_path, monkeypatch)
    (tmp_path / "crane.stamp").write_text("0 0\n/another/tree\n")
    install_groups("plots")
    assert not calls.read_text()
    with pytest.raises(
        SceneError, match=r"not made by ./crane; pip install 'crane_sim\[plots\]' installs"
    ):
        app(["install", "plots"], standalone_mode=False)


def test_the_command_that_installs_is_one_that_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Messages name `./crane install` where it made the environment, pip and an extra elsewhere."""
    make_environment(tmp_path, monkeypatch)
    assert how_to_install("study", "pandas") == "./crane install study"
    (tmp_path / "crane.stamp").unlink()
    assert how_to_install("study", "pandas") == "pip install 'crane_sim[pandas]'"
    assert how_to_install("study") == "pip install 'crane_sim[study]'"


def test_every_group_is_an_extra() -> None:
    """What pip is told to install exists: each group is an extra of this package."""
    assert set(GROUPS) <= set(metadata("crane_sim").get_all("Provides-Extra") or ())


def test_an_unknown_group_names_the_others() -> None:
    """A mistyped group fails in one line with the nearest name and all of them."""
    with pytest.raises(
        SceneError, match=r"plts: no such group of packages, did you mean 'plots'\?.*study"
    ):
        app(["install", "plts"], standalone_mode=False)
