"""A picture of a recording on a busy machine, tested without a viewer.

There the viewer starts late and loses connections.
"""

import io
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.error import HTTPError, URLError
from urllib.request import urlopen

import pytest
from PIL import Image, ImageSequence
from process_helpers import wait_until

from crane_sim.files.errors import SceneError
from crane_sim.recording.rerun import viewer as viewer_module
from crane_sim.recording.rerun.clip import Cut, write_clip
from crane_sim.recording.rerun.screenshot import Shown, picture
from crane_sim.recording.rerun.viewer import NO_DRAWING, PictureError, _served, headless_viewer

pytestmark = pytest.mark.unforked  # a client of the viewer

STATE = SimpleNamespace(
    active_recording="run",
    store_ids=["run"],
    loading=[],
    recordings=[SimpleNamespace(timelines=[SimpleNamespace(name="sim_time", end=4_000_000_000)])],
    views=[SimpleNamespace(name="Crane", view_id="3d", reports=[])],
)
TABS = {
    "container_kind": "Tabs",
    "contents": ["container/a", "view/b"],
    "active_tab": "container/a",
}
BLUEPRINT = SimpleNamespace(
    blueprint={
        "/container/tabs": {"ContainerBlueprint": TABS},
        "/container/a": {
            "ContainerBlueprint": {"container_kind": "Grid", "display_name": "Overview"}
        },
        "/view/b": {"ViewBlueprint": {"display_name": "Summary"}},
    }
)


def png(color: int) -> bytes:
    """Return a picture of one colour."""
    file = io.BytesIO()
    Image.new("RGB", (64, 48), (color, 0, 0)).save(file, "PNG")
    return file.getvalue()


class LossyClient:
    """A client whose every call fails the first time, and whose connection is then lost."""

    requests: list[str] = []
    instants: list[float] = []  # at which the time was set
    pictures: list[bytes] = []  # that come before one which only depends on the time

    def __init__(self) -> None:
        """Be connected."""
        self._lost = False

    @classmethod
    def connect(cls, _url: str) -> "LossyClient":
        """Return a new connection."""
        return cls()

    def __getattr__(self, name: str) -> Any:
        """Return a method that fails at its first call, and answers later ones."""

        def answer(*_: object, **settings: Any) -> Any:
            assert not self._lost, "a lost connection was used again"
            self.requests.append(name)
            if self.requests.count(name) < 2:
                self._lost = True
                raise ConnectionError(f"{name}: connection lost")
            if name == "take_screenshot":
                return (
                    self.pictures.pop(0)
                    if self.pictures
                    else png(self.instants.index(self.instants[-1]))
                )
            if name == "set_time":
                self.instants.append(settings["duration"])
            return BLUEPRINT if name == "get_blueprint" else STATE

        return answer


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield a file, with a viewer program that only sleeps."""
    program = tmp_path / "viewer"
    program.write_text("#!/bin/sh\nexec sleep 60\n")
    program.chmod(0o755)
    monkeypatch.setattr(viewer_module, "rerun_executable", lambda: program)
    monkeypatch.setattr(viewer_module, "ViewerClient", LossyClient)
    for name in ("requests", "instants", "pictures"):
        monkeypatch.setattr(LossyClient, name, [])
    file = tmp_path / "run.rrd"
    file.write_bytes(b"RRF2")
    yield file


def test_a_lost_connection_is_renewed(recording: Path, tmp_path: Path) -> None:
    """A request that loses its connection is repeated on a new one, and the picture drawn."""
    assert picture(recording, tmp_path / "run.png") == []
    assert (
        LossyClient.requests.count("open") == 2
        and LossyClient.requests.count("take_screenshot") > 2
    )
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_is_complete(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The picture is the first like the one before; an error if they still differ at the end."""
    monkeypatch.setattr(LossyClient, "pictures", [png(k) for k in (50, 50, 51, 52, 53)])
    picture(recording, tmp_path / "run.png", 1.0)
    assert Image.open(tmp_path / "run.png").getpixel((0, 0)) == (
        LossyClient.instants.index(1.0),
        0,
        0,
    )
    monkeypatch.setattr(LossyClient, "pictures", [png(k % 2) for k in range(100_000)])
    monkeypatch.setattr(viewer_module, "LOAD_SECONDS", 0.3)
    with pytest.raises(PictureError, match=r"^the viewer did not finish a picture within 0\.3 s$"):
        picture(recording, tmp_path / "no.png")
    assert not (tmp_path / "no.png").exists()


def test_a_file_that_is_no_recording_is_refused_at_once(
    recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the viewer opens and loads nothing, the line says that it cannot read the file."""
    monkeypatch.setattr(
        LossyClient, "open", lambda *_: SimpleNamespace(store_ids=[], loading=[]), raising=False
    )
    with pytest.raises(PictureError, match=r"run\.rrd: the viewer cannot read it$"):
        picture(recording, recording.with_suffix(".png"))


def test_a_recording_is_served_whole(tmp_path: Path) -> None:
    """The viewer gets all bytes of a recording, and nothing else, at its own local address."""
    file = tmp_path / "a run.rrd"
    file.write_bytes(bytes(range(256)) * 1000)
    with _served(file) as address, _served(file) as other:
        with urlopen(address) as answer:
            assert answer.read() == file.read_bytes()
        assert (
            address.startswith("http://127.0.0.1:") and address.split("/")[3] != other.split("/")[3]
        )
        with pytest.raises(HTTPError):
            urlopen(f"{address}x")
    with pytest.raises(URLError):
        urlopen(address)


def test_a_viewer_that_never_answers_is_given_up(
    recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A silent viewer is an error of its own; an ended one says why, or that it cannot draw."""

    def silent(*_: object) -> None:
        raise RuntimeError("no answer")

    monkeypatch.setattr(LossyClient, "open", silent, raising=False)
    monkeypatch.setattr(viewer_module, "LOAD_SECONDS", 0.3)
    with pytest.raises(PictureError, match="^the viewer failed: no answer$"):
        picture(recording, recording.with_suffix(".png"))
    monkeypatch.setattr(viewer_module, "rerun_executable", lambda: Path("/bin/true"))
    monkeypatch.setattr(viewer_module, "LOAD_SECONDS", 60.0)
    with pytest.raises(PictureError) as caught:
        picture(recording, recording.with_suffix(".png"))
    assert str(caught.value) == NO_DRAWING
    ends = {
        r"\033[31mERROR\033[0m port taken\n\n": "the viewer ended: ERROR port taken",
        r"panicked at b\nc": NO_DRAWING,
    }
    for said, line in ends.items():
        program = recording.with_name("ended")
        program.write_text(f"#!/bin/sh\nprintf '{said}' >&2\n")
        program.chmod(0o755)
        monkeypatch.setattr(viewer_module, "rerun_executable", lambda program=program: program)
        with pytest.raises(PictureError) as caught:
            picture(recording, recording.with_suffix(".png"))
        assert str(caught.value) == line


def test_a_viewer_reaches_no_other_machine(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the proxy, a viewer's requests to other machines end at an unserved local port.

    What it leaves in the folder for temporary files is gone with it.
    """
    monkeypatch.setenv("https_proxy", "http://proxy.example.org:3128")
    monkeypatch.setenv("NO_PROXY", "example.org")
    program, made = tmp_path / "viewer", tmp_path / "made"
    program.write_text(f"#!/bin/sh\nenv > {made}.new && mv {made}.new {made}\nexec sleep 60\n")
    with headless_viewer():
        wait_until(made.exists, "the viewer's environment")
        given = dict(line.split("=", 1) for line in made.read_text().splitlines() if "=" in line)
        assert Path(given["TMPDIR"]).is_dir()
    assert not Path(given["TMPDIR"]).exists()
    # before those of a single scheme
    assert given["ALL_PROXY"] == given["all_proxy"] == "http://127.0.0.1:9"
    assert given["NO_PROXY"] == given["no_proxy"] == "127.0.0.1"


def test_a_tab_is_selected_by_its_title(recording: Path, tmp_path: Path) -> None:
    """A tab's title, in any case, activates it; an unknown tab, view or time gives one line."""
    picture(recording, tmp_path / "run.png", shown=Shown(tab="summary", view="crane"))
    assert TABS["active_tab"] == "view/b" and "set_blueprint" in LossyClient.requests
    with pytest.raises(SceneError, match="^tab 'sum': no such tab.*; possible: Overview, Summary$"):
        picture(recording, tmp_path / "no.png", shown=Shown(tab="sum"))
    with pytest.raises(SceneError, match="^view 'plot': no such view; possible: Crane$"):
        picture(recording, tmp_path / "no.png", shown=Shown(view="plot"))
    with pytest.raises(SceneError, match=r"^time 5: .*run\.rrd has 0 \.\. 4 s$"):
        picture(recording, tmp_path / "no.png", at=5.0)
    assert not (tmp_path / "no.png").exists()


def test_a_clip_has_the_pictures_of_its_part(recording: Path, tmp_path: Path) -> None:
    """Two seconds at double speed and eight pictures a second are eight pictures in a GIF.

    It has the width that was asked for.
    """
    file, progress = tmp_path / "run.gif", list[tuple[int, int]]()
    count = write_clip(
        recording, file, Cut(1.0, 3.0, 8.0, 2.0, 32), Shown(), lambda *at: progress.append(at)
    )
    with Image.open(file) as clip:
        assert (clip.size, getattr(clip, "n_frames", 1)) == ((32, 24), 8)
    assert count == 8 and progress == [(k, 8) for k in range(1, 9)]


@pytest.mark.parametrize(("rate", "duration"), [(30.0, 2000), (7.0, 8570)])
def test_a_gif_lasts_as_long_as_its_part(
    recording: Path, tmp_path: Path, rate: float, duration: int
) -> None:
    """A GIF, counting in hundredths of a second, lasts as long in total as it should."""
    file = tmp_path / "run.gif"
    write_clip(recording, file, Cut(0.0, 4.0, rate, 4.0 * rate / 60.0, 32), Shown())
    with Image.open(file) as clip:
        durations = [frame.info["duration"] for frame in ImageSequence.Iterator(clip)]
    assert sum(durations) == duration and len(durations) <= 60  # equal pictures in a row are one


def test_an_mp4_has_even_sizes(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For an odd width ffmpeg gets the even one below; its failure's line names the asked file."""
    ffmpeg, given = tmp_path / "ffmpeg", tmp_path / "given"
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    for end in ("exit 0", "exit 1", "echo first >&2; echo $file: last >&2; exit 1"):
        written = 'for file; do :; done\n: > "$file"'  # the last argument
        ffmpeg.write_text(f'#!/bin/sh\necho "$@" > {given}\ncat > {given}.data\n{written}\n{end}\n')
        ffmpeg.chmod(0o755)
        if end == "exit 0":
            write_clip(recording, tmp_path / "run.mp4", Cut(0.0, 1.0, 2.0, 1.0, 33), Shown())
            continue
        file = tmp_path / "run.mp4"
        said = f"{file}: last" if "last" in end else "no message"
        with pytest.raises(PictureError, match=f"^{file}: ffmpeg failed: {said}$"):
            write_clip(recording, file, Cut(0.0, 1.0, 2.0, 1.0, 33), Shown())
    assert " -s 32x24 " in given.read_text()
    assert Path(f"{given}.data").stat().st_size == 2 * 32 * 24 * 3


def test_an_impossible_clip_is_one_line(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other file types, an MP4 without ffmpeg and a part beyond the run are refused."""
    monkeypatch.setattr(shutil, "which", lambda _program: None)
    with pytest.raises(SceneError, match="must end in .gif or .mp4"):
        write_clip(recording, tmp_path / "run.avi", Cut(), Shown())
    with pytest.raises(SceneError, match="a GIF shows 50 pictures a second at most, not 60"):
        write_clip(recording, tmp_path / "run.gif", Cut(frames_per_second=60.0), Shown())
    with pytest.raises(PictureError, match="needs the program ffmpeg"):
        write_clip(recording, tmp_path / "run.mp4", Cut(), Shown())
    with pytest.raises(SceneError, match="^from 4 to 4 s: no part of a run of 4 s$"):
        write_clip(recording, tmp_path / "run.gif", Cut(begin=4.0), Shown())
