"""Which message packages there are, and what a build needs."""

import sys
from pathlib import Path

import pytest

from crane_sim.files.errors import SceneError
from crane_sim.interfaces import packages, toolchain
from crane_sim.interfaces.packages import USES, choose, digest, find_package

ROOT = Path(__file__).parents[2]


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the module's folder of a package that is importable, in an environment of its own."""
    module = tmp_path / "modules" / "tf2_msgs"
    module.mkdir(parents=True)
    (module / "__init__.py").touch()
    monkeypatch.syspath_prepend(str(module.parent))
    monkeypatch.delitem(sys.modules, "tf2_msgs", raising=False)
    monkeypatch.setattr(packages, "digest_file", lambda name: tmp_path / f"{name}.sha256")
    return module


def test_a_package_from_elsewhere_is_used_as_it_is(installed: Path) -> None:
    """An importable package not built here is not missing; its origin is where it lies."""
    package = find_package("tf2_msgs")
    assert not package.missing and package.origin == str(installed)


@pytest.mark.parametrize("current", [True, False])
def test_a_package_is_built_again_when_its_definitions_change(
    installed: Path, tmp_path: Path, current: bool
) -> None:
    """A package that was built here is missing exactly when it was built from other definitions."""
    (tmp_path / "tf2_msgs.sha256").write_text(digest("tf2_msgs") if current else "other")
    assert find_package("tf2_msgs").missing != current


def test_unknown_packages_are_refused() -> None:
    """The name of a package that has no definitions here is an error that lists the known ones."""
    with pytest.raises(
        SceneError,
        match="package tf_msgs: unknown.*known: tf2_msgs, simulation_interfaces, control_msgs",
    ):
        choose(("tf_msgs",))


@pytest.mark.parametrize("name", USES)
def test_definitions_are_whole(name: str) -> None:
    """Every definition has its kind's sections: a message no mark, a service one, an action two."""
    marks = {".msg": 0, ".srv": 1, ".action": 2}
    files = [file for file in packages.source_folder(name).glob("*/*") if file.is_file()]
    assert files and all(
        file.read_text().splitlines().count("---") == marks[file.suffix] for file in files
    )


def test_a_missing_compiler_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a compiler the build does not begin, and one line says what to install."""
    monkeypatch.setattr(toolchain.sysconfig, "get_path", lambda _: str(ROOT))
    monkeypatch.setattr(
        toolchain, "Path", lambda *_: type("Header", (), {"is_file": lambda self: True})()
    )
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(RuntimeError, match="no compiler no-such-compiler found; install one"):
        toolchain.check_machine()
