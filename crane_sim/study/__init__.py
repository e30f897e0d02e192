"""Studies: one scene with many values of its parameters, under one law or several, as one table.

    result = crane_sim.study.run("config/studies/overhead_masses.yaml", "runs/masses")
    result.table            # pyarrow.Table, a row for each run
    result.differences("residual_swing_deg")

`schema` is that of a study's file, `cases` its runs, `execution` runs them on all cores, `store`
keeps the rows on disk, `statistics` compares variants on the same samples, `recordings` records
selected runs, `tuning` searches gains.
"""

from crane_sim.study.cases import Case, cases
from crane_sim.study.execution import run
from crane_sim.study.result import StudyResult, read_result
from crane_sim.study.schema import Study, load_study
from crane_sim.study.tuning import TuningResult, tune

__all__ = [
    "Case",
    "Study",
    "StudyResult",
    "TuningResult",
    "cases",
    "load_study",
    "read_result",
    "run",
    "tune",
]
