"""Signals at any moment of `crane run`: it exits within seconds, without leftovers."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from mcap_samples import read
from process_helpers import (
    has_exited,
    next_line,
    nodes_of,
    run_to_completion,
    started_program,
    wait_until,
)

from crane_bench.soak.monitor import MonitorFile, monitor
from crane_bench.soak.signals import (
    DURATION,
    RUN_KINDS,
    SCENE,
    Interruption,
    interrupt_run,
    plan,
    soak_signals,
)
from crane_sim import load_scene, orchestration
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain
from crane_sim.recording.rerun.reader import read_curves

LIMIT = 20.0  # s from a signal to the end: 3 s on an idle machine, as `crane soak signals` measures
STEPS_ON_DISK = 2_000_000  # bytes of a recording, thrice those before its first step


@pytest.fixture(scope="module")
def monitored() -> Iterator[tuple[int, MonitorFile]]:
    """Yield a ROS domain and the messages of an independent subscriber in it."""
    with (
        reserve_domain() as domain,
        monitor(load_scene(SCENE, {"duration": DURATION}), domain) as account,
    ):
        yield domain, account


@pytest.mark.parametrize(
    "how",
    [
        Interruption(signal.SIGINT, 0.02, None, fresh=False),
        Interruption(signal.SIGTERM, 0.3, None, fresh=False),
        Interruption(signal.SIGINT, 4.0, 0.2, fresh=True),
        Interruption(signal.SIGINT, 2.0, 0.1, fresh=False),  # the run alone takes 2 s
    ],
    ids=[
        "as Python starts",
        "during imports",
        "while compiling",
        "in the run or before, and again",
    ],
)
def test_an_interrupted_run_ends_cleanly(
    how: Interruption, monitored: tuple[int, MonitorFile]
) -> None:
    """It exits soon: no traceback, process or part of a file is left; the last effort is zero."""
    end = interrupt_run(how, *monitored)
    assert end.failures == ()
    assert 0.0 < end.took < LIMIT
    assert end.code != 0


@pytest.mark.long  # variations of the next one
@pytest.mark.parametrize("kind", [kind for kind in RUN_KINDS if kind != "realtime"])
def test_every_kind_of_run_is_interrupted_cleanly(
    kind: str, monitored: tuple[int, MonitorFile]
) -> None:
    """In lockstep, with restarts, with a bag: once it has begun it exits soon.

    No orphan and no part of a file is left, and the last effort is zero.
    """
    end = interrupt_run(
        Interruption(signal.SIGTERM, 0.3, None, fresh=False, way=kind, begun=True), *monitored
    )
    assert end.failures == ()
    assert 0.0 < end.took < LIMIT
    assert end.code == 1


def test_a_stopped_subscriber_delays_no_shutdown(monitored: tuple[int, MonitorFile]) -> None:
    """The same holds while a subscriber is stopped with messages on their way to it."""
    frozen = [sys.executable, str(Path(__file__).parents[1] / "programs" / "frozen_subscriber.py")]
    domain, _ = monitored
    with (
        tempfile.TemporaryDirectory() as folder,
        started_program(
            frozen, env=node_environment(domain, Path(folder)), stdout=subprocess.PIPE
        ) as subscriber,
    ):
        assert next_line(subscriber) == "subscribed\n"
        how = Interruption(signal.SIGINT, 0.3, None, fresh=False, way="lockstep", begun=True)
        end = interrupt_run(how, *monitored)
        state = Path(f"/proc/{subscriber.pid}/stat")
        wait_until(
            lambda: state.read_text().rpartition(")")[2].split()[0] == "T",
            "the subscriber's stop",
            60.0,
        )
    assert end.failures == ()
    assert 0.0 < end.took < LIMIT
    assert end.code == 1


def test_the_command_reports_that_its_plant_was_killed(tmp_path: Path) -> None:
    """`crane run` exits soon with exit code 1 and one line on the cause."""
    command = [
        Path(sys.executable).with_name("crane"),
        "run",
        "--duration",
        "1e5",
        "--record",
        "run.rrd",
        "--json",
    ]
    with started_program(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        part = tmp_path / "run.rrd.part"
        wait_until(
            lambda: (
                has_exited(process.pid) or (part.exists() and part.stat().st_size > STEPS_ON_DISK)
            ),
            "a recording",
        )
        os.kill(nodes_of(process.pid)["plant"], signal.SIGKILL)
        began = time.monotonic()
        out, errors = process.communicate()
    assert time.monotonic() - began < LIMIT
    assert process.returncode == 1
    assert [line for line in errors.splitlines() if "[INFO]" not in line] == [
        "crane: plant: it was killed by SIGKILL"
    ]
    summary, steps = json.loads(out), read_curves(tmp_path / "run.rrd", "plots/q").step
    assert summary["recorded_steps"] == summary["steps"] == len(steps) > 0
    assert steps.tolist() == list(range(1, len(steps) + 1))


@pytest.mark.usefixtures("patient_shutdown")
def test_an_interrupted_run_switches_the_drives_off(tmp_path: Path) -> None:
    """The last effort published, after the last step, is zero; the recording has every step.

    It does not have that effort.
    """

    def interrupt_run_at(step: int, _: int) -> None:
        if step > 100:
            signal.raise_signal(signal.SIGINT)

    scene, path = load_scene(SCENE, {"duration": 1e4}), tmp_path / "run.mcap"
    summary = orchestration.run(
        scene, record=tmp_path / "run.rrd", mcap=path, on_progress=interrupt_run_at
    )
    assert summary["error"] == "interrupted"
    assert summary["recorded_steps"] == summary["steps"] > 100
    assert summary["lost_steps"] == 0
    efforts = [list(message.effort) for _, message in read(path)["/knuckle/applied_effort"]]
    assert len(efforts) == summary["steps"] + 1
    assert efforts[-1] == [0.0] * len(scene.actuated)
    assert read_curves(tmp_path / "run.rrd", "plots/effort").values[-1].tolist() == efforts[-2]


COMPILED = """
import hashlib
from crane_sim import process_signals
process_signals.exit_on_signal(lambda: (print("ended", flush=True), __import__("os")._exit(1)))
print("ready", flush=True)
hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # like a compiler: for minutes no Python handler runs
"""  # noqa: E501


def test_a_signal_is_handled_during_a_long_call() -> None:
    """A thread ends the process at once, whatever call the main thread is in."""
    with started_program([sys.executable, "-c", COMPILED], stdout=subprocess.PIPE) as process:
        assert next_line(process) == "ready\n"
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        assert process.communicate(timeout=60.0)[0] == "ended\n"
    assert process.returncode == 1
    assert time.monotonic() - began < LIMIT


HANGING = """
import ctypes
from crane_sim import process_signals
process_signals.exit_on_signal(lambda: None)
print("ready", flush=True)
library, mutex = ctypes.PyDLL(None), ctypes.create_string_buffer(64)  # calls keep the interpreter's lock, like LAPACK
while True:
    library.pthread_mutex_lock(mutex)  # the second time for good: no other thread runs
"""  # noqa: E501


def test_a_signal_ends_a_call_that_lets_no_thread_run() -> None:
    """Ten seconds after a signal that nothing in Python can handle, the kernel ends the process."""
    with started_program([sys.executable, "-c", HANGING], stdout=subprocess.PIPE) as process:
        assert next_line(process) == "ready\n"
        process.send_signal(signal.SIGTERM)
        process.wait(60.0)
    assert process.returncode == -signal.SIGALRM


BLOCKED = """
import os, signal
from crane_sim import process_signals
os.kill(os.getpid(), signal.SIGTERM)  # blocked by the parent, as `./crane` does
process_signals.exit_on_signal(lambda: os._exit(7))
while True:
    signal.pause()
"""


def test_a_signal_from_before_the_first_statement_is_not_lost() -> None:
    """A signal that was blocked while Python started is handled as soon as there is a handler."""
    command = ["env", "--block-signal=INT,TERM", sys.executable, "-c", BLOCKED]
    assert run_to_completion(command).returncode == 7


REPLACED = """
import sys
from crane_sim import process_signals
process_signals.exit_on_signal(lambda: None)
process_signals.replace_process([sys.executable, "-c", "print('replaced')"])
"""


def test_another_program_takes_the_place_of_a_command() -> None:
    """A command that continues as another program, as `crane view`, ends with its exit code.

    So does `crane test`.
    """
    result = run_to_completion([sys.executable, "-c", REPLACED])
    assert (result.returncode, result.stdout) == (0, "replaced\n")


def test_the_plan_covers_start_run_and_end() -> None:
    """Fifty seeded interruptions: within 100 ms, in compilation, or with a second signal."""
    planned = plan(50, seed=0, usual=4.0)
    assert planned == plan(50, seed=0, usual=4.0) != plan(50, seed=1, usual=4.0)
    assert sum(each.at < 0.1 for each in planned) >= 10
    assert {each.number for each in planned} == {signal.SIGINT, signal.SIGTERM}
    assert any(each.fresh for each in planned) and any(each.again is not None for each in planned)
    assert {each.way for each in planned if not each.fresh} == set(RUN_KINDS)


@pytest.mark.slow
def test_fifty_interruptions() -> None:
    """The soak of fifty random instants has no failure, and every run exits within 3 s."""
    metrics, _ = soak_signals(50, seed=2)
    assert all(metric.passed for metric in metrics), metrics
