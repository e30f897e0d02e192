"""The options of `crane run`: checks of values and of combinations before anything starts."""

import math
import re
import socket
import tempfile
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from crane_sim.files.errors import SceneError
from crane_sim.files.installation import require
from crane_sim.recording.files import lock_file, unfinished_name
from crane_sim.ros.common.command_stamps import COMMAND_STAMPS, CommandStamps
from crane_sim.ros.common.transform_scope import TRANSFORM_SCOPES
from crane_sim.ros.plant.watchdog import COMMAND_TIMEOUT_ACTIONS, CommandTimeoutAction

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

_PREFIX = re.compile(r"[A-Za-z_][A-Za-z0-9_/]*")  # of frame names
_NAMESPACE = re.compile(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)  # as ROS allows it, without the leading slash
VIEWER_PORT = 9876  # the default port of a Rerun viewer

_OPTIONS = {
    "mode": click.option("--mode", default="lockstep", help="lockstep | realtime (default lockstep)."),
    "rate": click.option("--rate", type=float, help="realtime: simulated seconds per second."),
    "record": click.option(
        "--record", type=click.Path(path_type=Path), help="File of the recording (default: runs/SCENE-TIME.rrd)."
    ),
    "no_record": click.option("--no-record", is_flag=True, help="Write no recording."),
    "mcap": click.option("--mcap", type=click.Path(path_type=Path), help="Also write the ROS messages to FILE.mcap."),
    "live": click.option(
        "--live", is_flag=True, help="Stream to Rerun viewers on this machine; best with --mode realtime."
    ),
    "domain_id": click.option("--domain-id", type=int, help="ROS domain id, 0 .. 232; a free one when left out."),
    "no_controller": click.option("--no-controller", is_flag=True, help="Your own node commands the crane."),
    "wait": click.option(
        "--wait",
        type=float,
        help="With --no-controller, in lockstep: seconds that the plant waits for a command of your node until the run "
        "ends (default 120; 0: no limit). The node has at least 120 s to connect, also in real time.",
    ),
    "restart": click.option("--restart", is_flag=True, help="Replace a controller, tracker or recorder that dies."),
    "on_silence": click.option(
        "--on-silence", help=f"realtime: action when no command arrives in time: {' | '.join(COMMAND_TIMEOUT_ACTIONS)}."
    ),
    "command_stamps": click.option(
        "--command-stamps",
        help="With --no-controller: stamp that a command must have: that of the state that it answers, ROS time (in "
        f"lockstep /clock then leads by one period), or any: {' | '.join(COMMAND_STAMPS)} (default state).",
    ),
    "tf": click.option("--tf", help=f"Transforms on /tf and /tf_static: {' | '.join(TRANSFORM_SCOPES)} (default all)."),
    "frame_prefix": click.option(
        "--frame-prefix", help="Prefix of all TF frame names except `world`, for several cranes in one ROS domain."
    ),
    "namespace": click.option(
        "--namespace", help="Namespace of the nodes and their topics (default: the kind of crane)."
    ),
    "beside": click.option(
        "--beside", help="lockstep: namespaces of other cranes on the same clock, separated by commas."
    ),
    "no_clock": click.option("--no-clock", is_flag=True, help="Do not publish /clock: another crane does."),
    "paused": click.option("--paused", is_flag=True, help="Begin paused, until resumed by a service call."),
    "fifo": click.option("--fifo", type=int, help="realtime: priority 1 .. 99 of the plant (SCHED_FIFO); 0: none."),
}


_OF_DRIVE = ("rate", "record", "no_record", "mcap", "live", "domain_id", "restart", "on_silence", "tf")
_OF_DRIVE += ("frame_prefix", "namespace", "fifo")


class RunOptions(NamedTuple):
    """The options of one run as given; None: not given (`arguments` leaves those out or fills in the default)."""

    mode: str
    rate: float | None
    record: Path | None
    no_record: bool
    mcap: Path | None
    live: bool
    domain_id: int | None
    no_controller: bool
    wait: float | None
    restart: bool
    on_silence: str | None
    command_stamps: str | None
    tf: str | None
    frame_prefix: str | None
    namespace: str | None
    beside: str | None
    no_clock: bool
    paused: bool
    fifo: int | None

    @classmethod
    def of_drive(cls, given: Mapping[str, Any]) -> "RunOptions":
        """Return the options of `crane drive`: in real time, commanded by the operator, braked without commands."""
        values: dict[str, Any] = {"mode": "realtime", "no_controller": True, "wait": None, "command_stamps": None}
        values |= {"beside": None, "no_clock": False, "paused": False}
        values |= given
        values["on_silence"] = given["on_silence"] or CommandTimeoutAction.BRAKE.value
        return cls(**values)

    def check(self) -> None:
        """Raise a single-line SceneError for an impossible value or combination, or a package that is missing."""
        if self.mode not in ("lockstep", "realtime"):
            raise SceneError(f"--mode = {self.mode!r}: possible: lockstep, realtime")
        if self.rate is not None and not (self.rate > 0.0 and math.isfinite(self.rate)):
            raise SceneError(f"--rate = {self.rate}: must be a positive number")
        if self.domain_id is not None and not 0 <= self.domain_id <= 232:
            raise SceneError(f"--domain-id = {self.domain_id}: possible: 0 .. 232")
        if self.on_silence is not None and self.on_silence not in COMMAND_TIMEOUT_ACTIONS:
            raise SceneError(f"--on-silence = {self.on_silence!r}: possible: {', '.join(COMMAND_TIMEOUT_ACTIONS)}")
        if self.command_stamps is not None and self.command_stamps not in COMMAND_STAMPS:
            raise SceneError(f"--command-stamps = {self.command_stamps!r}: possible: {', '.join(COMMAND_STAMPS)}")
        if self.tf is not None and self.tf not in TRANSFORM_SCOPES:
            raise SceneError(f"--tf = {self.tf!r}: possible: {', '.join(TRANSFORM_SCOPES)}")
        if self.wait is not None and not (self.wait >= 0.0 and math.isfinite(self.wait)):
            raise SceneError(f"--wait = {self.wait}: must be a number of seconds, 0 or more")
        if self.fifo is not None and not 0 <= self.fifo <= 99:
            raise SceneError(f"--fifo = {self.fifo}: possible: 1 .. 99, and 0 for none")
        self._check_names()
        self._check_effect()
        self._check_files()
        self._check_packages()

    def _check_packages(self) -> None:
        """Raise MissingPackage where the nodes could not be imported: they would each end with a traceback."""
        require("rclpy", "a run over ROS")
        if not self.no_record:
            require("rerun", "the recording (--no-record leaves it out)")

    def _check_names(self) -> None:
        """Raise SceneError for an invalid ROS name."""
        if self.frame_prefix is not None and not _PREFIX.fullmatch(self.frame_prefix):
            raise SceneError(
                f"--frame-prefix = {self.frame_prefix!r}: possible: letters, digits, _ and /, such as west/"
            )
        for option, names in (("--namespace", self.namespace), ("--beside", self.beside)):
            for name in [] if names is None else names.split(",") if option == "--beside" else [names]:
                if not _NAMESPACE.fullmatch(name):
                    raise SceneError(f"{option} = {names!r}: possible: letters, digits, _ and /, such as west")

    def _check_effect(self) -> None:
        """Raise SceneError for an option without effect."""
        realtime_options = {"--rate": self.rate, "--on-silence": self.on_silence, "--fifo": self.fifo}
        for option, value in realtime_options.items():
            if self.mode == "lockstep" and value is not None:
                raise SceneError(f"{option} = {value}: only with --mode realtime, lockstep does not follow the clock")
        self._check_clock()
        if self.restart and self.no_controller and self.no_record and self.mcap is None:
            raise SceneError("--restart: with --no-controller and --no-record there is nothing that it could replace")
        own_options = {"--wait": self.wait, "--command-stamps": self.command_stamps}
        for option, value in own_options.items():
            if value is not None and not self.no_controller:
                raise SceneError(f"{option} = {value}: only with --no-controller, which lets a node of yours command")

    def _check_clock(self) -> None:
        """Raise SceneError for options that contradict each other about the clock of a run."""
        if self.beside is not None and self.mode == "realtime":
            raise SceneError(
                f"--beside = {self.beside}: only in lockstep, in real time the wall clock is shared by all"
            )
        if self.command_stamps != CommandStamps.ROS or self.mode != "lockstep":
            return
        if self.beside is not None:
            raise SceneError(f"--beside = {self.beside}: not with --command-stamps ros; possible: state, any")
        if self.no_clock:
            raise SceneError("--no-clock: not with --command-stamps ros, which is led by the clock in lockstep")

    def check_scene(self, scene: "Scene") -> None:
        """Raise SceneError for an option that has no effect on the scene."""
        if self.beside is not None and not scene.sampled:
            raise SceneError(
                f"--beside = {self.beside}: {scene.name} takes no commands; possible: scenes with a sampled law"
            )

    def _check_files(self) -> None:
        if self.record is not None and self.no_record:
            raise SceneError("--record and --no-record: only one of the two is possible")
        if self.live and self.no_record:
            raise SceneError("--live and --no-record: only one of the two is possible, --live streams the recording")
        if self.mcap is not None:
            _check_mcap(self.mcap)
        if self.mcap is not None and self.record is not None and self.mcap.resolve() == self.record.resolve():
            raise SceneError(f"--mcap and --record: both are {self.mcap}")

    def arguments(self, scene: str) -> dict[str, Any]:
        """Return the arguments of `orchestration.run` for a scene of this name.

        Raises:
            SceneError: a file cannot be written.
        """
        record = None if self.no_record else self.record or _default_recording(scene)
        for option, path in (("--record", record), ("--mcap", self.mcap)):
            if path is not None:
                ensure_writable_file(option, path)
        set_options = {"rate": self.rate, "on_silence": self.on_silence, "fifo": self.fifo}
        set_options |= {"command_stamps": self.command_stamps, "tf": self.tf, "frame_prefix": self.frame_prefix}
        set_options |= {"namespace": self.namespace, "beside": self.beside}
        set_options["wait"] = math.inf if self.wait == 0.0 else self.wait
        return {name: value for name, value in set_options.items() if value is not None} | {
            "mode": self.mode,
            "record": record,
            "mcap": self.mcap,
            "live_port": _free_port() if self.live else None,
            "domain_id": self.domain_id,
            "controller": not self.no_controller,
            "restart": self.restart,
            "paused": self.paused,
            "clock": not self.no_clock,
        }


def ensure_writable_folder(folder: str | None) -> None:
    """Create the folder of `--save`; raise a single-line SceneError where no file can be written into it."""
    if folder is None:
        return
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise SceneError(f"--save {folder!r}: cannot be written: {error.strerror}") from None


def check_recording(path: Path | None) -> None:
    """Raise a single-line SceneError where `simulate --record` cannot write the recording."""
    if path is None:
        return
    require("rerun", "--record:")
    ensure_writable_file("--record", path)


def run_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of `RunOptions` to a command."""
    for option in reversed(_OPTIONS.values()):
        command = option(command)
    return command


def drive_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of `RunOptions` that `crane drive` has to a command."""
    for name in reversed(_OF_DRIVE):
        command = _OPTIONS[name](command)
    return command


def _default_recording(scene: str) -> Path:
    return Path("runs") / f"{scene}-{datetime.now():%Y%m%d-%H%M%S}.rrd"


def _check_mcap(path: Path) -> None:
    require("rosbags", "--mcap:")
    if path.suffix != ".mcap":
        raise SceneError(f"--mcap {path}: must end in .mcap, as readers expect")
    partial_file = unfinished_name(path)
    if not partial_file.exists():
        return
    with lock_file(partial_file) as acquired:  # a killed run's file is recovered when this one begins
        if not acquired:
            raise SceneError(f"--mcap {path}: {partial_file} is in the way, another run is writing it")


def ensure_writable_file(option: str, path: Path) -> None:
    """Create the folder of a file; raise a single-line SceneError where the file cannot be written."""
    if path.is_dir():
        raise SceneError(f"{option} {path}: is a folder")
    if path.exists() and not path.is_file():
        raise SceneError(f"{option} {path}: is not a regular file")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.parent):  # not the file itself: an existing one stays until the run ends
            pass
    except OSError as error:
        raise SceneError(f"{option} {path}: cannot be written: {error.strerror}") from None


def _free_port() -> int:
    """Return the viewers' usual port, or another one if it is in use."""
    for port in (VIEWER_PORT, 0):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return probe.getsockname()[1]
    raise SceneError("--live: no free port on this machine")
