"""Scene files, overrides and parameters, mutated at random: a scene, or a one-line error."""

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from document_mutations import DOCUMENTS, MUTATION, NAMES, TEXTS, list_entries, make_nested, mutate
from fuzz_settings import QUICK, explore
from hypothesis import given, settings
from hypothesis import strategies as st

import crane_sim.simulation.linearisation
from crane_sim import SceneError, load_scene
from crane_sim.cli.scene_options import load_scene_with_options
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.linearisation import Accelerations
from crane_sim.tracing import entry_point
from crane_sim.tracing.compile_time import watch_compiling

HANG = 20.0  # s of a processor; the slowest scene takes half a second
LONGEST = 1500  # characters of an error: all keys that a large group has, and a path


def linear(scenes: Sequence[Scene], points: Any, directions: Any) -> Accelerations:
    """Stand in for the equations of motion, which any new set of groups would compile."""
    nq = len(scenes[0].joint_names)
    return Accelerations(oscillation(points, nq), oscillation(directions, nq))


def oscillation(z: Any, nq: int) -> Any:
    """Return u - q - v of rows z (..., 2 nq + nu)."""
    q, v, u = np.split(z, (nq, 2 * nq), axis=-1)
    return u @ np.eye(u.shape[-1], nq) - q - v


@pytest.fixture(scope="module", autouse=True)
def nothing_compiled() -> Iterator[None]:
    """Prevent compilation by the law that evaluates the equations; fail if others compile.

    Functions that thousands of files call some times each run as they stand.
    """
    compilations = list[None]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(crane_sim.simulation.linearisation, "accelerations", linear)
        patch.setattr(entry_point, "INTERPRETED", True)
        for document in DOCUMENTS:
            load_scene(document)
        with watch_compiling(lambda: compilations.append(None)):
            yield
    assert not compilations


def outcome(load: Callable[[], Any]) -> str:
    """Return the one-line error, or nothing for a scene; anything else, or a hang, fails."""
    began, line = time.thread_time(), ""
    try:
        assert isinstance(load(), Scene)
    except SceneError as error:
        line = str(error)
        assert len(line.splitlines()) == 1 and line.encode(), line  # it can be printed, in one line
        assert len(line) < LONGEST, line
        assert "cannot be built" not in line, line  # which only an external law may cause
    assert time.thread_time() - began < HANG
    return line


def check_mutated(which: int, mutations: list[Any]) -> None:
    """Check one mutated scene; a valid one is the same after it was written and read again."""
    document = mutate(DOCUMENTS[which], mutations)
    if not outcome(lambda: load_scene(document)):
        scene = load_scene(document)
        assert load_scene(yaml.safe_load(yaml.safe_dump(scene.to_dict()))) == scene


def check_override(name: str, key: str, text: str) -> None:
    """Check one `--set`."""
    outcome(lambda: load_scene_with_options(name, settings=(f"{key}={text}",)))


def check_text(folder: Path, text: str, edits: list[tuple[int, int, str]]) -> None:
    """Check a file whose text was cut and pasted."""
    for start, length, pasted in edits:
        at = start % (len(text) + 1)
        text = text[:at] + pasted + text[at + length :]
    file = folder / "scene.yaml"
    file.write_bytes(text.encode(errors="surrogatepass"))
    outcome(lambda: load_scene(file))


WHICH = st.integers(0, len(DOCUMENTS) - 1)


MUTATIONS = st.lists(MUTATION, min_size=1, max_size=3)


KEY = st.sampled_from(
    sorted(
        {
            f"{group}.{key}"
            for document in DOCUMENTS
            for group, inner in document.items()
            for _, key in list_entries({0: inner})
            if isinstance(key, str)
        }
    )
)


MARKS = "[ ] { } : - , &a *a !!float !!timestamp !!int << | > ' \" # 2001-99-99 1e999 .nan ~ \n \t".split(  # noqa: E501
    " "
)


PASTED = st.text(max_size=3) | st.sampled_from(MARKS).map(lambda mark: f" {mark} ")


EDITS = st.lists(
    st.tuples(st.integers(0, 10**4), st.integers(0, 40), PASTED), min_size=1, max_size=3
)


@settings(**QUICK)
@given(WHICH, MUTATIONS)
def test_a_mutated_scene(which: int, mutations: list[Any]) -> None:
    """Deletions, duplicates, replacements, transplants leave a scene, or a one-line error."""
    check_mutated(which, mutations)


@settings(**QUICK)
@given(st.sampled_from(NAMES), KEY, PASTED)
def test_an_odd_override(name: str, key: str, text: str) -> None:
    """Any `--set` of any key results in a scene or a single-line error."""
    check_override(name, key, text)


@settings(**QUICK)
@given(st.sampled_from(TEXTS), EDITS)
def test_a_torn_file(tmp_path: Path, text: str, edits: list[Any]) -> None:
    """However a scene file is cut and pasted: it is a scene or an error of one line."""
    check_text(tmp_path, text, edits)


@pytest.mark.long
@pytest.mark.parametrize("part", range(12))
def test_thousands_of_mutated_scenes(part: int) -> None:
    """The same of 6000 scenes, whose seeds are the numbers of the parts."""
    explore(part, check_mutated, WHICH, MUTATIONS)


@pytest.mark.long
@pytest.mark.parametrize("part", range(4))
def test_thousands_of_odd_overrides(part: int) -> None:
    """The same of 2000 overrides."""
    explore(part, check_override, st.sampled_from(NAMES), KEY, PASTED)


@pytest.mark.long
@pytest.mark.parametrize("part", range(4))
def test_thousands_of_torn_files(part: int, tmp_path: Path) -> None:
    """The same of 2000 files."""
    explore(part, check_text, st.just(tmp_path), st.sampled_from(TEXTS), EDITS)


@pytest.mark.parametrize(
    "text",
    [
        *("[" * 5000, "{a: " * 3000, "payload: {mass: " + "[" * 900 + "]" * 900 + "}"),
        *(
            "seed: 2001-99-99",
            "seed: " + "9" * 5000,
            "seed: !!int x",
            "seed: !!float x",
            "seed: !!bool x",
        ),
        *(
            "seed: !!timestamp x",
            "seed: &s [*s]",
            "payload: &p {mass: *p}",
            'name: "a\\nb"',
            'name: "\\ud800"',
            "seed: -1",
        ),
    ],
    ids=lambda text: text[:24],
)
def test_what_was_a_hole_once(text: str, tmp_path: Path) -> None:
    """Files that once crashed the reader or later stages are single-line errors."""
    file = tmp_path / "scene.yaml"
    file.write_text("crane: knuckle\nduration: 1.0\n" * (not text.startswith(("[", "{"))) + text)
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    "source",
    [
        None,
        3,
        [],
        b"x",
        "a" * 5000,
        "\0",
        {"crane": "knuckle", "boom": make_nested(5000)},
        {"crane": "knuckle", "seed": 10**5000},
    ],
    ids=range(8),
)
def test_what_is_no_scene_at_all(source: Any) -> None:
    """An impossible name of a scene is a single-line error, too."""
    assert outcome(lambda: load_scene(source))


@pytest.mark.parametrize("scene", ["offshore_two_rate", "knuckle_setpoint"])
@pytest.mark.parametrize("law", ["adaptive", "harmonic", "cartesian", "angular", "lqr", "energy"])
@pytest.mark.parametrize("settings", [False, 3, "x", [1, 2], None])
def test_settings_that_are_no_group(scene: str, law: str, settings: Any) -> None:
    """A group of a law's settings that is no group is a single-line error, or ignored."""
    groups = {
        f"control.{key}": settings
        for key in ("adaptation", "observer", "vision", "servo", "feedforward")
    }
    for key, value in groups.items():
        outcome(partial(load_scene, scene, {"control.law": law, key: value}))
