"""The pages in docs: each names the command that writes it, and has the rows of this command."""

import re
from pathlib import Path

import pytest
from cli_commands import commands

from crane_bench.cli.soak import soak
from crane_bench.documentation.api_page import api_page
from crane_bench.documentation.pages import HAND_WRITTEN, PAGES, first_cells, trials_in
from crane_bench.documentation.pictures import PICTURES
from crane_bench.league.sampled_data import read_cells
from crane_bench.league.sampled_table import format_samples
from crane_bench.speed.page import format_page as performance
from crane_bench.speed.store import read_store
from crane_sim.cli.commands import app
from crane_sim.cli.report import WITHOUT_ROS
from crane_sim.files.errors import SceneError
from crane_sim.ros.plant_node import PARAMETERS
from crane_sim.simulation.rollout import simulate

DOCS = Path(__file__).parents[2] / "docs"


def text(name: str) -> str:
    """Return a page."""
    return (DOCS / f"{name}.md").read_text()


def test_every_page_is_listed() -> None:
    """Each page in the folder is written by a command, or listed as written by hand."""
    assert {file.stem for file in DOCS.glob("*.md")} == {*PAGES, *HAND_WRITTEN}


def test_the_first_page_leads_to_all() -> None:
    """The first page has a link to every other one."""
    assert {f"{name}.md" for name in {*PAGES, *HAND_WRITTEN} - {"index"}} == set(
        re.findall(r"\(([a-z0-9_]+\.md)\)", text("index"))
    )


@pytest.mark.parametrize("name", PAGES)
def test_a_page_names_its_command(name: str) -> None:
    """The first lines of a page name its command as `crane docs` does."""
    assert f"\n\nWritten by `crane {PAGES[name].command}`" in text(name)[:200]


def test_commands_of_the_soaks_exist() -> None:
    """The page of the soaks is written by an existing command, from data of other existing ones."""
    page = PAGES["soak"]
    assert {command.split()[1] for command in (page.command, *page.measured)} == set(soak.commands)


@pytest.mark.parametrize("name", PAGES)
def test_a_page_has_the_rows_of_its_command(name: str) -> None:
    """The rows of a page have the names of its command's rows, no case more or less."""
    page = PAGES[name]
    assert sorted(page.read_rows(text(name))) == sorted(page.expected_rows()), (
        f"out of date: ./crane {page.command}"
    )


def test_the_benchmarks_page_is_written_from_its_data() -> None:
    """The page of the benchmark is exactly the output of its command from the data beside it."""
    assert text("performance") == performance(read_store(DOCS), drawn=True)


def test_the_league_over_samples_is_written_from_its_data() -> None:
    """The page of the league over samples is exactly its command's output from its data."""
    assert text("league_samples") == format_samples(read_cells(DOCS))


def test_the_python_page_is_written_from_the_source() -> None:
    """The page on the Python interface is its command's output, and describes all attributes."""
    assert text("api") == api_page(), f"out of date: ./crane {PAGES['api'].command}"
    bare = [
        line for line in text("api").splitlines() if line.startswith("- `") and ": " not in line
    ]
    assert bare == []


def test_commands_and_their_options_are_described() -> None:
    """The page of the commands has a row for each, and one for each option of `crane run`."""
    page = text("commands")
    assert {name for name in commands() if f"\n| `./crane {name}" not in page} == set()
    options = {
        name for option in commands()["run"].params for name in option.opts if name.startswith("--")
    }
    assert {name for name in options if f"`{name}" not in page} == set()


def test_metrics_are_described() -> None:
    """The page of the summary has each metric of a run, over ROS or not."""
    metrics = simulate("overhead_energy", duration=0.1).summary.keys() | WITHOUT_ROS.keys()
    assert {name for name in metrics if f"`{name}`" not in text("summary")} == set()


def test_parameters_are_described() -> None:
    """The page on ROS has each parameter of the plant."""
    assert {name for name in PARAMETERS if f"`{name}`" not in text("ros")} == set()


def test_rows_are_read_from_pages() -> None:
    """Names of rows are read from Markdown: several cells, no heads and rules.

    Laws that do not apply are read as well.
    """
    table = "| a | b |\n|---|---|\n| one | 1 |\n| two | 2 |\n| one | 3 |\n"
    assert first_cells(1, table) == ["one", "two", "one"] and first_cells(2, table) == [
        "one, 1",
        "two, 2",
        "one, 3",
    ]
    league = (
        "## Boom\n\n| law | trial | x |\n|---|---|---|\n| pd | sea: not controlled | 1 |\n\n## "
        "Does not apply\n\n"
    )
    assert trials_in(league + "- boom, lqr, gust: why: so\n") == [
        "boom, pd, sea",
        "boom, lqr, gust",
    ]


def test_the_command_lists_pages_and_rejects_others(capsys: pytest.CaptureFixture[str]) -> None:
    """`crane docs` lists each page with its command; a page without a command is bad input."""
    app(["docs"], standalone_mode=False)
    listed = capsys.readouterr().out
    assert all(f"crane {page.command}" in listed for page in PAGES.values())
    with pytest.raises(SceneError, match="unknown page 'profiling'"):
        app(["docs", "profiling"], standalone_mode=False)


def test_every_picture_is_made_by_a_command() -> None:
    """Each picture that README or a page shows is there, made by a command or a test program."""
    programs = [file.read_text() for file in (DOCS.parent / "test" / "programs").glob("*.py")]
    for page in (DOCS.parent / "README.md", *DOCS.glob("*.md")):
        for file in re.findall(r"!\[[^]]*\]\(([^)]*)\)", page.read_text()):
            assert (page.parent / file).is_file(), f"{page.name}: {file}"
            written = page.stem in PAGES or any(
                f"Writes docs/{file}" in program for program in programs
            )
            assert written or Path(file).name in PICTURES, f"{page.name}: nothing makes {file}"
    assert all((DOCS / name).is_file() for name in PICTURES)


def test_the_python_interface_is_of_no_scene() -> None:
    """`describe SCENE --ros2-control --python` asks for two pages: one line says so."""
    with pytest.raises(
        SceneError,
        match="^crane describe overhead_energy --python: the Python interface is that of all",
    ):
        app(["describe", "overhead_energy", "--ros2-control", "--python"], standalone_mode=False)
