"""`crane reproduce`: the papers' claims beside what is measured."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from process_helpers import run_to_completion

from crane_bench.reproduce import measure_items
from crane_bench.reproduce.hardcases import HardCase
from crane_bench.reproduce.overhead import ClaimRow, erratum_row
from crane_bench.reproduce.overhead_erratum import erratum
from crane_bench.reproduce.page import save_pages

CRANE = Path(sys.executable).with_name("crane")
FIELDS = ["claim", "printed", "ours", "difference", "verdict"]


def crane(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Return exit code and output of the command."""
    return run_to_completion([str(CRANE), "reproduce", *arguments], limit=600.0)


def test_every_claim_holds_or_is_an_erratum() -> None:
    """No claim of the paper fails without a correction that first principles confirm."""
    rows = measure_items("overhead")["overhead"]
    assert len({row.claim for row in rows}) == len(rows) > 0
    assert not [
        row for row in rows if row.verdict != "holds" and not row.verdict.startswith("erratum: ")
    ]


def test_overhead_has_all_errata_and_properties() -> None:
    """The rows of the overhead crane cover the properties of the report and every misprint."""
    rows = {row.claim: row.verdict for row in measure_items("overhead")["overhead"]}
    wrong = " ".join(claim for claim, verdict in rows.items() if verdict.startswith("erratum"))
    for item in (
        "(145)",
        "(174), m22",
        "(174), m23",
        "1.3",
        "1.8",
        "(182)",
        "(184)",
        "(73)",
        "after (83), large",
    ):
        assert item in wrong
    for item in ("after (83), small", "before (88)", "(91)", "Remark 2", "(93)", "end of 6.2.3"):
        assert item in wrong
    right = " ".join(claim for claim, verdict in rows.items() if verdict == "holds")
    for item in (
        "M = Mᵀ",
        "positive definite",
        "skew",
        "(19)",
        "(138)",
        "(194)",
        "cond M",
        "(178)",
        "(176)",
        "(179)",
    ):
        assert item in right


@pytest.mark.parametrize(
    ("printed", "corrected", "truth", "verdict"),
    [
        (2.0, 1.0, 1.0, "erratum: half"),
        ([[1.0]], [1.0], [1.0], "erratum: half"),
        (1.0, 1.0, 1.0, "holds"),
        (2.0, 3.0, 1.0, "unexplained"),
        (1.0, 3.0, 1.0, "unexplained"),
        (2.0, 1.0 + 1e-6, 1.0, "unexplained"),
    ],
)
def test_verdicts_follow_from_the_numbers(
    printed: object, corrected: object, truth: object, verdict: str
) -> None:
    """A misprint is one only if printed and true values differ, and the correction is true."""
    assert erratum_row(erratum("here", "half", printed, corrected, truth)).verdict == verdict


def test_json_is_one_object_with_the_measured_rows() -> None:
    """With --json stdout is one object with the item and all fields of its rows."""
    result = crane("overhead", "--json")
    tables = json.loads(result.stdout)
    assert result.returncode == 0 and list(tables) == ["overhead"]
    rows = measure_items("overhead")["overhead"]
    assert [list(row) for row in tables["overhead"]] == [FIELDS] * len(rows)
    assert [(row["claim"], row["verdict"]) for row in tables["overhead"]] == [
        (row.claim, row.verdict) for row in rows
    ]


def test_varying_digits_are_marked(tmp_path: Path) -> None:
    """A wall time has a star and one digit, a rounding error a bound, all else all digits."""
    case = HardCase("a", "nodes, m", "dop853", 1.234e-13, 1e-9, None, 12345, 0.0123, "holds")
    rows = [
        ClaimRow("exact", 0, 1.5e-16, 1.5e-16, "holds"),
        ClaimRow("not", 0.5, 0.25, 0.5, "holds"),
    ]
    save_pages({"hardcases": [case], "overhead": rows}, str(tmp_path))
    page, matrices = ((tmp_path / f"{item}.md").read_text() for item in ("hardcases", "overhead"))
    assert (
        "| evaluations | time \\* | verdict |" in page and "\n\\* differs from run to run" in page
    )
    assert "| a | nodes, m | dop853 | 1.23e-13 | 1e-09 | - | 12345 | 0.01 | holds |" in page
    assert (
        "| exact | 0 | < 1e-11 | < 1e-11 | holds |" in matrices
        and "| not | 0.5 | 0.25 | 0.5 | holds |" in matrices
    )


def test_an_unknown_item_is_rejected() -> None:
    """An unknown item ends with exit code 2 and one line of the known ones, in JSON as well."""
    result = crane("overhaed", "--json")
    assert result.returncode == 2
    assert "unknown item 'overhaed', did you mean 'overhead'?" in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert json.loads(result.stdout)["error"] in result.stderr
