"""The commands that show a recording: which one, which program, and which refused options."""

import os
import re
import sys
from pathlib import Path

import pytest

from crane_sim.cli.commands import app
from crane_sim.cli.viewing import find_recording
from crane_sim.files.errors import SceneError
from crane_sim.recording.rerun import web_page


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a working folder with two recordings in runs/, the newer one b, and no display."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    # they count as whole
    monkeypatch.setattr("crane_sim.recording.rerun.rrd_file.whole_size", lambda _: None)
    for name, age in (("b", 10.0), ("a", 20.0)):
        file = tmp_path / "runs" / f"{name}.rrd"
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(b"RRF2")
        os.utime(file, (1e9 - age, 1e9 - age))
    return tmp_path


@pytest.fixture
def executed(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Return the command lines that a double of `os.exec…` is called with; it runs none."""
    commands = list[list[str]]()
    monkeypatch.setattr(
        os, "execve", lambda _program, command, _environment: commands.append(command)
    )
    return commands


def run(*arguments: str) -> None:
    """Run the command line."""
    app(list(arguments), standalone_mode=False)


def test_the_newest_recording_is_taken(folder: Path) -> None:
    """Without a name the newest recording is shown, else the named one; without any, an error.

    The error says how to make one.
    """
    assert find_recording(None) == Path("runs/b.rrd")
    assert find_recording(Path("runs/a.rrd")) == Path("runs/a.rrd")
    with pytest.raises(
        SceneError, match="^RUN = 'c.rrd': no such file; leave it out for the newest in runs/$"
    ):
        find_recording(Path("c.rrd"))
    for file in (folder / "runs").iterdir():
        file.unlink()
    with pytest.raises(SceneError, match="^RUN: runs/ has no recording yet; crane run makes one$"):
        find_recording(None)


@pytest.mark.parametrize("command", ["view", "shot", "clip"])
def test_a_file_that_is_no_recording_is_refused(folder: Path, command: str) -> None:
    """What does not begin as a recording does is refused at once: the viewer would wait for one."""
    (folder / "page.rrd").write_text("# a page\n")
    with pytest.raises(
        SceneError, match="^page.rrd: is no recording: its first bytes are not those of one$"
    ):
        run(command, "page.rrd")


@pytest.mark.usefixtures("folder")
def test_a_window_opens_where_there_is_a_display(
    executed: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The viewer gets the recording and the loopback interface; no display is an error.

    The error says what to do.
    """
    with pytest.raises(SceneError, match="there is no display here; --web serves"):
        run("view")
    monkeypatch.setenv("DISPLAY", ":0")
    run("view")
    run("view", "--live", "--port", "9999")
    assert [command[-1] for command in executed] == [
        "runs/b.rrd",
        "rerun+http://127.0.0.1:9999/proxy",
    ]
    assert all(command[command.index("--bind") + 1] == "127.0.0.1" for command in executed)


def test_a_page_is_served_until_the_viewer_ends(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The viewer has both ports of 127.0.0.1; the command has its exit code.

    The address is that of its data.
    """
    program, given = folder / "viewer", folder / "given"
    listen = "socket.create_server(('127.0.0.1', int(argv[argv.index('--web-viewer-port') + 1])))"
    program.write_text(
        f"#!{sys.executable}\nimport socket; from sys import argv\nopen('{given}', 'w').write(' "
        "'.join(argv))\n"
        f"server = {listen}\nserver.accept()\nraise SystemExit(7)\n"
    )
    program.chmod(0o755)
    monkeypatch.setattr(web_page, "rerun_executable", lambda: program)
    with pytest.raises(SystemExit, match="^7$"):
        run("view", "runs/a.rrd", "--web")
    command = given.read_text().split()
    data = command[command.index("--port") + 1]
    address = rf"http://127\.0\.0\.1:\d+/\?url=rerun%2Bhttp%3A%2F%2F127\.0\.0\.1%3A{data}%2Fproxy&hide_welcome_screen"
    assert re.fullmatch(address, capsys.readouterr().out.splitlines()[1])
    assert command[command.index("--bind") + 1] == "127.0.0.1" and command[-1] == "runs/a.rrd"


@pytest.mark.usefixtures("folder")
def test_options_that_contradict_are_refused() -> None:
    """A file with --live, a port without it, another kind of file, no folder: one-line errors."""
    for arguments, line in (
        (("view", "runs/a.rrd", "--live"), "RUN and --live: only one of the two is possible"),
        (("view", "--port", "9999"), "--port = 9999: only with --live"),
        (("shot", "-o", "a.jpg"), "--output a.jpg: must end in .png"),
        (("clip", "-o", "a.avi"), "--output a.avi: must end in .gif or .mp4"),
        (("plot", "-o", "a.txt"), "--output a.txt: must end in .png or .pdf or .svg"),
        (("report", "-o", "runs/b.rrd/a.html"), "--output runs/b.rrd/a.html: cannot be written: "),
    ):
        with pytest.raises(SceneError, match=line):
            run(*arguments)
