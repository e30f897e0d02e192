"""Cost of a recorder: time per lockstep step, and size of the files. `crane bench recording`."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crane_bench.speed.lockstep import lockstep
from crane_bench.speed.measurement import describe_spread, machine, ratio
from crane_sim import load_scene

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

FILES: dict[str, tuple[str, ...]] = {
    "none": (),
    "rrd": ("rrd",),
    "mcap": ("mcap",),
    "rrd and mcap": ("rrd", "mcap"),
}
_MINUTE = 60.0  # s


def _record_run(scene: "Scene", kinds: tuple[str, ...]) -> tuple[float, dict[str, int]]:
    """Return (steps per second, file sizes [bytes] by kind) of a run that writes these kinds."""
    with tempfile.TemporaryDirectory(prefix="crane_sim-") as folder:
        paths = {kind: Path(folder, f"bench.{kind}") for kind in kinds}
        speed = lockstep(scene, paths.get("rrd"), paths.get("mcap"))
        return speed, {kind: path.stat().st_size for kind, path in paths.items()}


def _describe_spreads(found: dict[str, list[float]]) -> dict[str, Any]:
    """Return the spread of each list that has values."""
    return {label: describe_spread(values) for label, values in found.items() if values}


def measure_recording(
    name: str = "knuckle_setpoint",
    duration: float = _MINUTE,
    rounds: int = 5,
    labels: Sequence[str] = tuple(FILES),
) -> dict[str, Any]:
    """Return the time that recording adds to a lockstep step [µs], and the files' size.

    The size is per simulated minute.

    Args:
        name: scene of the catalogue, with a sampled law.
        duration: simulated seconds per run. A file's fixed part (crane, blueprint) counts as part
            of its minute.
        rounds: of every kind of file, interleaved.
        labels: which of `FILES`; "none" is one of them.

    Raises:
        RuntimeError: a run failed; the message is one line.
    """
    scene = load_scene(name, {"duration": duration})
    speeds: dict[str, list[float]] = {label: [] for label in labels}
    sizes: dict[str, list[float]] = {"rrd": [], "mcap": []}
    for _ in range(rounds):
        for label in labels:
            speed, file_sizes = _record_run(scene, FILES[label])
            speeds[label].append(speed)
            for kind, size in file_sizes.items():
                sizes[kind].append(size * _MINUTE / duration)
    added = {
        label: [1e6 / a - 1e6 / b for a, b in zip(speeds[label], speeds["none"], strict=True)]
        for label in labels
        if label != "none"
    }
    ratios = {label: ratio(values, speeds["none"]) for label, values in speeds.items()}
    return {
        "scene": name,
        "steps_per_round": scene.steps,
        "rounds": rounds,
        "steps_per_second": _describe_spreads(speeds),
        "added_us_per_step": _describe_spreads(added),
        "ratio_to_unrecorded": ratios,
        "bytes_per_simulated_minute": _describe_spreads(sizes),
        "machine": machine(),
    }


def format_recording(results: dict[str, Any]) -> list[str]:
    """Return the costs in lines."""
    lines = [
        f"lockstep of {results['scene']}, {results['steps_per_round']} steps, median of "
        f"{results['rounds']} rounds"
    ]
    for label, speed in results["steps_per_second"].items():
        added = results["added_us_per_step"].get(label, {"median": 0.0})["median"]
        times = results["ratio_to_unrecorded"][label]["median"]
        lines.append(
            f"  {label:<14} {speed['median']:6.0f} steps per second, {added:+6.0f} µs per step, "
            f"{times:.2f} x"
        )
    for kind, size in results["bytes_per_simulated_minute"].items():
        lines.append(f"  .{kind:<5} {size['median'] / 1e6:.2f} MB per simulated minute")
    return lines
