"""Rows of a study on disk: an Arrow file for each block of cases, written whole or not at all, then one table.

    FOLDER/study.json         which study this is: its hash, versions and functions of one's own that run it
    FOLDER/rows/000012.arrow  a file for each block: Arrow's own form costs a fifth of Parquet's time
    FOLDER/table.parquet      all rows in order of their cases, when all are there

A process that ends at any moment leaves whole blocks behind, and no others.
"""

import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError, shorten
from crane_sim.files.installation import import_optional
from crane_sim.files.output import partial_files, write_whole
from crane_sim.simulation.flat_summary import cell_of
from crane_sim.study.columns import PARAMETER, OwnMetric
from crane_sim.study.deprecated_names import rename_keys
from crane_sim.study.named_functions import hash_functions
from crane_sim.study.schema import Study, Values, scene_document
from crane_sim.study.versions import deciding_versions

ROW_GROUP = 8192  # rows that are in memory at a time
MIN_BLOCKS = 64
"""Blocks of a study that has as many cases: what is lost by an interruption is less than a part of it, per worker."""
MAX_BLOCK = 512
"""Cases of a block at most: what a block costs beside its cases is then little for each of them."""
IDENTITY = "study.json"
"""The file of a folder that says which study it is of."""
SEARCH = "tune.json"
"""The file of a folder of `crane tune` that says which search it is of."""
OWN_METRIC = {b"metric": b"own"}
"""Metadata of a column that is a metric by the study's own function."""
_INTEGERS = ("case", "sample", "seed", "steps", "events")


def load_pyarrow(module: str = "pyarrow") -> Any:
    """Return a module of pyarrow, which only studies need.

    Raises:
        SceneError: it is not installed.
    """
    return import_optional(module, "the table of a study")


def identity_of(study: Study) -> dict[str, Any]:
    """Return the study, the document of its scene in JSON, and versions and own functions that make its numbers."""
    document = scene_document(study)
    identity = {
        "study": study.model_dump(mode="json"),
        "scene": json.dumps(document, default=str),
        "versions": deciding_versions(),
    }
    functions = hash_functions(study, document)
    return identity | {"functions": functions} if functions else identity


def block_needs(identity: dict[str, Any]) -> tuple[str, dict[str, str], dict[str, str]]:
    """Return the scene, versions and functions that every process has to share which runs a part of a study."""
    return identity["scene"], identity["versions"], identity.get("functions", {})


def hash_of(identity: dict[str, Any]) -> str:
    """Return the hash of a study: folders with another one hold other numbers."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True, default=str).encode()).hexdigest()


def differing_keys(mine: Mapping[str, str], other: Mapping[str, str]) -> str:
    """Return the keys at which two identities differ, in one line; empty where they do not."""
    return ", ".join(key for key in sorted(mine.keys() | other.keys()) if mine.get(key) != other.get(key))


def read_identity(file: Path) -> dict[str, Any]:
    """Return what the file of a folder says of its study or search, groups by name.

    Raises:
        SceneError: the file is damaged, or cannot be read.
    """
    try:
        known = json.loads(file.read_text())
    except OSError as error:
        raise SceneError(f"{file}: {error.strerror}") from None
    except ValueError:  # no JSON, or no text
        known = None
    groups = ("study", "versions", "functions")
    if not isinstance(known, dict) or not all(isinstance(known.get(name, {}), dict) for name in groups):
        raise SceneError(f"{file}: is damaged; name another folder, or remove this one")
    return known


@contextmanager
def locked_folder(folder: Path, what: str) -> Iterator[None]:
    """Make a folder where there is none, and hold it for this process; it is freed with the process, however it ends.

    The lock is the folder's own: a file in it that is written anew is another file, which another process can lock.

    Raises:
        SceneError: another process runs `what` the folder is of, or it cannot be made or locked.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        raise SceneError(f"folder {folder}: {error.strerror}") from None
    try:
        _lock(descriptor, folder, what)
        yield
    finally:
        os.close(descriptor)


def _lock(descriptor: int, folder: Path, what: str) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise SceneError(f"folder {folder}: another process is running this {what}") from None
    except OSError as error:
        raise SceneError(f"folder {folder}: {error.strerror}") from None


class Store:
    """The folder of a study."""

    def __init__(self, folder: Path, study: Study, cases: int) -> None:
        """Take the folder and the number of cases; nothing is written until the folder is held."""
        self.folder, self.cases = folder, cases
        self.block = max(1, min(MAX_BLOCK, cases // MIN_BLOCKS))
        self.identity = identity_of(study)
        self.hash = hash_of(self.identity)
        self._texts = _columns_of_text(study)
        self._rows, self._file = folder / "rows", folder / IDENTITY
        self.table_file = folder / "table.parquet"

    def _check_or_write_identity(self) -> None:
        if self._file.exists():
            known = read_identity(self._file)
            if not self._holds_this(known):
                raise SceneError(f"folder {self.folder}: {self._difference(known)}; name another folder, or remove it")
            return
        content = json.dumps({"hash": self.hash, **self.identity}, indent=1, default=str)
        write_whole(self._file, lambda file: file.write_text(content + "\n"))

    def _holds_this(self, known: dict[str, Any]) -> bool:
        """Return whether the folder's study has the rows of this one: which of them are recorded does not matter."""
        if known.get("hash") == self.hash:
            return True
        study = {**known.get("study", {}), "recordings": self.identity["study"]["recordings"]}
        return hash_of({key: known[key] for key in known if key != "hash"} | {"study": study}) == self.hash

    def _difference(self, known: dict[str, Any]) -> str:
        """Return what differs between the study of the folder and this one."""
        known = {"study": rename_keys(known.get("study", {}))} | {key: known[key] for key in known if key != "study"}
        for part, what in (("study", "another study"), ("scene", "another state of its scene")):
            if known.get(part) != json.loads(json.dumps(self.identity[part], default=str)):
                return f"holds {what}"
        if changed := differing_keys(self.identity.get("functions", {}), known.get("functions", {})):
            return f"was begun with another content of {changed}"
        return f"was begun with other versions ({differing_keys(self.identity['versions'], known.get('versions', {}))})"

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the folder for this process, made where there is none; the lock ends with the process, however it ends.

        Raises:
            SceneError: another process runs the study of this folder, it holds another study, or cannot be written.
        """
        with locked_folder(self.folder, "study"):
            try:
                self._check_or_write_identity()
                if not self.table_file.exists():
                    self._rows.mkdir(exist_ok=True)
                self._remove_leftovers()
            except OSError as error:
                raise SceneError(f"folder {self.folder}: {error.strerror}") from None
            yield

    def _remove_leftovers(self) -> None:
        """Remove what a process that ended in the middle of a write has left; the folder is held."""
        for file in (*self._rows.glob(".*"), *partial_files(self._file), *partial_files(self.table_file)):
            file.unlink()
        if self.table_file.exists():
            shutil.rmtree(self._rows, ignore_errors=True)

    @property
    def blocks(self) -> range:
        """Numbers of all blocks."""
        return range(-(-self.cases // self.block))

    def cases_of(self, block: int) -> range:
        """Return the numbers of a block's cases."""
        return range(block * self.block, min((block + 1) * self.block, self.cases))

    def missing(self) -> list[int]:
        """Return the numbers of the blocks that are not there."""
        if self.table_file.exists():
            return []
        there = {file.name for file in self._rows.iterdir()}
        return [block for block in self.blocks if self._file_of(block).name not in there]

    def _file_of(self, block: int) -> Path:
        return self._rows / f"{block:06d}.arrow"

    def write(self, block: int, columns: Mapping[str, Any]) -> None:
        """Write the rows of a block, columns by name."""
        texts = {name: _as_text(columns[name]) for name in columns.keys() & self._texts}
        ipc, table = load_pyarrow("pyarrow.ipc"), table_of({**columns, **texts})

        def write(path: Path) -> None:
            with ipc.new_file(str(path), table.schema) as writer:
                writer.write_table(table)

        write_whole(self._file_of(block), write)

    def merge(self) -> None:
        """Write the table from the blocks, one after the other, and remove them."""
        if self.table_file.exists():
            return
        arrow, parquet = load_pyarrow(), load_pyarrow("pyarrow.parquet")
        files = [self._file_of(block) for block in self.blocks]
        schema = arrow.unify_schemas([_read_block(file).schema for file in files], promote_options="permissive")
        schema = schema.with_metadata({"study": json.dumps({"hash": self.hash, **self.identity}, default=str)})

        def write(path: Path) -> None:
            with parquet.ParquetWriter(path, schema) as writer:
                for group in batched(files, -(-ROW_GROUP // self.block)):
                    tables = [_with_schema(_read_block(file).read_all(), schema) for file in group]
                    writer.write_table(arrow.concat_tables(tables), ROW_GROUP)

        write_whole(self.table_file, write)
        shutil.rmtree(self._rows)


def batched(files: Sequence[Path], size: int) -> Iterator[Sequence[Path]]:
    """Yield files, `size` at a time, the last ones fewer."""
    return (files[i : i + size] for i in range(0, len(files), size))


def _read_block(path: Path) -> Any:
    """Return the reader of a block's file, which is mapped into memory.

    Raises:
        SceneError: the file is damaged.
    """
    arrow = load_pyarrow()
    try:
        return load_pyarrow("pyarrow.ipc").open_file(arrow.memory_map(str(path)))
    except arrow.ArrowInvalid as error:
        raise SceneError(f"{path}: is damaged ({shorten(str(error))}); remove it: its cases are run anew") from None


def _with_schema(table: Any, schema: Any) -> Any:
    """Return a table with the columns of a schema, empty ones where it has none."""
    arrow = load_pyarrow()
    columns = [
        table[field.name].cast(field.type) if field.name in table.column_names else arrow.nulls(len(table), field.type)
        for field in schema
    ]
    return arrow.table(columns, schema=schema)


def table_of(columns: Mapping[str, Any]) -> Any:
    """Return columns by name as a `pyarrow.Table`; numbers are floats but for counts."""
    arrow = load_pyarrow()
    arrays = {name: arrow.array(*_column(name, values, arrow)) for name, values in columns.items()}
    marks = {name: OWN_METRIC if isinstance(values, OwnMetric) else None for name, values in columns.items()}
    fields = [arrow.field(name, array.type, metadata=marks[name]) for name, array in arrays.items()]
    return arrow.table(list(arrays.values()), schema=arrow.schema(fields))


def _column(name: str, values: Any, arrow: Any) -> tuple[Any, Any]:
    """Return (values, type) of a column: numbers are floats but for counts, values of several types text."""
    if isinstance(values, np.ndarray) and values.dtype != object:
        return values, None
    types = {type(value) for value in values if value is not None}
    if types and types <= {int, float}:
        whole = name in _INTEGERS or name.endswith(("_steps", "_evaluations"))
        return values, arrow.int64() if whole and float not in types else arrow.float64()
    return values if len(types) <= 1 else _as_text(values), None


def _as_text(values: Any) -> list[str | None]:
    return [None if value is None else str(value) for value in values]


def _columns_of_text(study: Study) -> set[str]:
    """Return the columns of parameters whose values have several types: text in every block, whatever is in it."""
    listed = {key: each.values for key, each in study.parameters.items() if isinstance(each, Values)}
    types = {key: {type(cell_of(value)) for value in values} - {type(None)} for key, values in listed.items()}
    return {PARAMETER + key for key, each in types.items() if len(each) > 1 and each != {int, float}}
