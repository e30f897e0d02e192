"""What the files of a run are called while they grow, and when more than one recorder writes them."""

from pathlib import Path


def part_of(path: str, number: int) -> Path:
    """Return the name of a part of a file, counted from 1; the first one has the whole's."""
    whole = Path(path)
    return whole if number == 1 else whole.with_name(f"{whole.stem}.part{number}{whole.suffix}")


def joining(path: Path) -> Path:
    """Return the name under which a file grows into which its parts are just being joined."""
    return path.with_name(path.name + ".tmp")


def unfinished(path: Path) -> Path:
    """Return the name under which a file, or the folder that becomes one, grows until it is complete."""
    return path.with_name(path.name + ".part")
