"""The campaigns of cranebench on our own crane, beside its own runs of them: `crane bench campaign`.

Its planar crane with a hoist, five laws, 500 paired samples of payload, rope, damping and wind: a calm campaign and one
in Kaimal gusts. A cell is the median of a metric over the samples.
"""

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from crane_bench.speed.campaign_laws import LAWS
from crane_bench.speed.campaign_runs import (
    END,
    PAYLOAD,
    ROPE,
    STEP,
    SWING_DAMPING,
    TROLLEY_DAMPING,
    WIND,
    Array,
    CampaignSample,
    make_scenes,
    run_scenes,
)
from crane_bench.speed.engine import EngineUnavailable
from crane_bench.speed.measurement import machine
from crane_bench.speed.peers import cranebench_campaign
from crane_sim.files.errors import SceneError
from crane_sim.files.installation import how_to_install

SAMPLES = 500
WINDS = {"none": "calm", "kaimal": "in gusts"}
"""The campaigns, as cranebench names their wind and as we do."""
AGREED = 5e-4  # relative difference below which three digits agree, but for rounding
REMARKS = (
    "Ours: the overhead crane of a scene (rigid link, winch with inertia, damped joint, wind by relative velocity),",
    "RK4 of 2 ms as theirs, commands every 10 ms. The samples and the records of the wind are theirs, the laws and",
    "metrics our own. Four things differ: the force of their wind is held over a step, ours follows the load within",
    "it; their record is interpolated linearly, ours smoothly; ours has the vertical part of the drag on the moving",
    "load; they update the command once more at the very end, which chatter counts.",
    "Times are seconds of the processor, all threads together: theirs is numpy's, over all samples at once.",
)


def samples_of(design: Any, windy: bool) -> list[CampaignSample]:
    """Return the samples of cranebench's design."""
    factors = design.as_dicts()
    records = cranebench_campaign.wind_records(design, WIND, END) if windy else [None] * len(factors)
    return [
        CampaignSample(
            PAYLOAD * factor["m_payload"],
            ROPE * factor["l0"],
            SWING_DAMPING * factor["c_theta"],
            TROLLEY_DAMPING * factor["b_x"],
            WIND * factor["u_mean"],
            record,
        )
        for factor, record in zip(factors, records, strict=True)
    ]


def run_ours(samples: Sequence[CampaignSample]) -> tuple[dict[str, dict[str, Array]], float]:
    """Return (metrics (n,) by law and name, seconds of the processor) of our campaign; compiling is not timed."""
    run_scenes(make_scenes(samples[:1], LAWS[0]))
    start = time.process_time()
    metrics = {law: run_scenes(make_scenes(samples, law)) for law in LAWS}
    return metrics, time.process_time() - start


def measure_campaign(samples: int = SAMPLES, winds: Sequence[str] = tuple(WINDS)) -> dict[str, Any]:
    """Return the medians of both, cell by cell, and the times.

    Raises:
        SceneError: cranebench is not installed.
    """
    try:
        version = cranebench_campaign.find_cranebench_version()
    except EngineUnavailable as reason:
        raise SceneError(f"bench campaign: {reason}; {how_to_install('peers')}") from None
    campaigns = {wind: _compare(cranebench_campaign.make_design(samples), wind) for wind in winds}
    return {"version": version, "samples": samples, "campaigns": campaigns, "machine": machine()}


def _compare(design: Any, wind: str) -> dict[str, Any]:
    """Return the cells [ours, theirs, their difference and the largest of a sample, relative] and seconds."""
    ours, our_time = run_ours(samples_of(design, wind != "none"))
    theirs, their_time = cranebench_campaign.run_campaign(design, wind, STEP)
    cells = {
        law: {name: _compare_medians(own, np.asarray(theirs[law][name])) for name, own in metrics.items()}
        for law, metrics in ours.items()
    }
    return {"cells": cells, "seconds": {"ours": our_time, "theirs": their_time}}


def _compare_medians(ours: Array, theirs: Array) -> list[float]:
    medians = np.median(ours), np.median(theirs)
    return [*map(float, medians), float(_relative(*medians)), float(np.max(_relative(ours, theirs)))]


def _relative(ours: Any, theirs: Any) -> Any:
    """Return the differences of metrics over theirs, 0 where they are the same."""
    return np.where(ours == theirs, 0.0, np.abs(ours - theirs) / np.maximum(np.abs(theirs), 1e-300))


def format_campaign(results: dict[str, Any]) -> list[str]:
    """Return the cells of both campaigns in lines, with the times."""
    lines = [f"cranebench {results['version']}, planar crane, {results['samples']} paired samples; medians"]
    for wind, campaign in results["campaigns"].items():
        ours, theirs = campaign["seconds"]["ours"], campaign["seconds"]["theirs"]
        runs = results["samples"] * len(campaign["cells"])
        head = f"{WINDS[wind]}: {runs} runs of {END:g} s, ours {ours:.3g} s, theirs {theirs:.4g} s, {theirs / ours:.3g}"
        lines += ["", f"{head} times ours"]
        lines.append(f"  {'law':<5} {'metric':<15} {'ours':>12} {'theirs':>12} {'apart':>8} {'worst sample':>13}")
        for law, metrics in campaign["cells"].items():
            lines += [_describe(law, name, *cell) for name, cell in metrics.items()]
        apart = [cell[2] for metrics in campaign["cells"].values() for cell in metrics.values()]
        agreeing = sum(difference < AGREED for difference in apart)
        lines.append(
            f"  {agreeing} of {len(apart)} medians agree to three digits, the worst differs by {max(apart):.1e}"
        )
    return [*lines, "", *REMARKS]


def _describe(law: str, name: str, ours: float, theirs: float, apart: float, worst: float) -> str:
    return f"  {law:<5} {name:<15} {ours:>12.5g} {theirs:>12.5g} {apart:>8.0e} {worst:>13.0e}"
