"""Scenes that measure the cost of optional groups: a baseline per crane, a change per group.

They stand in `groups.yaml`: `cranes`, the `groups` of each, and which of these it has `together`.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.resources import files
from typing import Any, NamedTuple

from crane_sim.files.yaml_text import parse_yaml

Changes = Mapping[str, Any]


class Baseline(NamedTuple):
    """A crane without optional groups."""

    label: str
    scene: str  # of the catalogue
    changes: Changes = {}


class GroupCase(NamedTuple):
    """One group: its change of the baseline, and changes that both scenes need to be comparable."""

    baseline: Baseline
    group: str
    changes: Changes
    common: Changes = {}
    parts: tuple[str, ...] = ()  # groups of the same baseline that a joint case has at once; empty:
    # a single group


def read_cases() -> Iterator[GroupCase]:
    """Yield the cases of each group, and then those of several at once."""
    document = parse_yaml(
        files("crane_bench.speed").joinpath("groups.yaml").read_text(encoding="utf-8")
    )
    cranes = {label: Baseline(label, **crane) for label, crane in document["cranes"].items()}
    single = {
        label: [_make_case(cranes[label], group, changes) for group, changes in groups.items()]
        for label, groups in document["groups"].items()
    }
    for cases in single.values():
        yield from cases
    for label, groups in document["together"].items():
        yield join_groups(single[label], groups)


def _make_case(baseline: Baseline, group: str, given: Changes) -> GroupCase:
    return (
        GroupCase(baseline, group, **given)
        if "common" in given
        else GroupCase(baseline, group, given)
    )


def merge_changes(parts: Iterable[Changes]) -> Changes:
    """Return the changes of all parts, groups merged.

    Parts that set the same group must agree on common keys.
    """
    merged: dict[str, Any] = {}
    for key, value in (item for part in parts for item in part.items()):
        earlier = merged.get(key, value)
        if isinstance(value, Mapping):
            assert all(earlier[name] == value[name] for name in earlier.keys() & value.keys()), key
            merged[key] = {**earlier, **value}
        else:
            assert earlier == value, key
            merged[key] = value
    return merged


def join_groups(cases: Iterable[GroupCase], groups: Sequence[str]) -> GroupCase:
    """Return the case of several of a crane's groups at once, whose changes are merged."""
    by_group = {case.group: case for case in cases}
    joint = [by_group[group] for group in groups]
    changes, common = (
        merge_changes(case.changes for case in joint),
        merge_changes(case.common for case in joint),
    )
    return GroupCase(joint[0].baseline, "all of these at once", changes, common, tuple(groups))


CASES = tuple(read_cases())
