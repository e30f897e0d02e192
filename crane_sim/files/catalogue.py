"""The scenes that come with the package."""

from importlib.util import find_spec
from pathlib import Path


def config_folder() -> Path:
    """Return the folder of configuration files, beside the sources or the installed package."""
    spec = find_spec("crane_sim")
    package = (
        Path(spec.origin).resolve().parent
        if spec and spec.origin
        else Path(__file__).resolve().parents[1]
    )
    shares = (parent / "share" / "crane_sim" / "config" for parent in package.parents)
    return next(
        (folder for folder in (package.parent / "config", *shares) if folder.is_dir()),
        package.parent,
    )


def scene_files() -> dict[str, Path]:
    """Return the catalogue: scene names and their files."""
    return {file.stem: file for file in sorted((config_folder() / "scenes").glob("*.yaml"))}
