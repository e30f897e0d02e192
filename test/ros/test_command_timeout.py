"""Time-out of commands in real time by its own clock, without ROS: pauses, steps, slow motion."""

import ctypes
import sys
from concurrent.futures import ThreadPoolExecutor
from operator import itemgetter

import pytest
from rclpy.serialization import serialize_message
from realtime_doubles import JOINTS, PERIOD, TIMEOUT, RealtimeBench, make_bench
from std_msgs.msg import Float64MultiArray

from crane_sim.ros.common.serialization import EFFORT, JointStateCodec
from crane_sim.ros.plant.realtime import Realtime

ZERO = (0.0, 0.0)


def kill_controller(bench: RealtimeBench) -> None:
    """Let the controller answer no more."""
    bench.delay = None


def pause(bench: RealtimeBench, realtime: Realtime, seconds: float) -> None:
    """Pause the run for a while."""
    bench.paused = True

    def resume() -> None:
        bench.paused = False
        realtime.resume()

    bench.events.append((bench.now + seconds, resume))
    bench.events.sort(key=itemgetter(0))


@pytest.mark.parametrize(
    ("timeout", "on_silence", "last", "warned"),
    [
        (0.4, "zero", ZERO, "no valid command for 0.4 s: zero effort"),
        (0.4, "hold", (1.0, 0.0), "no valid command for 0.4 s: the last effort holds"),
        (0.4, "brake", (1.0, 0.0), "no valid command for 0.4 s: the brakes act"),
        (0.0, "zero", (1.0, 0.0), ""),
    ],
)
def test_the_timeout_action_follows_a_silent_controller(
    timeout: float,
    on_silence: str,
    last: tuple[float, ...],
    warned: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The last command holds until the time-out, then the chosen action follows, with a warning.

    A time-out of 0 is none.
    """
    bench, realtime = make_bench(monkeypatch, 80, 0.002, on_silence, timeout=timeout)
    kill_controller(bench)  # it has answered the first state
    realtime.run()
    assert bench.efforts[0] == bench.answer(0) == (1.0, 0.0) and bench.efforts[-1] == last
    assert bench.warning == warned and bench.plant.braking == (on_silence == "brake")
    if warned:  # with the first step after the time-out, not with the one before
        assert (
            bench.times[bench.warned - 2]
            <= timeout + 0.002 + 1e-3
            < bench.times[bench.warned] + 1e-3
        )
    assert realtime.metrics()["silences"] == bool(warned)


def test_an_array_of_the_wrong_size_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """An array acts in joint order if it has one effort per joint, and is refused otherwise."""
    bench, realtime = make_bench(monkeypatch, 80, None, timeout=0.0)
    for numbers in ([5.0, 6.0], [1.0, 2.0, 3.0]):
        bench.callbacks["effort_controller/commands"](
            serialize_message(Float64MultiArray(data=numbers))
        )
        realtime.step_once()
    assert bench.efforts == [(5.0, 6.0)] * 2
    assert bench.validator.summary() == {"received": 2, "rejected": 1, "late": 0, "duplicate": 0}


@pytest.mark.parametrize(("late", "counts"), [(1.5, True), (1.7, False)])
def test_a_command_is_stale_by_wall_time(
    late: float, counts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At four times real time a command may answer a state that is four time-outs old.

    These are time-outs of simulated time.
    """
    bench, realtime = make_bench(monkeypatch, 80, None, rate=4.0, timeout=0.4)
    bench.stamp = 10_000_000_000
    stamp = bench.stamp - round(late * 1e9)
    bench.callbacks["joint_commands"](JointStateCodec(JOINTS, EFFORT).encode(stamp, (3.0, 4.0)))
    realtime.step_once()
    assert bench.efforts == [(3.0, 4.0) if counts else ZERO]
    assert bench.validator.refused == ({} if counts else {"stale": 1})


@pytest.mark.skipif(sys.platform != "linux", reason="timer slack is Linux's")
def test_a_run_sleeps_without_timer_slack(monkeypatch: pytest.MonkeyPatch) -> None:
    """A real-time run sets the least timer slack, 1 ns, of its thread; Linux's default is 50 us."""
    prctl = ctypes.CDLL(None).prctl
    set_slack, get_slack = 29, 30
    _, realtime = make_bench(monkeypatch, 3, None)

    def timer_slacks() -> list[int]:
        prctl(set_slack, ctypes.c_ulong(50_000))
        before = prctl(get_slack)
        realtime.run()
        return [before, prctl(get_slack)]

    if prctl(get_slack) < 0:
        pytest.skip("this system does not allow to set it")
    with ThreadPoolExecutor(1) as thread:  # its slack is its own
        assert thread.submit(timer_slacks).result() == [50_000, 1]


@pytest.mark.parametrize(
    ("delay", "commanded", "unanswered", "marked"),
    [(0.2, False, 0, False), (None, False, 50, True), (None, True, 50, False)],
)
def test_steps_without_a_new_command_are_counted(
    delay: float | None,
    commanded: bool,
    unanswered: int,
    marked: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A run whose own controller does not answer is marked; a user's may command less often."""
    bench, realtime = make_bench(monkeypatch, 150, None if delay is None else delay * PERIOD)
    realtime._settings.commanded = commanded
    realtime.run()
    metrics = realtime.metrics()
    assert metrics["unanswered_steps"] == unanswered
    assert (
        metrics.get("real_time_violation") == "0 of 150 steps were late, and 50 had no new command"
    ) == marked


@pytest.mark.parametrize(("late", "marked"), [(0, False), (1, False), (2, True), (40, True)])
def test_a_run_of_which_a_hundredth_was_late_is_marked(
    late: int, marked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """More late steps than one in a hundred mark a run as one that the machine was too slow for."""
    bench, realtime = make_bench(monkeypatch, 150, 0.2 * PERIOD)
    realtime.run()
    bench.deadline_misses = late
    assert (
        realtime.metrics()
        .get("real_time_violation", "")
        .startswith(f"{late} of 150 steps were late")
        == marked
    )


@pytest.mark.parametrize(("on_silence", "last"), [("zero", ZERO), ("brake", (20.0, 0.0))])
def test_a_pause_does_not_end_a_timeout(
    on_silence: str, last: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The action at the time-out goes on after a pause, with a step in it, and is counted once."""
    bench, realtime = make_bench(monkeypatch, 150, 0.002, on_silence)
    states: list[tuple[bool, str]] = []

    def step_and_record() -> None:
        realtime.step_once()
        states.append((bench.plant.braking, bench.warning))

    bench.events = [
        (0.195, lambda: kill_controller(bench)),
        (1.0, lambda: pause(bench, realtime, 3.0)),
        (2.0, step_and_record),
        (4.2, step_and_record),
    ]
    realtime.run()
    timed_out = (on_silence == "brake", bench.warning)
    assert bench.warning.startswith("no valid command for 0.5 s")
    assert states == [timed_out, timed_out]
    assert bench.efforts[-80:] == [last] * 80
    assert realtime.metrics()["silences"] == 1


def test_pauses_do_not_reset_the_watchdog(monkeypatch: pytest.MonkeyPatch) -> None:
    """With any number of pauses, half a second of motion without a command is a time-out."""
    bench, realtime = make_bench(monkeypatch, 100, 0.002)
    bench.events = [(0.195, lambda: kill_controller(bench))]
    bench.events += [(0.3 + k, lambda: pause(bench, realtime, 0.7)) for k in range(5)]
    realtime.run()
    held = bench.efforts.count(bench.answer(19))
    assert TIMEOUT / PERIOD <= held <= TIMEOUT / PERIOD + 6  # a period may be lost with every pause
    assert bench.efforts[-1] == ZERO


def test_a_pause_is_no_timeout(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a pause of any length an answering controller's commands hold, without a time-out."""
    bench, realtime = make_bench(monkeypatch, 60, 0.002)
    bench.events = [(0.2, lambda: pause(bench, realtime, 100.0))]
    realtime.run()
    assert realtime.metrics()["silences"] == 0
    assert bench.efforts == [bench.answer(k) for k in range(60)]


def test_a_reset_resets_the_watchdog(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the new run the brakes are off and the warning is gone, until that run's time-out."""
    bench, realtime = make_bench(monkeypatch, 200, None, "brake")
    states: list[tuple[bool, str]] = []

    def reset() -> None:
        realtime.reset()
        states.append((bench.plant.braking, bench.warning))

    bench.events = [(1.0, reset)]
    realtime.run()
    assert states == [(False, "")]
    assert bench.plant.braking and realtime.metrics()["silences"] == 2


def test_the_first_step_after_a_reset_waits_for_its_command(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A reset just before a step is due leaves the controller a whole period.

    No step is taken without an effort.
    """
    bench, realtime = make_bench(monkeypatch, 50, 0.002)

    def reset() -> None:
        bench.publish_first_state()
        realtime.reset()

    bench.events = [(0.2095, reset)]
    realtime.run()
    assert ZERO not in bench.efforts
    # s; the reset comes with the end of a spin
    assert bench.times[20] == pytest.approx(0.2095 + PERIOD, abs=5e-4)


def test_commands_hold_in_slow_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """At a hundredth of real time a state's answer holds for one period more, and no longer.

    A state comes once a second.
    """
    bench, realtime = make_bench(monkeypatch, 10, 0.005, rate=0.01)
    bench.events = [(5.5, lambda: kill_controller(bench))]
    realtime.run()
    assert bench.efforts == [bench.answer(k) for k in (0, 1, 2, 3, 4, 5, 5)] + [ZERO] * 3
    assert bench.warning == "no valid command for 2 s: zero effort"


def test_an_answer_in_slow_motion_may_be_a_period_old(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands that take longer than a period, and than the time-out, hold, and none is stale."""
    bench, realtime = make_bench(monkeypatch, 6, 1.2, rate=0.01)
    realtime.run()
    assert bench.efforts == [ZERO] + [bench.answer(k) for k in range(5)]
    assert not bench.validator.refused


@pytest.mark.parametrize("delay", [0.0, 0.004])
def test_single_steps_take_the_controller_s_answers(
    delay: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of many steps in one call each takes its own state's answer.

    The answer takes almost half a period.
    """
    bench, realtime = make_bench(monkeypatch, 100, delay)
    bench.paused = True
    for _ in range(50):
        assert realtime.step_once() == ""
    assert bench.efforts == [bench.answer(k) for k in range(50)]


def test_single_steps_do_not_wait_after_the_timeout(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each waits for a period, until they add up to the time-out: then zero effort acts at once."""
    bench, realtime = make_bench(monkeypatch, 400, 0.0)
    bench.paused = True
    realtime.step_once()
    bench.advance_clock(100.0)  # the pause does not count
    kill_controller(bench)
    for _ in range(300):
        realtime.step_once()
    held = bench.efforts.count(bench.answer(1))
    # the controller answers the last state before its death
    assert abs(held - TIMEOUT / PERIOD) <= 2
    assert bench.efforts[-1] == ZERO
    assert bench.now - 100.0 == pytest.approx(TIMEOUT, abs=2 * PERIOD)
