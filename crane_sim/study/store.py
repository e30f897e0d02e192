"""Rows of a study on disk: an Arrow file per block, written whole or not at all, then one table.

    FOLDER/study.json         which study this is: its hash, versions and functions of one's own that run it
    FOLDER/rows/000012.arrow  a file for each block: Arrow's own form costs a fifth of Parquet's
    time
    FOLDER/table.parquet      all rows in order of their cases, when all are there

A process that ends at any moment leaves whole blocks behind, and no others.
"""  # noqa: E501

import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from crane_sim.files.errors import SceneError, shorten
from crane_sim.files.installation import import_optional
from crane_sim.files.output import partial_files, write_whole
from crane_sim.recording.files import lock_file
from crane_sim.simulation.flat_summary import cell_of
from crane_sim.study.columns import PARAMETER, OwnMetric
from crane_sim.study.identity import differing_keys, hash_of, identity_of, read_identity
from crane_sim.study.schema import Study, Values, rename_keys

ROW_GROUP = 8192  # rows that are in memory at a time
MIN_BLOCKS = 64
"""Blocks of a study that has as many cases: an interruption loses less than a part of it."""
MAX_BLOCK = 512
"""Cases of a block at most: what a block costs beside its cases is then little for each of them."""
IDENTITY, TABLE = "study.json", "table.parquet"
SEARCH = "tune.json"
"""The file of a folder of `crane tune` that says which search it is of."""
OWN_METRIC = {b"metric": b"own"}
"""Metadata of a column that is a metric by the study's own function."""
_COUNTS = ("case", "sample", "seed", "steps", "events")


def load_pyarrow(module: str = "pyarrow") -> Any:
    """Return a module of pyarrow, which only studies need.

    Raises:
        SceneError: it is not installed.
    """
    return import_optional(module, "the table of a study")


@contextmanager
def locked_folder(folder: Path, what: str) -> Iterator[None]:
    """Make a folder where there is none, and hold it for this process, however that ends.

    Raises:
        SceneError: another process runs `what` the folder is of, or it cannot be made or written.
    """
    with ExitStack() as stack:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            held = stack.enter_context(lock_file(folder))
        except OSError as error:
            raise SceneError(f"folder {folder}: {error.strerror or error}") from None
        if not held:
            raise SceneError(f"folder {folder}: another process is running this {what}")
        yield


class Store:
    """The folder of a study."""

    def __init__(self, folder: Path, study: Study, cases: int) -> None:
        """Take the folder and the number of cases; nothing is written until the folder is held."""
        self.folder, self.cases = folder, cases
        self.block = max(1, min(MAX_BLOCK, cases // MIN_BLOCKS))
        self.identity = identity_of(study)
        self._texts = _text_columns(study)
        self._rows, self._table = folder / "rows", folder / TABLE

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the folder for this process; remove the unfinished files of a killed process.

        Raises:
            SceneError: another process runs the study of this folder, it holds another study, or
                cannot be written.
        """
        with locked_folder(self.folder, "study"):
            try:
                self._check_or_write_identity()
                if self._table.exists():
                    shutil.rmtree(self._rows, ignore_errors=True)
                else:
                    self._rows.mkdir(exist_ok=True)
                for file in (
                    *self._rows.glob(".*"),
                    *self.folder.glob(".study.json.*"),
                    *partial_files(self._table),
                ):
                    file.unlink()
            except OSError as error:
                raise SceneError(f"folder {self.folder}: {error.strerror}") from None
            yield

    def _check_or_write_identity(self) -> None:
        file = self.folder / IDENTITY
        if not file.exists():
            content = json.dumps(
                {"hash": hash_of(self.identity), **self.identity}, indent=1, default=str
            )
            write_whole(file, lambda path: path.write_text(content + "\n"))
        elif (known := read_identity(file)).get("hash") != hash_of(self.identity):
            known.pop("hash", None)
            # are no part of the rows
            recordings = {"recordings": self.identity["study"]["recordings"]}
            if hash_of(known | {"study": known.get("study", {}) | recordings}) != hash_of(
                self.identity
            ):
                why = self._difference(known)
                raise SceneError(f"folder {self.folder}: {why}; name another folder, or remove it")

    def _difference(self, known: dict[str, Any]) -> str:
        """Return what differs between the study of the folder and this one."""
        known = known | {"study": rename_keys(known.get("study", {}))}
        for part, what in (("study", "another study"), ("scene", "another state of its scene")):
            if known.get(part) != json.loads(json.dumps(self.identity[part], default=str)):
                return f"holds {what}"
        if changed := differing_keys(
            self.identity.get("functions", {}), known.get("functions", {})
        ):
            return f"was begun with another content of {changed}"
        return (
            "was begun with other versions "
            f"({differing_keys(self.identity['versions'], known.get('versions', {}))})"
        )

    def cases_of(self, block: int) -> range:
        """Return the numbers of a block's cases."""
        return range(block * self.block, min((block + 1) * self.block, self.cases))

    def _file_of(self, block: int) -> Path:
        return self._rows / f"{block:06d}.arrow"

    def missing(self) -> list[int]:
        """Return the numbers of the blocks that are not there."""
        if self._table.exists():
            return []
        there = {file.name for file in self._rows.iterdir()}
        return [block for block in self._blocks() if self._file_of(block).name not in there]

    def _blocks(self) -> range:
        return range(-(-self.cases // self.block))

    def write(self, block: int, columns: Mapping[str, Any]) -> None:
        """Write the rows of a block, columns by name."""
        texts = {name: _as_text(columns[name]) for name in columns.keys() & self._texts}
        table, ipc = table_of({**columns, **texts}), load_pyarrow("pyarrow.ipc")

        def write(path: Path) -> None:
            with ipc.new_file(str(path), table.schema) as writer:
                writer.write_table(table)

        write_whole(self._file_of(block), write)

    def merge(self) -> None:
        """Write the table from the blocks, some at a time, and remove them."""
        if self._table.exists():
            return
        arrow, parquet = load_pyarrow(), load_pyarrow("pyarrow.parquet")
        files = [self._file_of(block) for block in self._blocks()]
        schema = arrow.unify_schemas(
            [_open_block(file).schema for file in files], promote_options="permissive"
        )
        identity = json.dumps({"hash": hash_of(self.identity), **self.identity}, default=str)
        schema, together = schema.with_metadata({"study": identity}), -(-ROW_GROUP // self.block)

        def write(path: Path) -> None:
            with parquet.ParquetWriter(path, schema) as writer:
                for first in range(0, len(files), together):
                    blocks = [
                        _open_block(file).read_all() for file in files[first : first + together]
                    ]
                    # the empty table brings the columns that these blocks lack, and the order
                    rows = arrow.concat_tables(
                        [schema.empty_table(), *blocks], promote_options="permissive"
                    )
                    writer.write_table(rows.cast(schema), ROW_GROUP)

        write_whole(self._table, write)
        shutil.rmtree(self._rows)


def _open_block(path: Path) -> Any:
    """Return the reader of a block's memory-mapped file; raises SceneError if it is damaged."""
    arrow = load_pyarrow()
    try:
        return load_pyarrow("pyarrow.ipc").open_file(arrow.memory_map(str(path)))
    except arrow.ArrowInvalid as error:
        raise SceneError(
            f"{path}: is damaged ({shorten(str(error))}); remove it: its cases are run anew"
        ) from None


def table_of(columns: Mapping[str, Any]) -> Any:
    """Return columns by name as a `pyarrow.Table`.

    Numbers are floats except counts, mixed values are text.
    """
    arrow = load_pyarrow()
    arrays = [_array(arrow, name, values) for name, values in columns.items()]
    marks = [OWN_METRIC if isinstance(values, OwnMetric) else None for values in columns.values()]
    fields = [
        arrow.field(name, array.type, metadata=mark)
        for name, array, mark in zip(columns, arrays, marks, strict=True)
    ]
    return arrow.table(arrays, schema=arrow.schema(fields))


def _array(arrow: Any, name: str, values: Any) -> Any:
    types = {type(value) for value in values if value is not None}
    if types and types <= {int, float}:
        counted = float not in types and (
            name in _COUNTS or name.endswith(("_steps", "_evaluations"))
        )
        return arrow.array(values, arrow.int64() if counted else arrow.float64())
    return arrow.array(values if len(types) <= 1 else _as_text(values))


def _as_text(values: Any) -> list[str | None]:
    return [None if value is None else str(value) for value in values]


def _text_columns(study: Study) -> set[str]:
    """Return the columns of parameters whose values have several types: text in every block."""
    listed = {
        key: each.values for key, each in study.parameters.items() if isinstance(each, Values)
    }
    types = {
        key: {type(cell_of(value)) for value in values} - {type(None)}
        for key, values in listed.items()
    }
    return {
        PARAMETER + key for key, each in types.items() if len(each) > 1 and each != {int, float}
    }
