"""The options of `crane run`: checks of values and of combinations before anything starts."""

import math
import re
import socket
import tempfile
from collections.abc import Callable, Iterable, Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from crane_sim.cli.help_lines import FiniteRange
from crane_sim.files.errors import SceneError
from crane_sim.files.installation import require
from crane_sim.recording.files import lock_file, unfinished_name
from crane_sim.ros.common.choices import (
    COMMAND_STAMPS,
    COMMAND_TIMEOUT_ACTIONS,
    TRANSFORM_SCOPES,
    CommandStamps,
    CommandTimeoutAction,
)

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

_WORD = r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*"  # a name of ROS, without the leading slash
_WAIT = 120.0  # s
VIEWER_PORT = 9876  # the default port of a Rerun viewer


class _Name(click.ParamType):
    """Type of an option: a name that a pattern allows; errors for other values have an example."""

    name = "text"

    def __init__(self, pattern: str, example: str) -> None:
        self._pattern, self._example = re.compile(pattern, re.ASCII), example

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the option's text."""
        if not self._pattern.fullmatch(value):
            possible = f"possible: letters, digits, _ and /, such as {self._example}"
            self.fail(f"{value!r}: {possible}", param, ctx)
        return value


def _choice(values: Iterable[str]) -> click.Choice:
    return click.Choice(list(values))


_PATH = click.Path(path_type=Path)
_OPTIONS = {
    "mode": click.option(
        "--mode",
        type=_choice(("lockstep", "realtime")),
        default="lockstep",
        help="lockstep | realtime (default lockstep).",
    ),
    "rate": click.option(
        "--rate",
        type=FiniteRange(0.0, min_open=True),
        help="realtime: simulated seconds per second.",
    ),
    "record": click.option(
        "--record", type=_PATH, help="File of the recording (default: runs/SCENE-TIME.rrd)."
    ),
    "no_record": click.option("--no-record", is_flag=True, help="Write no recording."),
    "mcap": click.option("--mcap", type=_PATH, help="Also write the ROS messages to FILE.mcap."),
    "live": click.option(
        "--live",
        is_flag=True,
        help="Stream to Rerun viewers on this machine; best with --mode realtime.",
    ),
    "domain_id": click.option(
        "--domain-id", type=click.IntRange(0, 232), help="ROS domain id; a free one when left out."
    ),
    "no_controller": click.option(
        "--no-controller", is_flag=True, help="Your own node commands the crane."
    ),
    "wait": click.option(
        "--wait",
        type=FiniteRange(0.0),
        help="With --no-controller, in lockstep: seconds that the plant waits for a command of "
        "your node until the run "
        "ends (default 120; 0: no limit). The node has at least 120 s to connect, also in real "
        "time.",
    ),
    "restart": click.option(
        "--restart", is_flag=True, help="Replace a controller, tracker or recorder that dies."
    ),
    "on_silence": click.option(
        "--on-silence",
        type=_choice(COMMAND_TIMEOUT_ACTIONS),
        help="realtime: action when no command arrives in time: "
        f"{' | '.join(COMMAND_TIMEOUT_ACTIONS)}.",
    ),
    "command_stamps": click.option(
        "--command-stamps",
        type=_choice(COMMAND_STAMPS),
        help="With --no-controller: stamp that a command must have: that of the state that it "
        "answers, ROS time (in "
        f"lockstep /clock then leads by one period), or any: {' | '.join(COMMAND_STAMPS)} (default "
        "state).",
    ),
    "tf": click.option(
        "--tf",
        type=_choice(TRANSFORM_SCOPES),
        help=f"Transforms on /tf and /tf_static: {' | '.join(TRANSFORM_SCOPES)} (default all).",
    ),
    "frame_prefix": click.option(
        "--frame-prefix",
        type=_Name(r"[A-Za-z_][A-Za-z0-9_/]*", "west/"),
        help="Prefix of all TF frame names except `world`, for several cranes in one ROS domain.",
    ),
    "namespace": click.option(
        "--namespace",
        type=_Name(_WORD, "west"),
        help="Namespace of the nodes and their topics (default: the kind of crane).",
    ),
    "beside": click.option(
        "--beside",
        type=_Name(f"{_WORD}(,{_WORD})*", "west"),
        help="lockstep: namespaces of other cranes on the same clock, separated by commas.",
    ),
    "no_clock": click.option(
        "--no-clock", is_flag=True, help="Do not publish /clock: another crane does."
    ),
    "paused": click.option(
        "--paused", is_flag=True, help="Begin paused, until resumed by a service call."
    ),
    "fifo": click.option(
        "--fifo",
        type=click.IntRange(0, 99),
        help="realtime: priority 1 .. 99 of the plant (SCHED_FIFO); 0: none.",
    ),
}
_NOT_OF_DRIVE = ("mode", "no_controller", "wait", "command_stamps", "beside", "no_clock", "paused")


class RunOptions(NamedTuple):
    """The options of one run as given, each valid by itself; None: not given."""

    mode: str = "lockstep"
    rate: float | None = None
    record: Path | None = None
    no_record: bool = False
    mcap: Path | None = None
    live: bool = False
    domain_id: int | None = None
    no_controller: bool = False
    wait: float | None = None
    restart: bool = False
    on_silence: str | None = None
    command_stamps: str | None = None
    tf: str | None = None
    frame_prefix: str | None = None
    namespace: str | None = None
    beside: str | None = None
    no_clock: bool = False
    paused: bool = False
    fifo: int | None = None

    @classmethod
    def of_drive(cls, given: Mapping[str, Any]) -> "RunOptions":
        """Return the options of `crane drive`: real time, the operator's commands, else brakes."""
        on_silence = given["on_silence"] or CommandTimeoutAction.BRAKE.value
        return cls(mode="realtime", no_controller=True, **{**given, "on_silence": on_silence})

    def check(self) -> None:
        """Raise a one-line SceneError for an impossible combination, or a missing package."""
        for name in ("rate", "on_silence", "fifo"):
            self._require(
                name, "--mode realtime, lockstep does not follow the clock", self.mode == "realtime"
            )
        for name in ("wait", "command_stamps"):
            self._require(
                name, "--no-controller, which lets a node of yours command", self.no_controller
            )
        self._require(
            "beside",
            "lockstep, in real time the wall clock is shared by all",
            self.mode == "lockstep",
        )
        self._check_clock()
        if self.restart and self.no_controller and self.no_record and self.mcap is None:
            raise SceneError(
                "--restart: with --no-controller and --no-record there is nothing that it could "
                "replace"
            )
        self._check_files()
        require("rclpy", "a run over ROS")  # else the nodes would each end with a traceback
        if not self.no_record:
            require("rerun", "the recording (--no-record leaves it out)")

    def _require(self, name: str, what: str, there: bool) -> None:
        """Raise SceneError where an option is given without what it has an effect with."""
        if (value := getattr(self, name)) is not None and not there:
            raise SceneError(f"--{name.replace('_', '-')} = {value}: only with {what}")

    def _check_clock(self) -> None:
        """Raise SceneError for options that contradict a clock that leads."""
        if self.command_stamps != CommandStamps.ROS or self.mode != "lockstep":
            return
        if self.beside is not None:
            raise SceneError(
                f"--beside = {self.beside}: not with --command-stamps ros; possible: state, any"
            )
        if self.no_clock:
            raise SceneError(
                "--no-clock: not with --command-stamps ros, which is led by the clock in lockstep"
            )

    def check_scene(self, scene: "Scene") -> None:
        """Raise SceneError for an option that has no effect on the scene."""
        if self.beside is not None and not scene.sampled:
            possible = "possible: scenes with a sampled law"
            raise SceneError(
                f"--beside = {self.beside}: {scene.name} takes no commands; {possible}"
            )

    def _check_files(self) -> None:
        if self.record is not None and self.no_record:
            raise SceneError("--record and --no-record: only one of the two is possible")
        if self.live and self.no_record:
            raise SceneError(
                "--live and --no-record: only one of the two is possible, --live streams the "
                "recording"
            )
        if self.mcap is not None:
            _check_mcap(self.mcap)
            if self.record is not None and self.mcap.resolve() == self.record.resolve():
                raise SceneError(f"--mcap and --record: both are {self.mcap}")

    def arguments(self, scene: str) -> dict[str, Any]:
        """Return the arguments of `orchestration.run` for a scene of this name.

        Raises:
            SceneError: a file cannot be written.
        """
        default = Path("runs") / f"{scene}-{datetime.now():%Y%m%d-%H%M%S}.rrd"
        record = None if self.no_record else self.record or default
        for option, path in (("--record", record), ("--mcap", self.mcap)):
            if path is not None:
                ensure_writable_file(option, path)
        given = self._asdict()
        for name in ("no_record", "live", "no_controller", "no_clock"):
            del given[name]
        wait = _WAIT if self.wait is None else self.wait
        return given | {
            "record": record,
            "wait": wait or math.inf,
            "live_port": _free_port() if self.live else None,
            "controller": not self.no_controller,
            "clock": not self.no_clock,
        }


def run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of `RunOptions` to a command."""
    for option in reversed(_OPTIONS.values()):
        command = option(command)
    return command


def drive_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of `RunOptions` that `crane drive` has to a command."""
    for name in reversed(_OPTIONS):
        command = command if name in _NOT_OF_DRIVE else _OPTIONS[name](command)
    return command


def check_recording(path: Path | None) -> None:
    """Raise a single-line SceneError where `simulate --record` cannot write the recording."""
    if path is not None:
        require("rerun", "--record:")
        ensure_writable_file("--record", path)


def _check_mcap(path: Path) -> None:
    require("rosbags", "--mcap:")
    if path.suffix != ".mcap":
        raise SceneError(f"--mcap {path}: must end in .mcap, as readers expect")
    partial_file = unfinished_name(path)
    if not partial_file.exists():
        return
    with lock_file(
        partial_file
    ) as acquired:  # a killed run's file is recovered when this one begins
        if not acquired:
            raise SceneError(
                f"--mcap {path}: {partial_file} is in the way, another run is writing it"
            )


def ensure_writable_folder(folder: str | None) -> None:
    """Create the folder of `--save`; raise a one-line SceneError where no file can be written."""
    if folder is not None:
        _try_to_write(Path(folder), f"--save {folder!r}")


def ensure_writable_file(option: str, path: Path) -> None:
    """Create the folder of a file; raise a one-line SceneError where it cannot be written."""
    if path.is_dir():
        raise SceneError(f"{option} {path}: is a folder")
    if path.exists() and not path.is_file():
        raise SceneError(f"{option} {path}: is not a regular file")
    # not the file itself: an existing one stays until the run ends
    _try_to_write(path.parent, f"{option} {path}")


def _try_to_write(folder: Path, what: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise SceneError(f"{what}: cannot be written: {error.strerror}") from None


def _free_port() -> int:
    """Return the viewers' usual port, or another one if it is in use."""
    with socket.socket() as probe:
        try:
            probe.bind(("127.0.0.1", VIEWER_PORT))
        except OSError:
            probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]
