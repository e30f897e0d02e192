"""Tension of every link: one meaning for every cable model, in runs, summaries, terminal."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.cli.report import print_summary
from crane_sim.recording.layout import layout_of_scene
from crane_sim.simulation.derived import derive

NODES = {"lengths": [0.5, 0.4, 0.3, 0.2, 0.1], "node_masses": [0.1, 0.2, 0.3, 0.4, 60.0]}
FIXED: dict[str, Any] = {"crane": "overhead", "duration": 1.0, "trolley": {"drive": "fixed"}}
G = 9.81


def scene_of(cable: dict[str, Any], **groups: Any) -> crane_sim.Scene:
    """Return the scene of a cable below a trolley at rest, unless groups say otherwise."""
    return crane_sim.load_scene(FIXED | {"cable": cable} | groups)


def tensions(scene: crane_sim.Scene, q: Any = None, v: Any = None) -> Any:
    """Return the tensions (L,) [N] of a scene at joints q, v, by default those of its start."""
    at = (scene.initial_q if q is None else q, scene.initial_v if v is None else v)
    q, v = (np.array([part], dtype=float) for part in at)
    return derive(scene, np.zeros(1), q, v, np.zeros((1, len(scene.actuated)))).tensions[0]


def weights(masses: Any) -> Any:
    """Return what hangs on each link [N]."""
    return G * np.cumsum(np.array(masses)[::-1])[::-1]


STRETCHED = [
    [0.0, -z]
    for z in np.cumsum(np.array(NODES["lengths"]) + weights(NODES["node_masses"]) / 1e5).tolist()
]
HANGING: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "rigid": ({"model": "rigid"}, {}),
    "straight": ({"model": "straight"}, {}),
    "auto": ({"model": "auto"}, {}),
    "space": ({"model": "rigid"}, {"dimensions": 3, "bridge": {"drive": "fixed"}}),
    "turning rods": ({"model": "rigid", "inertia": 0.1}, {}),
    "moving base": (
        {"model": "rigid"},
        {"base_motion": {"heave": {"amplitude": 0.0, "frequency": 1.0}}},
    ),
    "elastic": ({"model": "elastic", "stiffness": 1e5}, {"initial": {"positions": STRETCHED}}),
}


@pytest.mark.parametrize("kind", HANGING)
def test_each_link_of_a_hanging_cable_carries_what_is_below(kind: str) -> None:
    """Of five nodes at rest every model gives five tensions, from all weight to the payload's."""
    cable, groups = HANGING[kind]
    scene, expected = scene_of(NODES | cable, **groups), weights(NODES["node_masses"])
    # rounding; of an elastic cable that of positions, 1e-16 m times 1e5 N/m of 600 N
    assert tensions(scene) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("lengths", [[1.0, 0.8], [0.5, 0.6, 0.7]], ids=["double", "chain"])
def test_a_straight_cable_pulls_as_its_chain_does(lengths: list[float]) -> None:
    """While it swings, a straight cable's tensions are those of its chain, link by link."""
    light = 1e-4
    cable = {"lengths": lengths, "node_masses": [light] * (len(lengths) - 1) + [10.0]}
    trolley = {"trolley": {"drive": "force", "mass": 5.0}}
    rod, chain = (scene_of(cable | {"model": model}, **trolley) for model in ("straight", "rigid"))
    actual = tensions(rod, [0.0, 0.5], [0.4, 1.2])
    expected = tensions(chain, [0.0, *[0.5] * len(lengths)], [0.4, *[1.2] * len(lengths)])
    # N of 68: the rod's error is some multiple of the light masses'
    assert actual == pytest.approx(expected, abs=2e-3)
    assert np.ptp(actual) > 5e-4  # each link carries another load


def test_a_hoisted_straight_cable_pulls_as_its_chain_does() -> None:
    """A winch that accelerates the first link's length is in the tensions of all links."""
    cable = {"lengths": [0.5, 0.6, 0.7], "node_masses": [1e-4, 1e-4, 10.0]}
    profile = {"kind": "polynomial", "coefficients": [0.5, 0.3, 1.5]}  # m/s² of 3 pay the cable out
    hoist = {"hoist": {"drive": "prescribed", "profile": profile}}
    rod, chain = (scene_of(cable | {"model": model}, **hoist) for model in ("straight", "rigid"))
    actual = tensions(rod, [0.0, 0.5, 0.4], [0.0, 0.3, 0.9])
    expected = tensions(chain, [0.0, 0.5, *[0.4] * 3], [0.0, 0.3, *[0.9] * 3])
    assert actual == pytest.approx(expected, abs=2e-3)  # as above
    assert float(actual[0]) < 0.8 * 10.0 * G  # and far from the weight


def test_a_run_has_the_tensions_of_its_loop() -> None:
    """A run gives all links' tensions, and the summary the extremes of links and periods.

    The top's tension is also given by itself.
    """
    cable = {"model": "straight", "lengths": [1.0, 0.5], "node_masses": [1e-3, 10.0]}
    run = crane_sim.simulate(scene_of(cable, initial={"angles": 1.0}))
    assert run.tensions.shape == (len(run.t), 2) and np.array_equal(run.tension, run.tensions[:, 0])
    # rounding of angles to states
    assert run.tensions == pytest.approx(run.derived.tensions, rel=1e-12)
    assert np.all(run.tensions[:, 1] < run.tension)
    periods = run.tensions[:-1]
    assert run.summary["min_rope_tension"] == np.min(periods) == np.min(periods[:, 1])
    assert run.summary["max_rope_tension"] == np.max(periods) == np.max(run.tension[:-1])
    assert run.summary["negative_tension_steps"] == 0
    assert layout_of_scene(run.scene, "run").ropes.tensions == ("link 1", "link 2")


def test_periods_with_a_cable_that_pushes_are_counted_and_named(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A point that falls faster than its payload pushes it: every such period is counted.

    The terminal says so.
    """
    document = {
        "crane": "pendulum",
        "duration": 0.2,
        "rope": {"length": 1.0},
        "payload": {"mass": 2.0},
    }
    scene = crane_sim.load_scene(
        document | {"suspension": {"drive": "acceleration", "height": "driven"}}
    )
    run = crane_sim.simulate(scene, law=lambda t, q, v: (0.0, 0.0, -3.0 * G if t < 0.0499 else 0.0))
    assert run.summary["negative_tension_steps"] == np.count_nonzero(run.tension < 0.0) == 5
    assert run.summary["min_rope_tension"] == pytest.approx(-4.0 * G)
    print_summary(run.summary, scene)
    assert (
        "the cable was under compression of up to 39.24 N in 5 of 20 periods"
        in capsys.readouterr().out
    )
    print_summary(run.summary | {"negative_tension_steps": 0}, scene)
    assert "pushed" not in capsys.readouterr().out
