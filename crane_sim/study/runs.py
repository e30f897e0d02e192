"""Runs of a study, as the rows of its table."""

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.laws import LawError
from crane_sim.scenes.many import load_scenes
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.figured_runs import has_compiled_figures, run_all
from crane_sim.simulation.figures import cell_of, flatten
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.simulation.status import SimulationError
from crane_sim.study.cases import Case
from crane_sim.study.versions import versions

OK, FAILED, REFUSED = "ok", "failed", "refused"
"""Statuses of a row: the run reached its end; it ended before; its scene is not possible."""
PARAMETER, FIRST_COLUMNS = "parameter.", ("case", "sample", "variant", "law", "seed", "status", "error")


def rows_of(cases: Sequence[Case], document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of cases of one study: parameters, all figures of the summary, status and error of each.

    Whatever ends a run is in its row: no error is raised. Scenes that differ in numbers only run in one compiled call;
    a case has the numbers of its single run, bit for bit.
    """
    began = time.perf_counter()
    scenes = load_scenes(document, [case.changes for case in cases])
    ends = iter(_run(scenes))
    rows = [_row(case, scene, *next(ends)) for case, scene in zip(cases, scenes, strict=True)]
    each = (time.perf_counter() - began) / len(cases)
    return [row | {"versions": _versions(), "wall_time": each} for row in rows]


def _run(scenes: Sequence[Any]) -> Iterator[tuple[str, str | None, dict[str, Any] | None]]:
    """Yield status, error, and figures with the number of events of each scene, in order."""
    together = [isinstance(scene, Scene) and has_compiled_figures(scene) for scene in scenes]
    ends = iter(run_all([scene for scene, compiled in zip(scenes, together, strict=True) if compiled]))
    for scene, compiled in zip(scenes, together, strict=True):
        if compiled:
            end = next(ends)
            yield OK if end.error is None else FAILED, end.error, {"events": len(end.events)} | end.figures
        else:
            run, status, error = _simulate(scene)
            yield status, error, None if run is None else {"events": len(run.events)} | flatten(run.summary)


def _row(case: Case, scene: Any, status: str, error: str | None, figures: dict[str, Any] | None) -> dict[str, Any]:
    """Return the row of a case without versions and time."""
    head = {"case": case.number, "sample": case.sample, "variant": case.variant, "law": None}
    row = head | {"seed": case.changes["seed"], "status": status, "error": error}
    row |= {PARAMETER + key: cell_of(value) for key, value in case.parameters.items()}
    return row if figures is None else row | {"law": scene.law_name} | figures


@cache
def _versions() -> str:
    """Return the versions and the processor of this process in JSON."""
    return json.dumps(versions())


def simulate_case(case: Case, document: Mapping[str, Any]) -> tuple[Rollout | None, str, str | None]:
    """Return (the run, up to where it failed; None without one), its status, and why it is not `ok`."""
    return _simulate(load_scenes(document, [case.changes])[0])


def _simulate(scene: Scene | SceneError) -> tuple[Rollout | None, str, str | None]:
    try:
        if isinstance(scene, SceneError):
            return None, REFUSED, str(scene)
        return simulate(scene), OK, None
    except SceneError as error:
        return None, REFUSED, str(error)
    except SimulationError as error:
        return error.run, FAILED, str(error)
    except LawError as error:
        return None, FAILED, str(error)
