"""Tests that `--changed` chooses the test files of what differs from the last commit."""

import subprocess
from pathlib import Path

import pytest
from changed_files import ChangedFiles

FILES = {
    "product/dynamics.py": "",
    "product/other.py": "",
    "config/scene.yaml": "",
    "test/helpers/helper.py": "from product import dynamics\n",
    "test/test_of_module.py": "from product.dynamics import solve\n",
    "test/test_by_helper.py": "import helper\n",
    "test/test_of_scene.py": 'NAME = "scene"\n',
    "test/test_of_other.py": "import product.other\n",
}


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Return a committed tree."""
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    author = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    for command in (["init", "-q"], ["add", "-A"], [*author, "commit", "-qm", "first"]):
        subprocess.run(["git", *command], cwd=tmp_path, check=True, timeout=60.0)
    return tmp_path


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ("product/dynamics.py", ["test_by_helper", "test_of_module"]),
        ("config/scene.yaml", ["test_of_scene"]),
        ("test/test_of_other.py", ["test_of_other"]),
        ("test/test_new.py", ["test_new"]),
        (None, []),
    ],
)
def test_files_of_a_change_are_chosen(tree: Path, changed: str | None, expected: list[str]) -> None:
    """Tests of a module are those that import it, also by a helper.

    Of another file those that name it.
    """
    if changed:
        (tree / changed).write_text("# changed\n")
    files = ChangedFiles(tree)
    assert (
        sorted(path.stem for path in (tree / "test").glob("test_*.py") if files.concern(path))
        == expected
    )
