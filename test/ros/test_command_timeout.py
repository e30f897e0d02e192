"""Silence in real time by a clock of its own, without ROS: pauses, single steps and slow motion."""

from operator import itemgetter

import pytest
from realtime_doubles import PERIOD
from silence_doubles import TIMEOUT, Bench, begun

from crane_sim.ros.plant.realtime import Realtime

ZERO = (0.0, 0.0)


def die(bench: Bench) -> None:
    """Let the controller be dead from now on."""
    bench.delay = None


def pause(bench: Bench, realtime: Realtime, seconds: float) -> None:
    """Let the run stand for a while from now on."""
    bench.paused = True

    def go_on() -> None:
        bench.paused = False
        realtime.go_on()

    bench.plan.append((bench.now + seconds, go_on))
    bench.plan.sort(key=itemgetter(0))


@pytest.mark.parametrize(("on_silence", "last"), [("zero", ZERO), ("brake", (20.0, 0.0))])
def test_a_pause_brings_no_dead_controller_back(
    on_silence: str, last: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What acts on silence goes on acting behind a pause, a single step within it included, and is counted once."""
    bench, realtime = begun(monkeypatch, 150, 0.002, on_silence)
    seen: list[tuple[bool, str]] = []

    def look() -> None:
        realtime.step_once()
        seen.append((bench.plant.braking, bench.warning))

    bench.plan = [(0.195, lambda: die(bench)), (1.0, lambda: pause(bench, realtime, 3.0)), (2.0, look), (4.2, look)]
    realtime.run()
    silent = (on_silence == "brake", bench.warning)
    assert bench.warning.startswith("no valid command for 0.5 s")
    assert seen == [silent, silent]
    assert bench.efforts[-80:] == [last] * 80
    assert realtime.figures()["silences"] == 1


def test_pauses_do_not_hold_the_watchdog_off(monkeypatch: pytest.MonkeyPatch) -> None:
    """However often the run is paused: half a second in which it moves without a command is a silence."""
    bench, realtime = begun(monkeypatch, 100, 0.002)
    bench.plan = [(0.195, lambda: die(bench))]
    bench.plan += [(0.3 + k, lambda: pause(bench, realtime, 0.7)) for k in range(5)]
    realtime.run()
    held = bench.efforts.count(bench.answer(19))
    assert TIMEOUT / PERIOD <= held <= TIMEOUT / PERIOD + 6  # a period may be lost with every pause
    assert bench.efforts[-1] == ZERO


def test_a_pause_is_no_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    """A controller that answers has the crane behind a pause of any length, and never was silent."""
    bench, realtime = begun(monkeypatch, 60, 0.002)
    bench.plan = [(0.2, lambda: pause(bench, realtime, 100.0))]
    realtime.run()
    assert realtime.figures()["silences"] == 0
    assert bench.efforts == [bench.answer(k) for k in range(60)]


def test_a_reset_gives_a_silent_controller_its_time_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the new run the brakes are off and the warning is gone, until nobody has commanded that, either."""
    bench, realtime = begun(monkeypatch, 200, None, "brake")
    seen: list[tuple[bool, str]] = []

    def reset() -> None:
        realtime.forget()
        seen.append((bench.plant.braking, bench.warning))

    bench.plan = [(1.0, reset)]
    realtime.run()
    assert seen == [(False, "")]
    assert bench.plant.braking and realtime.figures()["silences"] == 2


def test_slow_motion_obeys_its_controller(monkeypatch: pytest.MonkeyPatch) -> None:
    """At a hundredth of real time a state comes once a second: its answer holds until the next one, and longer not."""
    bench, realtime = begun(monkeypatch, 10, 0.005, rate=0.01)
    bench.plan = [(5.5, lambda: die(bench))]
    realtime.run()
    assert bench.efforts == [bench.answer(k) for k in (0, 1, 2, 3, 4, 5, 5)] + [ZERO] * 3
    assert bench.warning == "no valid command for 2 s: zero effort"


def test_an_answer_of_slow_motion_may_be_a_period_old(monkeypatch: pytest.MonkeyPatch) -> None:
    """A controller that needs longer than a period, and than the time-out, is obeyed, and nothing is stale."""
    bench, realtime = begun(monkeypatch, 6, 1.2, rate=0.01)
    realtime.run()
    assert bench.efforts == [ZERO] + [bench.answer(k) for k in range(5)]
    assert not bench.gate.refused


@pytest.mark.parametrize("delay", [0.0, 0.004])
def test_single_steps_obey_the_controller(delay: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of many steps in one call each takes the answer to its own state, although that needs almost half a period."""
    bench, realtime = begun(monkeypatch, 100, delay)
    bench.paused = True
    for _ in range(50):
        assert realtime.step_once() == ""
    assert bench.efforts == [bench.answer(k) for k in range(50)]


def test_single_steps_wait_for_no_dead_controller(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each waits for a period, until the time-out has passed in this way: then zero effort acts, and nobody waits."""
    bench, realtime = begun(monkeypatch, 400, 0.0)
    bench.paused = True
    realtime.step_once()
    bench.pass_time(100.0)  # the pause counts for nothing
    die(bench)
    for _ in range(300):
        realtime.step_once()
    held = bench.efforts.count(bench.answer(1))
    assert abs(held - TIMEOUT / PERIOD) <= 2  # it answers the state that has left before it dies
    assert bench.efforts[-1] == ZERO
    assert bench.now - 100.0 == pytest.approx(TIMEOUT, abs=2 * PERIOD)
