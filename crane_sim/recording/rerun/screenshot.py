"""Pictures and clips of a recording as its viewer shows it, without a window.

They need a Vulkan driver; a software one is enough.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rerun.experimental import ViewerState

from crane_sim.files.errors import SceneError, did_you_mean
from crane_sim.files.output import write_output
from crane_sim.recording.rerun import viewer
from crane_sim.recording.rerun.viewer import (
    HeadlessViewer,
    PictureError,
    check_viewable,
    headless_viewer,
)


class Shown(NamedTuple):
    """What of a recording is drawn."""

    tab: str = ""  # Overview, Details or Summary; empty: the one that the recording begins with
    view: str = ""  # title of the only view to draw, such as Crane; empty: the whole window


class ViewCamera:
    """A viewer without a window that has loaded a recording.

    Attributes:
        end: scene time of the end of the run [s].
    """

    def __init__(self, headless: HeadlessViewer, recording: Path, shown: Shown) -> None:
        """Load a recording.

        Raises:
            SceneError: it has no such tab or view.
            PictureError: the viewer cannot load it.
        """
        self._viewer = headless
        state = headless.load(recording)
        self.end = _end_of_run(state, recording)
        self._view_id = _view_id(state, shown.view) if shown.view else None
        if shown.tab:
            self._select_tab(shown.tab)
        self.drawn_at(self.end)

    def drawn_at(self, instant: float) -> bytes:
        """Return the complete picture at a scene time [s], as PNG.

        It is the first that is like the one before.

        A viewer lays out a tab and loads what its views need in the frames in which it draws it for
        the first time.

        Raises:
            PictureError: pictures still differ after `LOAD_SECONDS`.
        """
        deadline, picture = time.monotonic() + viewer.LOAD_SECONDS, self.at(instant)
        while time.monotonic() < deadline:
            before, picture = picture, self.at(instant)
            if picture == before:
                return picture
        raise PictureError(f"the viewer did not finish a picture within {viewer.LOAD_SECONDS:g} s")

    def at(self, instant: float) -> bytes:
        """Return the picture at a scene time [s], as PNG, complete if its tab was drawn before."""
        self._viewer.request(
            lambda client: client.set_time("sim_time", duration=instant, play_state="paused")
        )
        return self._viewer.request(lambda client: client.take_screenshot(self._view_id))

    def reports(self) -> list[str]:
        """Return what the views complain about, one line each; empty for a healthy recording."""
        state = self._viewer.request(lambda client: client.get_state())
        return [f"{view.name}: {report.summary}" for view in state.views for report in view.reports]

    def _select_tab(self, name: str) -> None:
        blueprint = self._viewer.request(lambda client: client.get_blueprint()).blueprint
        tabs = next(part for part in _containers(blueprint) if part["container_kind"] == "Tabs")
        titles = {_title(blueprint, entity): entity for entity in tabs["contents"]}
        tabs["active_tab"] = _by_title(titles, name, "tab")
        self._viewer.request(lambda client: client.set_blueprint(blueprint, of="recording"))


@contextlib.contextmanager
def camera(recording: Path, shown: Shown | None = None) -> Iterator[ViewCamera]:
    """Run a viewer that has loaded a recording for the length of the block.

    Raises:
        SceneError: there is no such recording, tab or view.
        PictureError: no viewer, no Vulkan driver to draw with.
    """
    check_viewable(recording)
    with headless_viewer() as headless:
        yield ViewCamera(headless, recording, shown or Shown())


def picture(
    recording: Path, output: Path, at: float | None = None, shown: Shown | None = None
) -> list[str]:
    """Save what the viewer shows at a scene time.

    Args:
        recording: a complete `.rrd` file.
        output: the PNG to write, 1920 x 1080, or smaller for a single view.
        at: scene time [s]; default: the end of the run.
        shown: what is drawn; default: the whole window.

    Returns:
        What the views complain about, one line each; empty for a healthy recording.

    Raises:
        SceneError: there is no such recording, tab or view, or the run was over by then.
        PictureError: no viewer, no Vulkan driver to draw with.
    """
    with camera(recording, shown) as shown_by:
        instant = shown_by.end if at is None else at
        if not 0.0 <= instant <= shown_by.end:
            raise SceneError(f"time {instant:g}: {recording} has 0 .. {shown_by.end:g} s")
        drawn = shown_by.drawn_at(instant)
        write_output("--output", output, lambda path: path.write_bytes(drawn))
        return shown_by.reports()


def _end_of_run(state: ViewerState, recording: Path) -> float:
    ends = [
        line.end for each in state.recordings for line in each.timelines if line.name == "sim_time"
    ]
    if not ends or ends[0] is None:
        raise PictureError(f"{recording}: has no timeline sim_time")
    return ends[0] * 1e-9


def _view_id(state: ViewerState, name: str) -> str:
    return _by_title({view.name: str(view.view_id) for view in state.views}, name, "view")


def _containers(blueprint: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [
        part["ContainerBlueprint"] for part in blueprint.values() if "ContainerBlueprint" in part
    ]


def _title(blueprint: Mapping[str, Any], entity: str) -> str:
    """Return the title of a container or view of the blueprint."""
    part = blueprint[f"/{entity}"]
    return str((part.get("ContainerBlueprint") or part["ViewBlueprint"]).get("display_name", ""))


def _by_title(titles: Mapping[str, str], name: str, kind: str) -> str:
    """Return the value of a title, written in any case.

    Raises:
        SceneError: there is none; the line names those there are.
    """
    for title, value in titles.items():
        if title.casefold() == name.casefold():
            return value
    raise SceneError(
        f"{kind} {name!r}: no such {kind}{did_you_mean(name, titles)}; possible: "
        f"{', '.join(titles)}"
    )
