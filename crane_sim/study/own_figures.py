"""Further figures of a study's runs, by a function that its file names."""

from functools import lru_cache

from crane_sim.files.errors import SceneError
from crane_sim.files.functions import load_function
from crane_sim.simulation.figured_runs import Measure
from crane_sim.simulation.rollout import Rollout
from crane_sim.study.form import Study


def load_figures(study: Study) -> Measure | None:
    """Return the function of a run that has the study's further figures, None where it asks for none.

    Raises:
        SceneError: there is no such function; when called: it raised an error, or returned what are no numbers by name.
    """
    return _load(study.figures) if study.figures else None


@lru_cache(maxsize=1)
def _load(name: str) -> Measure:
    try:
        function = load_function("study: figures", name)
    except SceneError:
        raise
    except Exception as error:  # of the user's own module: any error of it is one line
        raise SceneError(f"study: figures = {name!r}: {type(error).__name__}: {error}") from error

    def measure(run: Rollout) -> dict[str, float | None]:
        try:
            found = dict(function(run))
            return {str(key): None if value is None else float(value) for key, value in found.items()}
        except Exception as error:
            raise SceneError(f"study: figures = {name!r}: {type(error).__name__}: {error}") from error

    return measure
