"""The result of a study: its table, and what its variants differ in."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError

from crane_sim.files.errors import SceneError, one_line, unknown_key
from crane_sim.study.columns import worst_joint
from crane_sim.study.identity import read_identity
from crane_sim.study.runs import OK
from crane_sim.study.schema import Study, rename_keys
from crane_sim.study.statistics import (
    FailureDifference,
    PairedDifference,
    compare_failures,
    compare_pairs,
)
from crane_sim.study.store import OWN_METRIC, SEARCH, TABLE, load_pyarrow

DEPRECATED_OWN_METRIC = {b"figure": b"own"}
"""Metadata of a column that is a metric by the study's own function, in tables of the previous
release."""


def read_result(folder: Path) -> "StudyResult":
    """Return the study that has been run in a folder.

    Raises:
        SceneError: the folder holds no study, one that is not finished, or a damaged one.
    """
    check_folder(folder)
    load_pyarrow()
    known = rename_keys(read_identity(folder / "study.json").get("study", {}))
    try:  # not `load_study`, whose checks of a new study may be newer than the folder
        return StudyResult(Study.model_validate(known), folder)
    except ValidationError as error:
        raise SceneError(f"folder {folder}: study: {one_line(error, Study)}") from None


def check_folder(folder: Path) -> None:
    """Raise SceneError where a folder holds no study, or one that is not finished."""
    if (folder / SEARCH).is_file():
        studies = sorted(folder.glob("held_out_*"), key=lambda each: each.stat().st_mtime)
        found = [f"; its study is {newest}" for newest in studies[-1:]]
        where = "".join(found) or " that is not finished; the same command goes on with it"
        raise SceneError(f"folder {folder}: holds a search of crane tune{where}")
    if not (folder / "study.json").is_file():
        raise SceneError(f"folder {folder}: holds no study; crane sweep makes one")
    if not (folder / TABLE).is_file():
        raise SceneError(
            f"folder {folder}: its study is not finished; the same crane sweep goes on with it"
        )


def columns_of(metric: str, columns: Sequence[str]) -> list[str]:
    """Return the columns of a metric: itself, or one of each joint.

    Raises:
        SceneError: there is no such metric.
    """
    found = [name for name in columns if name == metric or name.startswith(f"{metric}.")]
    if not found:
        raise SceneError(unknown_key(metric, columns, "metric"))
    return found


@dataclass(frozen=True, repr=False)
class StudyResult:
    """A study that has been run: a row for each run, the variants of a sample in succession.

    Metrics are read from the file column by column; only `table` holds all of them.
    """

    study: Study
    folder: Path  # with table.parquet and recordings

    @property
    def _file(self) -> Any:
        return load_pyarrow("pyarrow.parquet").ParquetFile(self.folder / TABLE)

    @cached_property
    def table(self) -> Any:
        """The whole table, a `pyarrow.Table`."""
        return self._file.read()

    @cached_property
    def types(self) -> dict[str, str]:
        """The types of the table's columns by name, such as double, int64 and string."""
        return {field.name: str(field.type) for field in self._file.schema_arrow}

    @cached_property
    def own_metrics(self) -> list[str]:
        """Columns of the metrics by the study's own function."""
        marks = OWN_METRIC.items() | DEPRECATED_OWN_METRIC.items()
        return [
            field.name
            for field in self._file.schema_arrow
            if marks & (field.metadata or {}).items()
        ]

    @property
    def own_figures(self) -> list[str]:
        """Deprecated name of `own_metrics`, for one release."""
        warnings.warn(
            "StudyResult.own_figures is now StudyResult.own_metrics",
            DeprecationWarning,
            stacklevel=2,
        )
        return self.own_metrics

    def __len__(self) -> int:
        """Return the number of runs."""
        return int(self._file.metadata.num_rows)

    def column(self, name: str) -> npt.NDArray[Any]:
        """Return a column of the table, an entry for each run.

        Numbers are NaN where a run has none, text is None.
        """
        return self._file.read([name])[name].to_numpy(zero_copy_only=False)

    def __repr__(self) -> str:
        """Return name, runs and failures in one line."""
        failed = int(np.sum(self.column("status") != OK))
        return (
            f"<StudyResult of {self.study.name!r}: {len(self)} runs, {failed} failed, "
            f"{self.folder}>"
        )

    def to_dataframe(self) -> Any:
        """Return the table as a `pandas.DataFrame`; needs the package pandas."""
        return self.table.to_pandas()

    def metric(self, name: str, variant: str) -> npt.NDArray[np.float64]:
        """Return a metric of all samples (n,) under a variant, NaN for incomplete runs.

        It is NaN too for runs that have no such metric.

        The name of a metric of every joint, as `settling_time`, stands for that of the worst one:
        the greatest, of `limit_margin` the least. Of `final_error`, also of one joint, it is the
        magnitude; `column` has the sign.

        Raises:
            SceneError: there is no such metric or variant.
        """
        rows, columns = self._rows_of(variant), columns_of(name, list(self.types))
        values = worst_joint(name, [self.column(column) for column in columns])[rows]
        return np.where(self.column("status")[rows] == OK, values, np.nan)

    def figure(self, name: str, variant: str) -> npt.NDArray[np.float64]:
        """Deprecated name of `metric`, for one release."""
        warnings.warn(
            "StudyResult.figure is now StudyResult.metric", DeprecationWarning, stacklevel=2
        )
        return self.metric(name, variant)

    def failed(self, variant: str) -> npt.NDArray[np.bool_]:
        """Return of all samples (n,) whether the run under a variant failed.

        Raises SceneError without the variant.
        """
        return self.column("status")[self._rows_of(variant)] != OK

    def _rows_of(self, variant: str) -> npt.NDArray[np.bool_]:
        names = list(self.study.variant_changes)
        if variant not in names:
            raise SceneError(unknown_key(variant, names, "variant"))
        return self.column("variant") == variant

    def differences(self, metric: str) -> dict[str, PairedDifference]:
        """Return how variants differ from the first one in a metric, on the same samples."""
        first, *others = self.study.variant_changes
        base, seed = self.metric(metric, first), self.study.seed
        return {other: compare_pairs(base, self.metric(metric, other), seed) for other in others}

    def failure_differences(self) -> dict[str, FailureDifference]:
        """Return how each further variant differs from the first one in which runs fail."""
        first, *others = self.study.variant_changes
        return {other: compare_failures(self.failed(first), self.failed(other)) for other in others}
