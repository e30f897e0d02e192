"""Names of the columns of a study's table that every study has; those of metrics are of its runs."""

from typing import Any

FIRST_COLUMNS = ("case", "sample", "variant", "law", "seed", "status", "error")
PARAMETER = "parameter."
"""What a column of a parameter begins with, before the parameter's dotted key."""
COLUMNS = (*FIRST_COLUMNS, PARAMETER, "events", "versions", "wall_time")


class OwnMetric(list[Any]):
    """The column of a metric by a study's own function; the schema of the table marks it."""
