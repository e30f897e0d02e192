"""SIGINT and SIGTERM at any moment of `crane run`: a clean end within seconds, and nothing left behind."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from test_mcap import read

from crane_sim import load_scene, orchestration
from crane_sim.recording.reading import read_curves
from crane_sim.soak.signals import DURATION, LIMIT, SCENE, Interruption, interrupted, plan
from crane_sim.soak.signals import soak as signal_soak
from crane_sim.soak.witness import Account, witness


@pytest.fixture(scope="module")
def heard() -> Iterator[tuple[int, Account]]:
    """Yield a ROS domain and what an independent subscriber hears in it."""
    from crane_sim.orchestration.children import reserved_domain

    with reserved_domain() as domain, witness(load_scene(SCENE, {"duration": DURATION}), domain) as account:
        yield domain, account


@pytest.mark.parametrize(
    "how",
    [
        Interruption(signal.SIGINT, 0.02, None, fresh=False),
        Interruption(signal.SIGTERM, 0.3, None, fresh=False),
        Interruption(signal.SIGINT, 4.0, 0.2, fresh=True),
        Interruption(signal.SIGINT, 4.0, 0.1, fresh=False),
    ],
    ids=["as Python starts", "during imports", "while compiling", "in the run or before, and again"],
)
def test_an_interrupted_run_ends_cleanly(how: Interruption, heard: tuple[int, Account]) -> None:
    """It ends within 3 s: no traceback, no process, no part of a file is left, the last effort heard is zero."""
    end = interrupted(how, *heard)
    assert end.complaints == ()
    assert 0.0 < end.took < LIMIT
    assert end.code != 0


def test_an_interrupted_run_switches_the_drives_off(tmp_path: Path) -> None:
    """The last effort on the wire is zero, behind the last step: the recording has every step, and not that one."""

    def interrupt(step: int, _: int) -> None:
        if step > 100:
            signal.raise_signal(signal.SIGINT)

    scene, path = load_scene(SCENE, {"duration": 1e4}), tmp_path / "run.mcap"
    summary = orchestration.run(scene, record=tmp_path / "run.rrd", mcap=path, on_progress=interrupt)
    assert summary["error"] == "interrupted"
    assert summary["recorded_steps"] == summary["steps"] > 100
    assert summary["lost_steps"] == 0
    efforts = [list(message.effort) for _, message in read(path)["/knuckle/applied_effort"]]
    assert len(efforts) == summary["steps"] + 1
    assert efforts[-1] == [0.0] * len(scene.actuated)
    assert read_curves(tmp_path / "run.rrd", "plots/effort").values[-1].tolist() == efforts[-2]


COMPILED = """
import hashlib
from crane_sim import interruption
interruption.end_at_once(lambda: (print("ended", flush=True), __import__("os")._exit(1)))
print("ready", flush=True)
hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # like a compiler: for minutes no handler gets a turn
"""


def test_a_signal_is_heard_while_nothing_comes_back() -> None:
    """A thread ends the process at once, whatever call the main thread is in."""
    with subprocess.Popen([sys.executable, "-c", COMPILED], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        assert process.communicate(timeout=20.0)[0] == "ended\n"
    assert process.returncode == 1
    assert time.monotonic() - began < LIMIT


HELD_BACK = """
import os, signal
from crane_sim import interruption
os.kill(os.getpid(), signal.SIGTERM)  # blocked by who started this, as `./crane` does
interruption.end_at_once(lambda: os._exit(7))
while True:
    signal.pause()
"""


def test_a_signal_from_before_the_first_statement_is_not_lost() -> None:
    """What was held back while Python started counts as soon as somebody listens."""
    command = ["env", "--block-signal=INT,TERM", sys.executable, "-c", HELD_BACK]
    assert subprocess.run(command, timeout=20.0, check=False).returncode == 7


def test_the_plan_covers_start_run_and_end() -> None:
    """Fifty planned instants: some in the first 100 ms, some while compiling, some with a second signal, all seeded."""
    planned = plan(50, seed=0, usual=4.0)
    assert planned == plan(50, seed=0, usual=4.0) != plan(50, seed=1, usual=4.0)
    assert sum(each.at < 0.1 for each in planned) >= 10
    assert {each.number for each in planned} == {signal.SIGINT, signal.SIGTERM}
    assert any(each.fresh for each in planned) and any(each.again is not None for each in planned)


@pytest.mark.slow
def test_fifty_interruptions() -> None:
    """The soak of fifty random instants has nothing to complain about, and every end comes within 3 s."""
    figures, _ = signal_soak(50, seed=2)
    assert all(figure.kept for figure in figures), figures
