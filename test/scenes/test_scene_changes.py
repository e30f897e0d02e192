"""Changes of a scene and other arguments from Python: accepted as meant, or single-line errors."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.cli.scene_options import load_scene_with_options
from crane_sim.simulation.plant import Plant

SWING = crane_sim.load_scene("overhead_swing", {"duration": 0.05})
HEAVY_TROLLEY = {"trolley.mass": 99.0}
Q, V, U = SWING.initial_q, SWING.initial_v, (0.0,) * len(SWING.actuated)


def error_of(call: Callable[[], Any]) -> str:
    """Return the single-line error of a call."""
    with pytest.raises(ValueError) as caught:  # noqa: PT011  the line is what tests look at
        call()
    line = str(caught.value)
    assert "\n" not in line and len(line) < 300
    return line


@pytest.mark.parametrize("law", [HEAVY_TROLLEY, {}, 3, 0.5, ["lqr"], (1.0, 2.0), True], ids=str)
def test_an_invalid_law_is_rejected(law: Any) -> None:
    """A law neither name nor callable is rejected by value, changes with a hint at `overrides`."""
    line = error_of(lambda: crane_sim.simulate(SWING, law))
    assert line.startswith(f"law = {law!r}: must be a name or a callable")
    assert ("overrides=" in line) == isinstance(law, dict)


@pytest.mark.parametrize("source", [SWING, SWING.to_dict()], ids=["scene", "dict"])
def test_simulate_takes_changes_by_dotted_key(source: Any) -> None:
    """`overrides` of `simulate` do what those of `load_scene` do, for each source of a scene."""
    run = crane_sim.simulate(source, overrides=HEAVY_TROLLEY)
    changed = crane_sim.simulate(crane_sim.load_scene(SWING.to_dict(), HEAVY_TROLLEY))
    assert run.scene == changed.scene and run.scene != SWING
    assert np.array_equal(run.q, changed.q) and not np.array_equal(
        run.q, crane_sim.simulate(SWING).q
    )


def test_changes_stay_as_they_were_given() -> None:
    """A group among changes is not altered by another dotted key inside it: it can be reused."""
    group = {"mass": 12.0}
    changes = {"trolley": group, "trolley.mass": 13.0}
    assert crane_sim.load_scene("overhead_swing", changes).document["trolley"]["mass"] == 13.0
    assert group == {"mass": 12.0} and changes["trolley"] is group


def test_a_batch_says_what_was_rounded() -> None:
    """A batch whose duration is no multiple of the period notes each crane's rounded one."""
    batch = crane_sim.simulate_batch(SWING, {"trolley.mass": [90.0, 99.0]}, 0.054)
    assert batch.t.tolist() == [0.05, 0.05]
    assert [notes["rounded"] for notes in batch.notes] == [
        ["duration: 0.054 s is taken as 0.05 s"]
    ] * 2


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (
            lambda: crane_sim.simulate(SWING, overrides={"trolley.mas": 1}),
            "unknown key 'mas', did you mean 'mass'?",
        ),
        (
            lambda: crane_sim.simulate(SWING, overrides=[1, 2]),
            "overrides = [1, 2]: must map dotted keys",
        ),
        (lambda: crane_sim.load_scene("overhead_swing", 5), "overrides = 5: must map dotted keys"),
        (
            lambda: crane_sim.simulate(SWING, "lqr", overrides={"control.law": "energy"}),
            "'control.law' is given by",
        ),
        (
            lambda: crane_sim.simulate(SWING, None, 1.0, overrides={"duration": 2.0}),
            "'duration' is given by name, too",
        ),
        (
            lambda: crane_sim.simulate_batch(SWING, {"duration": [1.0]}, 2.0),
            "duration = 2.0: is among the parameters",
        ),
        (
            lambda: load_scene_with_options("overhead_swing", 1.0, settings=("duration=2",)),
            "--set duration: --duration sets the same key",
        ),
        (
            lambda: load_scene_with_options(
                "overhead_swing", law="lqr", settings=("control.law=x",)
            ),
            "control.law: --law sets the same key",
        ),
    ],
    ids=lambda case: case if isinstance(case, str) else "",
)
def test_invalid_or_contradictory_changes_are_rejected(call: Callable[[], Any], line: str) -> None:
    """An unknown key, changes that are no mapping, and a value set twice are rejected by name."""
    assert line in error_of(call)


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (
            lambda: crane_sim.acceleration(SWING, HEAVY_TROLLEY, V, U),
            "q = {'trolley.mass': 99.0}: must be 2 finite numbers",
        ),
        (lambda: crane_sim.acceleration(SWING, Q, 0.5, U), "v = 0.5: must be 2 finite numbers"),
        (lambda: crane_sim.acceleration(SWING, Q, "12", U), "v = '12': must be 2 finite numbers"),
        (
            lambda: crane_sim.acceleration(SWING, Q, [0.0, np.nan], U),
            "v = [0.0, nan]: must be 2 finite numbers",
        ),
        (lambda: crane_sim.acceleration(SWING, Q, V, [1.0, 2.0]), "u: has 2 values, 1 are needed"),
        (
            lambda: crane_sim.acceleration(SWING, Q, V, U, HEAVY_TROLLEY),
            "t = {'trolley.mass': 99.0}: must be a finite number",
        ),
        (lambda: crane_sim.energy(SWING, None, V), "q = None: must be 2 finite numbers"),
        (
            lambda: Plant("overhead_swing"),
            "scene = 'overhead_swing': must be a Scene, as `crane_sim.load_scene`",
        ),
        (
            lambda: Plant(SWING).advance(1.0),
            "u = 1.0: must be a number for each actuated joint: (x,), a tuple",
        ),
        (
            lambda: Plant(SWING).advance(np.array(1.0)),
            "u = array(1.): must be a number for each actuated joint",
        ),
        (
            lambda: Plant(SWING).advance((1.0, 2.0)),
            "u = (1.0, 2.0): has 2 values; joints that take efforts: trolley",
        ),
        (
            lambda: Plant(SWING.with_external_commands()).advance(),
            "u: is missing; scene overhead_swing takes efforts every period",
        ),
    ],
    ids=lambda case: case if isinstance(case, str) else "",
)
def test_invalid_arguments_are_rejected(call: Callable[[], Any], line: str) -> None:
    """Arguments that are no finite vectors of the right length, or no Scene, are rejected."""
    assert line in error_of(call)
