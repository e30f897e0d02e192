"""What models and supports must answer: every one that is registered answers all of it."""

import inspect
import pkgutil
import sys
from importlib import import_module
from inspect import getmembers, isclass
from typing import Any

import pytest
from process_helpers import run_to_completion

import crane_sim.models as models
from crane_sim import system

MODULES = [module.name for module in pkgutil.walk_packages(models.__path__, f"{models.__name__}.")]


def name_of(named: Any) -> str:
    """Return the name of a class or function."""
    return named.__name__


def registered_classes(functions: tuple[Any, ...]) -> list[type]:
    """Return the NamedTuples of the folder for which one of the generic functions is registered."""
    classes = {
        kind
        for name in MODULES
        for _, kind in getmembers(import_module(name), isclass)
        if issubclass(kind, tuple)
    }
    return sorted(
        (kind for kind in classes if any(each.has_implementation(kind) for each in functions)),
        key=name_of,
    )


MODELS = registered_classes((*system.MANDATORY, *system.DERIVATIVES, *system.SWITCHES))
STRUCTURES = sorted(
    {
        kind
        for name in MODULES
        for _, kind in getmembers(import_module(name), isclass)
        if issubclass(kind, tuple) and callable(getattr(kind, "mechanism", None))
    },
    key=name_of,
)


def missing_functions(kind: type, functions: tuple[Any, ...]) -> list[str]:
    """Return the names of the generic functions that are not registered for a class."""
    return [name_of(each) for each in functions if not each.has_implementation(kind)]


@pytest.mark.parametrize("model", MODELS, ids=name_of)
def test_every_model_answers_what_it_must(model: type) -> None:
    """A model has all that is mandatory, one form of derivative, and all or no switching."""
    assert not missing_functions(model, system.MANDATORY)
    assert len(missing_functions(model, system.DERIVATIVES)) == 1
    assert missing_functions(model, system.SWITCHES) in ([], list(map(name_of, system.SWITCHES)))


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_every_structure_declares_a_mechanism(structure: type) -> None:
    """A support's structure names its coordinates, and which of them are prescribed.

    Drives that prescribe motions are those.
    """
    assert callable(getattr(structure, "coordinate", None))
    assert hasattr(structure, "prescribe") == (
        name_of(structure) in {"Bridge", "DrivenPoint", "TowerCrane"}
    )


def test_models_and_supports_are_found() -> None:
    """The two tests above have seen the models of the catalogue."""
    overhead = {"RodCrane", "DoubleCrane", "SpringCrane", "PlanarCrane", "ElasticCrane"}
    assert {model.__name__ for model in MODELS} == {
        "Crane",
        "SuspendedCrane",
        "FallsCrane",
        *overhead,
    }
    rigid = {"Bridge", "DrivenPoint", "Knuckle", "TelescopicBoom", "TowerCrane"}
    assert {structure.__name__ for structure in STRUCTURES} == rigid | {
        "FlexibleSupport",
        "SwayingTower",
    }


@pytest.mark.parametrize(
    "function",
    [*system.MANDATORY, *system.SWITCHES[1:]],
    ids=name_of,
)
def test_what_is_mandatory_has_no_default(function: Any) -> None:
    """A model that lacks something fails there, not with numbers of another one."""
    with pytest.raises(NotImplementedError):
        function(*(object() for _ in range(function.__wrapped__.__code__.co_argcount)))


def test_importing_the_models_imports_every_module() -> None:
    """No module of the folder that registers something is left out of its package's import."""
    code = "import sys; import crane_sim.models; print(*sys.modules)"
    imported = run_to_completion([sys.executable, "-c", code], check=True).stdout.split()
    registering = {
        name for name in MODULES if ".register(" in inspect.getsource(import_module(name))
    }
    assert registering <= set(imported)
