"""Tuning of gains: a search for the least metrics over samples, judged on other samples.

Optuna proposes gains, a trial runs the samples, and its values are the means of the objectives. A
trial in which a run fails, or has no such metric, is infeasible; how far it came guides the search.
The best of the Pareto-optimal gains are then run beside the scene's own gains on other samples: a
study like any other, with paired differences.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import yaml

from crane_sim.files.document import get_value, with_values
from crane_sim.files.errors import SceneError
from crane_sim.files.installation import import_optional
from crane_sim.files.output import write_text, write_whole
from crane_sim.study.cases import CaseList, cases
from crane_sim.study.columns import worst_joint
from crane_sim.study.execution import check_metrics, run, run_block
from crane_sim.study.identity import block_needs, hash_of, identity_of, read_identity
from crane_sim.study.recordings import check_worst_metric
from crane_sim.study.runs import OK, Table, each_row
from crane_sim.study.schema import Study, Tune, load_study, scene_document
from crane_sim.study.statistics import CONFIDENCE, PairedDifference
from crane_sim.study.store import SEARCH, load_pyarrow, locked_folder
from crane_sim.study.tuning_checks import (
    base_changes,
    check_search,
    find_objectives,
    trial_document,
)
from crane_sim.study.workers import Workers, start_workers

if TYPE_CHECKING:
    from crane_sim.study.result import StudyResult

JOURNAL, GAINS = "trials.log", "gains.yaml"
"""Files of a search's folder: Optuna's journal of the trials, and the gains that were found."""
SAMPLES_AT_ONCE = 4
"""Samples that a worker runs before its rows are looked at."""
NOT_REACHED = "samples_not_reached"
"""The constraint of a trial: the share of the samples that it did not reach is 0."""
MIN_PAIRS = 6
"""Pairs that a verdict needs: of five, however they differ, Wilcoxon's test has a p-value of 2 /
2^5, more than 5 %."""


class Candidate(NamedTuple):
    """Gains, and the means of the objectives over the samples that they were tuned on."""

    gains: dict[str, float]  # by dotted key
    values: tuple[float, ...]  # by objective


class TuningResult(NamedTuple):
    """What a search has found."""

    front: list[Candidate]  # no other trial is better in all objectives; least first objective
    # first
    chosen: dict[str, Candidate]  # by variant of `held_out`
    trials: int  # that were run
    infeasible: int  # of them: a run failed, or had no such metric
    held_out: StudyResult  # baseline and chosen ones, on samples that the search has not seen
    objectives: tuple[str, ...]
    changes: dict[str, Any]  # of the scene by dotted key in every trial, before the gains


def tune(
    study: Study | str | Path | dict[str, Any],
    folder: str | Path,
    workers: int | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> TuningResult:
    """Search the gains of a study's group `tune`, or go on with the search in the folder.

    Args:
        study: the study, its file, or a dict of a file's shape.
        folder: where trials (trials.log) and the study on held-out samples
            (held_out_TRIALS_keep_KEEP/) go.
        workers: processes; None: one for each core; 1: this process. They change no number.
        on_progress: called with (trials that are done, all trials).

    Raises:
        SceneError: the file is not possible, the folder holds another search, or no trial is a
            candidate.
    """
    load_pyarrow()
    optuna, checked = _load_optuna(), load_study(study)
    settings, training = checked.tune, checked.model_copy(update={"tune": None})
    if settings is None:
        raise SceneError("study: tune is missing: gains, objectives, trials")
    listed, place = check_search(training, settings), Path(folder)
    # else every trial would read its file
    loaded = training.model_copy(update={"scene": scene_document(training)})
    with start_workers(workers, None) as pool:
        if not (place / SEARCH).exists():
            _check_listed(listed)
        with _locked(place, checked):
            search = _search(optuna, checked, loaded, place, pool, on_progress or (lambda *_: None))
            front = _front_of(search)
            chosen = choose(front, settings)
            trials = _count_finished(search)  # more than the study's, where the folder has more
            judging = place / f"held_out_{trials}_keep_{settings.keep}"
            judged = run(_held_out(training, settings, chosen), judging, workers, pool=pool)
            # the newest is that of the gains below, one that was there before, too
            judged.folder.touch()
            gains = {name: changes_of(loaded, settings, chosen[name].gains) for name in chosen}
            _write_gains(place / GAINS, gains)
    infeasible = sum(any(each.constraints.values()) for each in search.trials)
    searched = settings.objectives, settings.changes
    return TuningResult(front, chosen, trials, infeasible, judged, *searched)


def _check_listed(listed: CaseList) -> None:
    """Check that the runs of a search that begins have its metrics."""
    check_metrics(listed)
    check_worst_metric(listed)


def _front_of(search: Any) -> list[Candidate]:
    """Return the Pareto-optimal trials, least first objective first.

    Raises SceneError where no trial is feasible.
    """
    front = sorted(
        (Candidate(each.params, tuple(each.values)) for each in search.best_trials),
        key=lambda each: each[1],
    )
    if not front:
        raise SceneError(
            "study: tune: in every trial a run failed, or had no such metric; widen or move the "
            "ranges"
        )
    return front


def changes_of(training: Study, settings: Tune, gains: dict[str, float]) -> dict[str, Any]:
    """Return all that a trial changes of the scene beside `changes` of the study, by dotted key.

    A list of which a gain is an entry is there as a whole: the scene itself may have none.
    """
    base, document = (
        base_changes(training, settings),
        with_values(trial_document(training, settings), gains),
    )
    return base | {
        key: get_value(document, key)[1] for key in (_list_of(document, gain) for gain in gains)
    }


def _list_of(document: dict[str, Any], key: str) -> str:
    """Return the dotted key of the outermost list around a dotted key, itself without one."""
    parts = key.split(".")
    above = (".".join(parts[:i]) for i in range(1, len(parts)))
    return next((each for each in above if isinstance(get_value(document, each)[1], list)), key)


def _write_gains(file: Path, chosen: dict[str, dict[str, Any]]) -> None:
    """Write changes of the scene by name, a line for each key, as `--set` takes them."""
    blocks = {
        name: [f"  {_in_line(k)}: {_in_line(v)}\n" for k, v in changes.items()]
        for name, changes in chosen.items()
    }
    write_text(
        file, "".join(f"{_in_line(name)}:\n{''.join(lines)}" for name, lines in blocks.items())
    )


def _in_line(value: Any) -> str:
    """Return a value as YAML in one line."""
    plain = json.loads(json.dumps(value))  # tuples as lists
    return (
        yaml.safe_dump(plain, default_flow_style=True, sort_keys=False, width=math.inf)
        .removesuffix("...\n")
        .strip()
    )


def _load_optuna() -> Any:
    optuna = import_optional("optuna", "crane tune")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna


@contextmanager
def _locked(folder: Path, study: Study) -> Iterator[None]:
    """Hold the folder of a search for this process; the lock ends with the process.

    Raises:
        SceneError: another process has the folder, or it holds another search; of the same one
            trials may be more.
    """
    settings = study.tune.model_copy(update={"trials": 1, "keep": 1}) if study.tune else None
    identity, file = (
        hash_of(identity_of(study.model_copy(update={"tune": settings}))),
        folder / SEARCH,
    )
    with locked_folder(folder, "search"):
        if not file.exists():
            write_text(file, json.dumps({"hash": identity}) + "\n")
        if read_identity(file).get("hash") != identity:
            raise SceneError(
                f"folder {folder}: holds another search, or one of other versions or functions; "
                "name another folder"
            )
        for name in (f"{JOURNAL}.lock*", f".{SEARCH}.*", f".{JOURNAL}.*", f".{GAINS}.*"):
            for file in folder.glob(name):  # of a process that ended while it wrote
                file.unlink()
        yield


def _open_search(optuna: Any, study: Study, folder: Path) -> Any:
    """Return the search in a folder, with the trials that are there."""
    # the text of Optuna's lock, a symbolic link, which would dangle else
    file = folder.absolute() / JOURNAL
    _drop_unfinished_line(file)
    journal = optuna.storages.JournalStorage(optuna.storages.journal.JournalFileBackend(str(file)))
    directions = ["minimize"] * len(study.tune.objectives) if study.tune else []
    options = {"study_name": study.name or "tune", "load_if_exists": True, "directions": directions}
    return optuna.create_study(storage=journal, **options)


def _search(
    optuna: Any,
    study: Study,
    training: Study,
    folder: Path,
    pool: Workers,
    on_progress: Callable[[int, int], None],
) -> Any:
    """Return the search after its trials; those that are in the folder are not run again."""
    settings, search = study.tune, _open_search(optuna, study, folder)
    assert settings is not None
    is_waiting = any(trial.state.name == "WAITING" for trial in search.trials)
    if not is_waiting and not _count_finished(search):
        search.enqueue_trial(_own_gains(training, settings))

    def evaluate(trial: Any) -> tuple[float, ...]:
        changes = settings.changes | _suggest_gains(trial, settings)
        values, violation = evaluate_gains(training, changes, settings.objectives, pool)
        trial.set_constraint(NOT_REACHED, violation)
        return values

    def begin_trial(*_: Any) -> None:
        """Give the next trial its own sampler: a resumed search proposes what a whole one does."""
        done = _count_finished(search)
        on_progress(done, settings.trials)
        seed = _seed_of(study.seed, done)
        search.sampler = optuna.samplers.TPESampler(
            seed=seed, multivariate=True, constant_liar=False
        )

    begin_trial()
    search.optimize(evaluate, settings.trials - _count_finished(search), callbacks=[begin_trial])
    return search


def _suggest_gains(trial: Any, settings: Tune) -> dict[str, float]:
    """Return the gains that the search proposes for a trial."""
    return {
        key: trial.suggest_float(key, each.low, each.high, log=each.log)
        for key, each in settings.gains.items()
    }


def _drop_unfinished_line(file: Path) -> None:
    """Cut off the incomplete last line of a journal, which would make the file unreadable."""
    if file.exists() and not (lines := file.read_bytes()).endswith(b"\n"):
        write_whole(file, lambda path: path.write_bytes(lines[: lines.rfind(b"\n") + 1]))


def _own_gains(training: Study, settings: Tune) -> dict[str, float]:
    """Return the scene's own gains that are within their limits: the search begins there."""
    document, own = trial_document(training, settings), dict[str, float]()
    for key, gain in settings.gains.items():
        value = get_value(document, key)[1]
        if (
            isinstance(value, int | float)
            and not isinstance(value, bool)
            and gain.low <= value <= gain.high
        ):
            own[key] = float(value)
    return own


def _count_finished(search: Any) -> int:
    """Return the number of trials that have values; interrupted ones do not count."""
    return sum(trial.state.name == "COMPLETE" for trial in search.get_trials(deepcopy=False))


def _seed_of(seed: int, trial: int) -> int:
    return int.from_bytes(hashlib.sha256(f"tune/{seed}/{trial}".encode()).digest()[:4], "big")


def evaluate_gains(
    training: Study, changes: dict[str, Any], objectives: Sequence[str], pool: Workers
) -> tuple[tuple[float, ...], float]:
    """Return (mean objectives, 0), or (infinities, the share of samples not reached).

    Samples are run in order, and the first one whose run fails or has no such metric ends the
    trial: gains that destabilise a crane make the longest runs.

    Raises:
        SceneError: there is no such metric.
    """
    base = next(iter(training.variant_changes.values()))
    trial = training.model_copy(update={"variants": {"trial": base | changes}})
    task = trial.model_dump_json(), *block_needs(identity_of(trial))
    count, table = len(cases(trial)), list[list[float]]()
    starts = iter(range(0, count, SAMPLES_AT_ONCE))
    pending = deque[Future[Table]]()
    while len(table) < count:
        for start in islice(starts, pool.parallel + 1 - len(pending)):
            end = min(start + SAMPLES_AT_ONCE, count)
            pending.append(pool.executor.submit(run_block, *task, start, end))
        for row in each_row(pending.popleft().result()):
            values = _objectives_of(row, objectives)
            if values is None:
                return (math.inf,) * len(objectives), 1.0 - len(table) / count
            table.append(values)
    return tuple(np.mean(np.array(table, float), axis=0).tolist()), 0.0


def _objectives_of(row: dict[str, Any], objectives: Sequence[str]) -> list[float] | None:
    """Return the objectives of a run as `StudyResult.metric`.

    It is None where the run failed or has no such metric.

    Raises:
        SceneError: there is no such metric.
    """
    if row["status"] != OK:
        return None
    values = find_objectives(row, objectives)
    found = [float(worst_joint(name, own)) for name, own in zip(objectives, values, strict=True)]
    return found if all(map(math.isfinite, found)) else None


def choose(front: list[Candidate], settings: Tune) -> dict[str, Candidate]:
    """Return candidates by name: the best of each objective, and those nearest to the ideal.

    The distance from the ideal is that of objectives scaled to 0 .. 1 over the front.
    """
    values = np.array([each.values for each in front])
    least, spread = values.min(axis=0), np.ptp(values, axis=0)
    distance = np.linalg.norm((values - least) / np.where(spread > 0.0, spread, 1.0), axis=1)
    best = {
        f"least_{name}": int(np.argmin(values[:, i])) for i, name in enumerate(settings.objectives)
    }
    near = {
        f"compromise_{k + 1}": int(i)
        for k, i in enumerate(np.argsort(distance, kind="stable")[: settings.keep])
    }
    chosen: dict[str, Candidate] = {}
    for name, i in (near | best).items():
        if not any(front[i] == other for other in chosen.values()):
            chosen[name] = front[i]
    return chosen


def _held_out(training: Study, settings: Tune, chosen: dict[str, Candidate]) -> Study:
    """Return the study that judges: as many other samples, the baseline first."""
    base, seed = base_changes(training, settings), _seed_of(training.seed, -1)
    tuned = {name: base | candidate.gains for name, candidate in chosen.items()}
    return training.model_copy(update={"variants": training.variant_changes | tuned, "seed": seed})


def summarise(result: TuningResult) -> dict[str, Any]:
    """Return the chosen gains, and how they do on held-out samples beside the baseline."""
    baseline, *_ = variants = list(result.held_out.study.variant_changes)
    held_out = {
        name: {variant: _mean_of(result.held_out, name, variant) for variant in variants}
        for name in result.objectives
    }
    for name, rows in held_out.items():
        for variant, each in result.held_out.differences(name).items():
            rows[variant] |= {"difference": each.mean, "low": each.low, "high": each.high}
            rows[variant]["verdict"] = verdict_on(
                each, rows[variant]["runs"] < rows[baseline]["runs"]
            )
    return {
        "study": result.held_out.study.name,
        "trials": result.trials,
        "infeasible": result.infeasible,
        "objectives": result.objectives,
        "changes": result.changes,
        "chosen": {
            name: {"gains": each.gains, "means": each.values}
            for name, each in result.chosen.items()
        },
        "baseline": baseline,
        "samples": len(result.held_out) // len(variants),
        "held_out": held_out,
    }


def _mean_of(result: StudyResult, metric: str, variant: str) -> dict[str, Any]:
    """Return in how many runs a variant has a metric, and the mean of these."""
    values = result.metric(metric, variant)
    values = values[~np.isnan(values)]
    return {"runs": len(values), "mean": float(np.mean(values)) if len(values) else None}


def verdict_on(difference: PairedDifference, more_failures: bool = False) -> str:
    """Return what the difference of a metric that shall be small says of gains.

    Args:
        difference: from the baseline, on held-out samples.
        more_failures: whether the gains have fewer runs with the metric than the baseline: they are
            no improvement.
    """
    low, high = difference.low, difference.high
    if math.isnan(low) or math.isnan(
        high
    ):  # of differences that hardly vary the bootstrap has no interval
        low = high = difference.mean if difference.p_value < 1.0 - CONFIDENCE else 0.0
    enough = difference.pairs >= MIN_PAIRS
    if enough and low > 0.0:
        return "worse"
    if more_failures:
        return "more failures"
    if not enough:
        return "too few samples"
    return "improved" if high < 0.0 else "no difference shown"
