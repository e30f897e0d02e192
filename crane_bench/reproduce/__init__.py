"""The papers' results and the hard cases, measured here: `crane reproduce [ITEM]`."""

from collections.abc import Callable
from typing import Any

from crane_bench.reproduce import hardcases, knuckle, observer, offshore, overhead
from crane_bench.reproduce.page import save_pages
from crane_bench.tables import print_json, print_tables
from crane_sim.files.errors import SceneError, unknown_key

ITEMS: dict[str, Callable[[], list[Any]]] = {
    "overhead": overhead.measure_overhead_claims,
    "hardcases": hardcases.measure_hard_cases,
    "knuckle": knuckle.measure_knuckle_claims,
    "offshore": offshore.measure_offshore_tables,
    "observer": observer.compare_observers,
}
"""Every item and the function that measures its rows."""
NAMES: dict[str, Callable[[], list[str]]] = {
    "overhead": overhead.name_overhead_rows,
    "hardcases": hardcases.name_hard_cases,
    "knuckle": knuckle.claims,
    "offshore": offshore.name_offshore_rows,
    "observer": observer.name_observer_rows,
}
"""Every item and the function that returns the names of its rows, in order, without measuring
them."""


def check_item(item: str | None) -> None:
    """Raise SceneError where there is no such item; None stands for all."""
    if item is not None and item not in ITEMS:
        raise SceneError(unknown_key(item, ITEMS, "item"))


def measure_items(item: str | None = None) -> dict[str, list[Any]]:
    """Return the rows of an item, or of all items, measured now.

    Raises:
        SceneError: there is no such item.
    """
    check_item(item)
    return {name: rows() for name, rows in ITEMS.items() if item in (None, name)}


def show(item: str | None, as_json: bool, folder: str | None) -> None:
    """Measure an item, or all, and print the rows as tables or as one JSON object.

    Pages are written into a folder if one is given.

    Raises:
        SceneError: there is no such item.
    """
    tables = measure_items(item)
    (print_json if as_json else print_tables)(tables)
    if folder is not None:
        save_pages(tables, folder)
