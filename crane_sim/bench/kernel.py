"""One RK4 step of the knuckle crane with its law inside, against the same step written by hand in C.

`python -m crane_sim.bench.kernel` compiles the C file beside this one, runs both in turn, checks that they compute the
same motion, and prints the time of a step.
"""

import ctypes
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from crane_sim import outputs as _outputs  # noqa: F401  registers what a crane shows
from crane_sim import system
from crane_sim.explain import SceneError
from crane_sim.integrators import step
from crane_sim.integrators.rk4 import RK4
from crane_sim.jit import entry
from crane_sim.scene import Scene, load_scene

STEP = 1e-3  # s
STEPS = 40_000
ROUNDS = 25
FLAGS = ("-O3",)


@entry
def run(method, p, x, law, h, steps):
    """Return the state after `steps` steps of size h."""
    for i in range(steps):
        x = step(method, p, i * h, x, law, h)
    return x


@entry
def start_state(p, q, v):
    """Compiled `system.state`."""
    return system.state(p, 0.0, q, v)


def compiled_c(folder: Path) -> Any:
    """Return the C function, compiled into `folder`.

    Raises:
        SceneError: there is no compiler.
    """
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise SceneError("no C compiler found (cc, gcc, clang); install one to measure the floor")
    library = folder / "knuckle.so"
    source = Path(__file__).with_name("knuckle.c")
    subprocess.run([compiler, *FLAGS, "-shared", "-fPIC", str(source), "-lm", "-o", str(library)], check=True)
    function = ctypes.CDLL(str(library)).run
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_long]
    return function


def c_parameters(scene: Scene) -> np.ndarray:
    """Return the numbers of the scene in the order of the C struct."""
    boom, jib, law = scene.model.support.boom, scene.model.support.jib, scene.document["control"]
    rods = [boom.length, boom.mass, boom.inertia, jib.length, jib.mass, jib.inertia]
    rest = [scene.model.support.tower.inertia, scene.model.load.mass, scene.model.gravity]
    return np.array([*rods, *rest, *law["kp"], *law["kd"], *(scene.reference or ())])


def measure() -> dict[str, Any]:
    """Return nanoseconds per step (median, minimum) of both, their ratio, and how far apart they end [m]."""
    scene = load_scene("knuckle_setpoint")
    method, x0 = RK4(STEP), start_state(scene.model, scene.initial_q, scene.initial_v)
    parameters, times, y = c_parameters(scene), {"python": [], "c": []}, np.empty(12)
    with tempfile.TemporaryDirectory() as folder:
        c = compiled_c(Path(folder))
        x = run(method, scene.model, x0, scene.law, STEP, 1)
        for _ in range(ROUNDS):
            began = time.perf_counter()
            x = run(method, scene.model, x0, scene.law, STEP, STEPS)
            times["python"].append((time.perf_counter() - began) / STEPS * 1e9)
            y = np.array([*x0[0][:3], *x0[1][:3], *x0[0][3:], *x0[1][3:]])
            began = time.perf_counter()
            c(parameters.ctypes.data, y.ctypes.data, STEP, STEPS)
            times["c"].append((time.perf_counter() - began) / STEPS * 1e9)
    figures = {name: (statistics.median(values), min(values)) for name, values in times.items()}
    ratios = [a / b for a, b in zip(times["python"], times["c"], strict=True)]
    apart = float(np.max(np.abs(np.array(x[1][:3]) - y[3:6])))
    return {"ns": figures, "ratio": statistics.median(ratios), "apart": apart}


def main() -> int:
    """Print the comparison."""
    try:
        found = measure()
    except SceneError as error:
        print(error, file=sys.stderr)
        return 2
    print(
        f"RK4 step of the knuckle crane, energy law in every stage, {platform.machine()}, {ROUNDS} rounds interleaved"
    )
    for name, label in (("python", "crane_sim (numba)"), ("c", f"C, cc {' '.join(FLAGS)}")):
        median, least = found["ns"][name]
        print(f"  {label:<20} {median:6.0f} ns per step (least {least:.0f})")
    print(f"  ratio (median of pairs) {found['ratio']:.2f}; the two end {found['apart']:.1e} m apart after 40 s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
