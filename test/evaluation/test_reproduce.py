"""`crane reproduce`: the papers' claims beside what is measured."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from process_helpers import run_to_completion

from crane_sim.evaluation.reproduce import measure_items
from crane_sim.evaluation.reproduce.hardcases import Case
from crane_sim.evaluation.reproduce.overhead import erratum_row
from crane_sim.evaluation.reproduce.overhead_erratum import erratum
from crane_sim.evaluation.reproduce.page import save_pages
from crane_sim.evaluation.reproduce.table import Row

CRANE = Path(sys.executable).with_name("crane")
FIELDS = ["claim", "printed", "ours", "difference", "verdict"]


def crane(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Return what the command did."""
    return run_to_completion([str(CRANE), "reproduce", *arguments], limit=600.0)


def test_every_claim_holds_or_is_an_erratum() -> None:
    """No row of the paper says that a claim fails without the correction that first principles confirm."""
    rows = measure_items("overhead")["overhead"]
    assert len({row.claim for row in rows}) == len(rows) > 0
    assert not [row for row in rows if row.verdict != "holds" and not row.verdict.startswith("erratum: ")]


def test_overhead_has_all_errata_and_properties() -> None:
    """The rows of the overhead crane cover the properties of the report and every place that is misprinted."""
    rows = {row.claim: row.verdict for row in measure_items("overhead")["overhead"]}
    wrong = " ".join(claim for claim, verdict in rows.items() if verdict.startswith("erratum"))
    for place in ("(145)", "(174), m22", "(174), m23", "1.3", "1.8", "(182)", "(184)", "(73)", "after (83), large"):
        assert place in wrong
    for place in ("after (83), small", "before (88)", "(91)", "Remark 2", "(93)", "end of 6.2.3"):
        assert place in wrong
    right = " ".join(claim for claim, verdict in rows.items() if verdict == "holds")
    for place in ("M = Mᵀ", "positive definite", "skew", "(19)", "(138)", "(194)", "cond M", "(178)", "(176)", "(179)"):
        assert place in right


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
def test_verdicts_follow_from_the_numbers(printed: object, corrected: object, truth: object, verdict: str) -> None:
    """A misprint is called one only if printed and true values differ and the correction is the truth."""
    assert erratum_row(erratum("here", "half", printed, corrected, truth)).verdict == verdict


def test_json_is_one_object_with_the_measured_rows() -> None:
    """With --json stdout is one object with the item and all fields of its rows."""
    done = crane("overhead", "--json")
    found = json.loads(done.stdout)
    assert done.returncode == 0 and list(found) == ["overhead"]
    rows = measure_items("overhead")["overhead"]
    assert [list(row) for row in found["overhead"]] == [FIELDS] * len(rows)
    assert [(row["claim"], row["verdict"]) for row in found["overhead"]] == [(row.claim, row.verdict) for row in rows]


def test_a_page_with_its_figure_is_written(tmp_path: Path) -> None:
    """Rows become a Markdown page with one line each, hard cases with a picture beside it."""
    cases = [Case("a", "nodes, m", "dop853", 1e-12, 1e-9, None, 10, 0.1, "holds")]
    save_pages({"hardcases": cases, "overhead": measure_items("overhead")["overhead"]}, str(tmp_path))
    page = (tmp_path / "hardcases.md").read_text()
    assert "| a | nodes, m | dop853 | 1e-12 | 1e-09 | - | 10 | 0.1 | holds |" in page and "(hardcases.png)" in page
    assert (tmp_path / "hardcases.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "overhead.md").read_text().count("\n| ") == len(measure_items("overhead")["overhead"]) + 1


def test_digits_that_vary_are_told_apart(tmp_path: Path) -> None:
    """A wall time has a star and one digit, what only rounding makes has none; everything else has all its digits."""
    case = Case("a", "nodes, m", "dop853", 1.234e-13, 1e-9, None, 12345, 0.0123, "holds")
    rows = [Row("exact", 0, 1.5e-16, 1.5e-16, "holds"), Row("not", 0.5, 0.25, 0.5, "holds")]
    save_pages({"hardcases": [case], "overhead": rows}, str(tmp_path))
    page, matrices = ((tmp_path / f"{item}.md").read_text() for item in ("hardcases", "overhead"))
    assert "| evaluations | time \\* | verdict |" in page and "\n\\* differs from run to run" in page
    assert "| a | nodes, m | dop853 | 1.23e-13 | 1e-09 | - | 12345 | 0.01 | holds |" in page
    assert "| exact | 0 | < 1e-11 | < 1e-11 | holds |" in matrices and "| not | 0.5 | 0.25 | 0.5 | holds |" in matrices


def test_the_table_has_a_line_for_each_row() -> None:
    """In a pipe the table is plain, and each row is one line with its claim and its verdict."""
    done = crane("overhead")
    lines = done.stdout.splitlines()
    assert done.returncode == 0 and "\x1b" not in done.stdout
    for row in measure_items("overhead")["overhead"]:
        assert any(row.claim in line and row.verdict in line for line in lines), row.claim


def test_an_unknown_item_is_bad_input() -> None:
    """An item that does not exist ends with exit code 2 and one line that names those that do, in JSON as well."""
    done = crane("overhaed", "--json")
    assert done.returncode == 2
    assert "unknown item 'overhaed', did you mean 'overhead'?" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert json.loads(done.stdout)["error"] in done.stderr
