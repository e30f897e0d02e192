"""Tables of numbers in CSV files: a header names the columns, each row is a line of numbers."""

import csv
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from crane_sim.files.errors import shorten
from crane_sim.files.yaml_text import check_regular


class Row(NamedTuple):
    """The numbers of one line."""

    line: int  # of the file, counted from one
    numbers: tuple[float, ...]


def read_table(file: Path) -> tuple[list[str], list[Row]]:
    """Return (names of the columns, rows) of a file; empty lines and a byte order mark are ignored.

    Raises:
        ValueError: one line on why it cannot be read: its row and its text.
    """
    try:
        check_regular(file)
        with file.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream)
            lines = [
                (reader.line_num, line) for line in reader if any(cell.strip() for cell in line)
            ]
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror or error}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"cannot be read: {error}") from None
    header = [cell.strip() for cell in lines[0][1]] if lines else []
    for name in header:
        if header.count(name) > 1:
            raise ValueError(f"column {shorten(name)} stands twice")
    return header, [Row(number, _read_numbers(number, line, header)) for number, line in lines[1:]]


def _read_numbers(row: int, line: list[str], header: list[str]) -> tuple[float, ...]:
    """Return the numbers of a row, as many as there are columns."""
    if len(line) != len(header):
        raise ValueError(
            f"row {row} has {len(line)} values, the header names {len(header)} columns"
        )
    return tuple(
        _read_number(f"row {row}, {name} = {shorten(cell)}", cell)
        for name, cell in zip(header, line, strict=True)
    )


def _read_number(where: str, cell: str) -> float:
    try:
        number = float(cell)
    except ValueError:
        raise ValueError(f"{where}: must be a number") from None
    if not isfinite(number):
        raise ValueError(f"{where}: must be a finite number")
    return number
