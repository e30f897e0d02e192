"""A picture of a recording on a busy machine, where the viewer starts late and loses connections; without a viewer."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim.recording.rerun import screenshot as picture_module
from crane_sim.recording.rerun.screenshot import NO_DRAWING, PictureError, picture

STATE = SimpleNamespace(
    active_recording="run",
    loading=[],
    recordings=[SimpleNamespace(timelines=[SimpleNamespace(name="sim_time", end=4_000_000_000)])],
    views=[],
)


class LossyClient:
    """A client whose every call fails the first time, and whose connection is then lost."""

    requests: list[str] = []

    def __init__(self) -> None:
        """Be connected."""
        self._lost = False

    @classmethod
    def connect(cls, _url: str) -> "LossyClient":
        """Return a new connection."""
        return cls()

    def __getattr__(self, name: str) -> Any:
        """Return a method that fails at its first call, and answers later ones."""

        def answer(*_: object, **__: object) -> SimpleNamespace:
            assert not self._lost, "a lost connection was used again"
            self.requests.append(name)
            if self.requests.count(name) < 2:
                self._lost = True
                raise ConnectionError(f"{name}: connection lost")
            return STATE

        return answer


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield a file, with a viewer program that only sleeps."""
    program = tmp_path / "viewer"
    program.write_text("#!/bin/sh\nexec sleep 60\n")
    program.chmod(0o755)
    monkeypatch.setattr(picture_module, "viewer_program", lambda: program)
    monkeypatch.setattr(picture_module, "ViewerClient", LossyClient)
    monkeypatch.setattr(picture_module, "DRAW_SECONDS", 0.0)
    monkeypatch.setattr(LossyClient, "requests", [])
    file = tmp_path / "run.rrd"
    file.touch()
    yield file


def test_a_lost_connection_is_renewed(recording: Path, tmp_path: Path) -> None:
    """Each request whose connection is lost is repeated through a new one, and the picture is drawn."""
    assert picture(recording, tmp_path / "run.png") == []
    assert LossyClient.requests.count("save_screenshot") == LossyClient.requests.count("open") == 2


def test_a_viewer_that_never_answers_is_given_up(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that lives and does not answer is an error of its own; one that has ended cannot draw here."""

    def silent(*_: object) -> None:
        raise RuntimeError("no answer")

    monkeypatch.setattr(LossyClient, "open", silent, raising=False)
    monkeypatch.setattr(picture_module, "LOAD_SECONDS", 0.3)
    with pytest.raises(PictureError, match="^the viewer failed: no answer$"):
        picture(recording, recording.with_suffix(".png"))
    monkeypatch.setattr(picture_module, "viewer_program", lambda: Path("/bin/true"))
    monkeypatch.setattr(picture_module, "LOAD_SECONDS", 60.0)
    with pytest.raises(PictureError) as caught:
        picture(recording, recording.with_suffix(".png"))
    assert str(caught.value) == NO_DRAWING
