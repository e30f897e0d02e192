"""Filters of names are POSIX expressions, of which none can take the plant's memory or time."""

import pytest

from crane_sim.ros.plant.entities import filter_names


@pytest.mark.parametrize(
    ("expression", "name", "expected"),
    [
        ("^payload|nothing$", "payload_link", True),
        ("^link", "payload_link", False),
        ("(_[a-z]+)+$", "payload_link", True),
        ("[[:digit:]]+", "link", False),
    ],
)
def test_an_expression_matches_as_posix_says(expression: str, name: str, expected: bool) -> None:
    """Anchors, alternatives, classes and repetitions have their POSIX meaning."""
    assert bool(filter_names(expression, [name])) is expected


NESTED = "(" * 40 + "a" + "+)" * 40
# takes glibc a second, three times as many alternatives half a minute
SLOW = "(((" + "|" * 40 + ")+)+)+"
LONG = "(" * 8 + "[a-z]*" * 26 + "+)" * 8  # takes glibc ten seconds


@pytest.mark.parametrize(
    "expression", ["(a{255}){255}", "(a)\\1", NESTED, LONG, SLOW, "((a+b)+c)+", "a" * 101]
)
def test_a_costly_expression_is_refused(expression: str) -> None:
    """Expressions that would make exponentially many states are refused before they compile.

    The C library would make these states.
    """
    with pytest.raises(ValueError, match="^filter: .* are not possible$"):
        filter_names(expression, ["link"])


def test_an_invalid_expression_is_refused_in_one_line() -> None:
    """The line has the expression and the reason that the C library gives."""
    with pytest.raises(ValueError, match=r"^filter = '\(': \S.*$"):
        filter_names("(", ["link"])
