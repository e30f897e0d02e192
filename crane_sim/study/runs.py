"""One run of a study, as the row of its table."""

import json
import time
from collections.abc import Mapping
from functools import cache
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.laws import LawError
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.figures import cell_of, flatten
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.simulation.status import SimulationError
from crane_sim.study.cases import Case
from crane_sim.study.versions import versions

OK, FAILED, REFUSED = "ok", "failed", "refused"
"""Statuses of a row: the run reached its end; it ended before; its scene is not possible."""
PARAMETER, FIRST_COLUMNS = "parameter.", ("case", "sample", "variant", "law", "seed", "status", "error")


def row_of(case: Case, document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the row of a case: its parameters, all figures of its summary, status and error.

    Whatever ends the run is in the row: no error is raised.
    """
    began = time.perf_counter()
    run, status, error = simulate_case(case, document)
    head = {"case": case.number, "sample": case.sample, "variant": case.variant, "law": None}
    row = head | {"seed": case.changes["seed"], "status": status, "error": error}
    row |= {PARAMETER + key: cell_of(value) for key, value in case.parameters.items()}
    if run is not None:
        row |= {"law": run.scene.law_name, "events": len(run.events)} | flatten(run.summary)
    return row | {"versions": _versions(), "wall_time": time.perf_counter() - began}


@cache
def _versions() -> str:
    """Return the versions and the processor of this process in JSON."""
    return json.dumps(versions())


def simulate_case(case: Case, document: Mapping[str, Any]) -> tuple[Rollout | None, str, str | None]:
    """Return (the run, up to where it failed; None without one), its status, and why it is not `ok`."""
    try:
        return simulate(load_scene(document, case.changes)), OK, None
    except SceneError as error:
        return None, REFUSED, str(error)
    except SimulationError as error:
        return error.run, FAILED, str(error)
    except LawError as error:
        return None, FAILED, str(error)
