"""How long a recorder waits, at the end of a run, for messages that are on their way."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from mcap_samples import SCENE as BAG_SCENE
from mcap_samples import TOPICS
from mcap_samples import feed as feed_bag
from recorder_helpers import SCENE, feed

from crane_sim.recording.mcap.bag import Bag
from crane_sim.recording.rerun.recorder import Recorder

OUTPUTS: dict[str, tuple[Callable, Callable]] = {
    "crane_sim.recording.rerun.recorder": (
        lambda folder: Recorder(SCENE, folder / "run.rrd"),
        feed,
    ),
    "crane_sim.recording.mcap.bag": (
        lambda folder: Bag(folder / "run.mcap", TOPICS, BAG_SCENE.period_ns),
        feed_bag,
    ),
}


@pytest.mark.parametrize("module", OUTPUTS)
def test_a_hold_up_of_the_recorder_is_no_silence(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Messages that a held-up recorder has not read are waited for.

    The time counts from the request to finish.
    """
    now = [0.0]
    monkeypatch.setattr(f"{module}.time", SimpleNamespace(monotonic=lambda: now[0]))
    make, send = OUTPUTS[module]
    output = make(tmp_path)
    send(output, 10)
    now[0] = 60.0
    assert output.has_all(20)  # without a request: nothing has come for a minute
    output.expect_messages()
    assert not output.has_all(20)
    send(output, 20, after=10)
    now[0] = 61.0
    assert output.has_all(20)
    now[0] = 120.0
    output.expect_messages()
    now[0] = 130.0
    assert output.has_all(30)  # lost ones are not waited for for ever
