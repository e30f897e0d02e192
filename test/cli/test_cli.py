"""The command `crane`: exit codes, single-line errors, JSON, tables."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
from importlib.metadata import EntryPoint, version
from pathlib import Path

import pytest
from click.testing import CliRunner
from command_line import CRANE, crane, crane_here
from process_helpers import run_to_completion, started_program

from crane_sim.cli import help_lines
from crane_sim.cli.commands import app
from crane_sim.files.catalogue import scene_files
from crane_sim.files.errors import SceneError
from crane_sim.simulation.rollout import simulate


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["run", "nowhere"], "crane: unknown scene 'nowhere'"),
        (["simulate", "--set", "payload.mas=2"], "did you mean 'mass'?"),
        (["simulate", "--set", "payload.mass"], "--set 'payload.mass': must be GROUP.KEY=VALUE"),
        (["simulate", "--set", "payload.mass=-1"], "payload.mass = -1: must be greater than 0"),
        (["simulate", "--set", "payload.mass=.nan"], "payload.mass = nan: must be a finite number"),
        (["simulate", "--duration", "-1"], "duration = -1.0: must be greater than 0"),
        (["simulate", "--duration", "soon"], "'soon' is not a valid float"),
        (["simulate", "--law", "magic"], "control.law = 'magic': no such law (known: adaptive"),
        (["run", "--mode", "warp"], "'--mode': 'warp' is not one of 'lockstep', 'realtime'"),
        (["run", "--rate", "0"], "'--rate': 0.0 is not in the range x>0.0"),
        (["run", "--rate", "nan"], "'--rate': 'nan': must be a finite number"),
        (["run", "--domain-id", "999"], "'--domain-id': 999 is not in the range 0<=x<=232"),
        (
            ["run", "--frame-prefix", "a b/"],
            "'--frame-prefix': 'a b/': possible: letters, digits, _ and /",
        ),
        (
            ["run", "--namespace", "a,b"],
            "'--namespace': 'a,b': possible: letters, digits, _ and /, such as west",
        ),
        (["run", "--beside", "east,"], "'--beside': 'east,': possible: letters"),
        (
            ["run", "--record", "/proc/none/run.rrd"],
            "--record /proc/none/run.rrd: cannot be written",
        ),
        (
            ["simulate", "--law", "lqr", "--set", "control.kp=1"],
            "unknown key 'kp' for law 'lqr' (known: q, r)",
        ),
        (["check", "nowhere/mine.yaml"], "scene file nowhere/mine.yaml: there is no such file"),
        (["reproduce", "nonsense"], "unknown item 'nonsense' (known: overhead"),
        (["reproduce", "--save", "/proc/none"], "--save '/proc/none': cannot be written"),
        (["league", "--save", "/proc/none"], "--save '/proc/none': cannot be written"),
        (
            ["league", "--samples", "two"],
            "'--samples': 'two': must be a whole number of at least 2",
        ),
        (["league", "--samples", "1"], "'--samples': '1': must be a whole number of at least 2"),
        (["league", "-o", "rows"], "-o 'rows': is for --samples N only; add it, or leave out -o"),
        (["league", "--crane", "pendulum"], "--crane 'pendulum': is for --samples N only"),
        (
            ["league", "--samples", "2", "--crane", "pendulums"],
            "unknown crane 'pendulums', did you mean 'pendulum'?",
        ),
        (
            ["sweep", "study.yaml", "--workers", "0"],
            "'--workers': '0': must be a whole number of at least 1",
        ),
        (["run", "--fast"], "No such option"),
        (
            ["run", "--on-silence", "warp"],
            "'--on-silence': 'warp' is not one of 'zero', 'hold', 'brake'",
        ),
        (["bench", "inprocess"], "crane soak inprocess is a soak"),
        (["describe", "--ros2-control"], "crane describe --ros2-control: needs SCENE"),
        (["fly"], "No such command 'fly' (known: bench, check"),
        (["soak", "inprocess", "--steps", "nan"], "'nan': must be a finite number"),
        (
            ["soak", "memry"],
            "No such command 'memry', did you mean 'memory'? (known: determinism, inprocess",
        ),
        (["bench", "flight"], "unknown SUITE 'flight' (known: scenes, lockstep"),
        (["check", "/"], "cannot be read"),
        (
            ["check", "overhead_energy", "--set", "trolley.mass=-1"],
            "trolley.mass = -1: must be greater than or equal to 0",
        ),
    ],
    ids=lambda case: " ".join(case) if isinstance(case, list) else "",
)
def test_bad_input_is_one_line_and_exit_2(
    arguments: list[str],
    line: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Bad input ends with exit code 2 and one line on stderr that names it, without a traceback."""
    result = crane_here(monkeypatch, capsys, *arguments)
    assert result.returncode == 2
    assert line in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("command", ["bench", "soak", "run"])
def test_every_command_has_help(command: str) -> None:
    """Both -h and --help print the usage of a command."""
    short, long = (
        CliRunner().invoke(app, [command, option], prog_name="crane") for option in ("-h", "--help")
    )
    assert short.exit_code == long.exit_code == 0
    assert short.stdout == long.stdout and short.stdout.startswith(f"Usage: crane {command} ")


def test_help_of_run_has_possible_values_and_time_limits() -> None:
    """`crane run -h` has the values of --mode and --on-silence, and both time limits of --wait."""
    text = " ".join(CliRunner().invoke(app, ["run", "-h"], prog_name="crane").stdout.split())
    assert "lockstep | realtime" in text and "zero | hold | brake" in text
    assert "(default 120; 0: no limit)" in text and "at least 120 s to connect" in text


@pytest.mark.parametrize(
    ("group", "first"), [([], "Run a crane:"), (["soak"], "Commands:")], ids=str
)
def test_help_is_not_cut(group: list[str], first: str) -> None:
    """The help has a whole sentence on each command."""
    commands = crane(*group, "--help").stdout.partition(first)[2]
    assert commands and "..." not in commands


def test_help_has_groups_and_a_warning_of_what_cannot_be_imported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A package whose command cannot be imported costs a line of help, its command exit code 2."""
    broken = EntryPoint("broken", "no.such.module:command", help_lines.COMMANDS)
    found = (*help_lines.find_extensions(help_lines.COMMANDS), broken)
    monkeypatch.setattr(help_lines, "find_extensions", lambda _: found)
    result = CliRunner().invoke(app, ["--help"], prog_name="crane")
    line = (
        "command broken: no.such.module:command cannot be imported: ModuleNotFoundError: No module "
        "named 'no'"
    )
    assert result.exit_code == 0 and result.stderr == f"crane: warning: {line}\n"
    assert [text[:-1] for text in result.stdout.splitlines() if re.fullmatch(r"\w.*:", text)] == [
        "Options",
        *help_lines.SECTIONS,
        "Laboratory",
    ]
    with pytest.raises(SceneError, match=line):
        app(["broken"], standalone_mode=False)


def test_a_scene_is_described(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`crane describe SCENE` has the law and a row per joint, with unit, travel and command."""
    said = crane_here(monkeypatch, capsys, "describe", "bridge_speed_drive").stdout
    assert "crane bridge, 30 s in 3000 steps of 0.01 s, law anti_swing" in said
    assert re.search(r"trolley +m +-4 +-9 .. 9 +velocity \[m/s\]", said) and "swing_radial" in said


def test_the_version_is_printed() -> None:
    """`crane --version` prints the version of the installed package."""
    assert crane("--version").stdout == f"crane_sim {version('crane_sim')}\n"


def test_an_unknown_scene_is_rejected_without_listing_the_catalogue(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The error about an unknown scene fits a terminal, and names the command that lists them."""
    for name in ("nowhere", "nowhere/mine.yaml"):
        line = crane_here(monkeypatch, capsys, "run", name).stderr
        assert len(line) < 120 and "crane scenes" in line


@pytest.mark.long
def test_no_compilation_status_without_compilation() -> None:
    """Once a scene's equations are on disk, the terminal shows no status line of compilation."""
    command = ["simulate", "--duration", "0.1"]
    crane(*command)
    master, slave = pty.openpty()
    with open(master, "rb", buffering=0) as terminal:
        result = subprocess.run(
            [str(CRANE), *command], stdout=subprocess.PIPE, stderr=slave, check=True
        )
        os.write(slave, b"end")  # so that the read returns
        os.close(slave)
        assert b"compiling" not in terminal.read(65536) and result.stdout


BAR = """
import time
from crane_sim import cli, process_signals
from crane_sim.cli.sweep import show_progress
process_signals.exit_on_signal(cli._on_interrupt)
with show_progress("runs", quiet=False) as on_progress:
    on_progress(1, 2)
    time.sleep(60.0)
"""


def test_an_interrupted_progress_bar_ends_in_one_line() -> None:
    """Ctrl-C clears a progress bar's line, which is not drawn again below `crane: interrupted`."""
    master, slave = pty.openpty()
    with (
        open(master, "rb", buffering=0) as terminal,
        started_program([sys.executable, "-c", BAR], stderr=slave) as bar,
    ):
        shown = b""
        while b"1/2" not in shown:
            shown += terminal.read(4096)
        bar.send_signal(signal.SIGINT)
        assert bar.wait() == 1
        os.write(slave, b"end")  # so that the read returns
        os.close(slave)
        while not shown.endswith(b"end"):
            shown += terminal.read(4096)
    assert shown.endswith(b"\r\x1b[K\x1b[?25hcrane: interrupted\r\nend")


def test_a_full_disk_behind_stdout_is_one_line() -> None:
    """If even the error cannot be printed as JSON, stderr has it in one line, without traceback."""
    with Path("/dev/full").open("w") as full:
        command = [str(CRANE), "simulate", "nowhere", "--json"]
        result = run_to_completion(command, stdout=full)
    assert result.returncode == 2
    assert (
        len(result.stderr.strip().splitlines()) == 1 and "unknown scene 'nowhere'" in result.stderr
    )


def test_json_carries_the_error_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With --json, a failure is an object with the key `error` on stdout as well."""
    result = crane_here(monkeypatch, capsys, "simulate", "nowhere", "--json")
    assert result.returncode == 2
    assert json.loads(result.stdout)["error"] in result.stderr


def test_simulate_prints_one_object_with_the_summary() -> None:
    """`crane simulate --json` prints the metrics of the run in Python, nothing else on stdout."""
    result = crane("simulate", "--duration", "1", "--json")
    printed = json.loads(result.stdout)
    expected = simulate("knuckle_setpoint", duration=1.0).summary
    assert result.returncode == 0
    assert {key: printed[key] for key in expected} == expected and printed["compile_time"] >= 0.0


@pytest.mark.slow
def test_a_run_that_ends_early_has_a_partial_summary() -> None:
    """A model that becomes invalid ends with exit code 1, its cause in one line, and the summary.

    The summary is that up to there.
    """
    result = crane("simulate", "overhead_slack", "--json")
    summary = json.loads(result.stdout)
    assert (
        result.returncode == 1
        and "link 1 went slack" in result.stderr
        and summary["error"] in result.stderr
    )
    assert summary["events"][-1]["what"].startswith("link 1 went slack") and summary["steps"] > 10


def test_scenes_lists_the_catalogue(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`crane scenes` has a line for each catalogue scene: its name and first sentence."""
    lines = crane_here(monkeypatch, capsys, "scenes").stdout.strip().splitlines()
    assert [line.split()[0] for line in lines] == list(scene_files())
    assert all(line.count(". ") == 0 for line in lines)


def test_check_accepts_and_describes_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`crane check FILE` validates a file of one's own."""
    file = tmp_path / "mine.yaml"
    file.write_text(scene_files()["knuckle_setpoint"].read_text())
    result = crane_here(monkeypatch, capsys, "check", str(file))
    assert result.returncode == 0
    assert "fine (knuckle, 40 s, 4000 steps of 0.01 s, law energy)" in result.stdout


def test_tables_are_plain_when_piped() -> None:
    """Output to a pipe has no escape sequences and no progress bar."""
    result = crane("simulate", "--duration", "0.5")
    assert "state sha256" in result.stdout
    assert "\x1b" not in result.stdout + result.stderr
