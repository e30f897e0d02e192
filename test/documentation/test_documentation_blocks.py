"""The code blocks of README and docs are executed, page by page, in their order."""

from pathlib import Path

import pytest
import yaml
from cli_commands import commands
from code_blocks import EXECUTED, ROOT, SHOWN, blocks_of, commands_of, execute

import crane_sim

PAGES = {file.stem: file for file in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))}
COSTLY = ("README", "bench_top", "identification", "looking", "studies", "your_crane", "your_law")
"""Pages whose commands start processes, or whose runs take the whole duration of a scene: minutes
in all."""
TUTORIAL = "first_controller"
EXECUTABLE = [
    name
    for name, file in PAGES.items()
    if any(block.language in EXECUTED for block in blocks_of(file))
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder that Python blocks find themselves in, and import from."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", sorted({*EXECUTABLE} - {*COSTLY, TUTORIAL}))
def test_blocks_run(name: str, folder: Path, domain_id: int) -> None:
    """Every command, program and scene of a page does what the page says it can: none fails."""
    assert execute(PAGES[name], folder, domain_id) > 0


@pytest.mark.long
@pytest.mark.parametrize("name", COSTLY)
def test_blocks_of_costly_pages_run(name: str, folder: Path, domain_id: int) -> None:
    """The same for pages with runs over ROS, recordings and reports."""
    assert execute(PAGES[name], folder, domain_id) > 0


@pytest.mark.long
def test_the_tutorial_leads_where_it_says(folder: Path, domain_id: int) -> None:
    """The tutorial's law settles when the tutorial says, with the same bits over ROS.

    All its blocks run, from first to last.
    """
    assert execute(PAGES[TUTORIAL], folder, domain_id) > 0
    lqr, own, over_ros = (
        crane_sim.read_recording(folder / "my" / f"{name}.rrd")
        for name in ("lqr", "own", "over_ros")
    )
    assert (
        own.summary["state_sha256"]
        == over_ros.summary["state_sha256"]
        != lqr.summary["state_sha256"]
    )
    for run in (lqr, own):
        settled, force = (
            run.summary["settling_time"]["trolley"],
            run.summary["peak_effort"]["trolley"],
        )
        assert (
            f"{settled:.2f} s" in PAGES[TUTORIAL].read_text()
            and f"{force / 1e3:.3g} kN" in PAGES[TUTORIAL].read_text()
        )
    assert (folder / "my" / "own.png").stat().st_size > 10_000 and (
        folder / "my" / "both.html"
    ).is_file()


def test_the_readme_says_whose_settling_it_is() -> None:
    """The scene of the README settles, slips and swings as the line beside its command says."""
    text = next(block.text for block in blocks_of(PAGES["README"]) if block.title == "mine.yaml")
    run = crane_sim.simulate(yaml.safe_load(text))
    settled, last, swing = (
        run.summary["settling_time"]["trolley"],
        run.events[-1],
        run.summary["residual_swing_deg"],
    )
    assert last[1] == "the trolley sticks"
    line = (
        f"settles to 2 % after {settled:.2f} s, slips until {last[0]:.2f} s; the load still swings "
        f"by {swing:.2f} deg"
    )
    assert line in PAGES["README"].read_text()


def test_every_block_says_what_it_is() -> None:
    """Every block is executed, a file that another block uses, or marked as only shown."""
    for name, file in PAGES.items():
        for block in blocks_of(file):
            assert block.is_file or block.language in (*EXECUTED, *SHOWN), (
                f"{name}:{block.line}: {block.language!r}"
            )
        indented = [
            line for line in file.read_text().splitlines() if line.startswith("    ./crane")
        ]
        assert not indented, f"{name}: a command outside of a fence is not executed: {indented}"


def test_commands_that_are_only_shown_exist() -> None:
    """Commands that need a screen, a network or another machine are commands of `crane`.

    They have options that it has.
    """
    known_commands = commands()
    for name, file in PAGES.items():
        calls = [
            words for b in blocks_of(file) if b.language in SHOWN for words in commands_of(b.text)
        ]
        for command, *words in calls:
            assert command in known_commands, f"{name}: crane {command}"
            known = {
                option for parameter in known_commands[command].params for option in parameter.opts
            }
            given = {word for word in words if word.startswith("--")}
            free = known_commands[command].context_settings.get("ignore_unknown_options")
            assert free or given <= known, f"{name}: crane {command} {given - known}"
