"""The page of documentation that is written from the benchmark's data file."""

from typing import Any

from crane_bench.speed import tables
from crane_bench.speed.measurement import describe_machine
from crane_bench.speed.suites import SUITES

HEAD = """# Speed against error

Written by `crane bench page --save docs` from [performance.json](performance.json), which `crane bench` keeps. An error
without its time, or a time without its error, is no result here.
"""
FIGURES = {"scenes": "performance.png", "bodies": "performance_bodies.png"}
"""Files of the figures, by suite."""
HOW = """## What was measured, and how

Each engine passes the whole time of a scene over a range of steps or tolerances, every method for itself. The error is
the distance of the payload at the end from a reference whose own error is known: solutions in extended precision by
`make.py` and `knuckle.py` of `test/reference`, which share no code with the simulator. Those that other engines are
compared on are checked by a second method on other equations, the benchmark's for heyoka: Taylor's of order 22 to 29
in numbers of 64 to 113 bits (`test/reference/taylor.py`).

A timing repeats short runs for 2 ms at least; compiling, loading and building models are not timed. What may be the
cheapest at an error, by the least of five timings, is timed in up to 20 more rounds in which all engines take turns, so
that other programs hit all of them; the least time counts. Runs that fail, diverge or are slower stay in the data; a
dash stands where an engine does not reach an error, or the reference cannot tell it (20 times its own error bound).
Take the ratios, not the times: they were measured on a shared virtual machine.

- **crane_sim**: the integrators of the scene files on the compiled equations, without rows of results.
- **hand C** (`crane_bench/speed/floor`): each crane by hand, as fast as we can make it: fused multiply-adds,
  vectors, its own coordinates, a leapfrog method where it pays. It models nothing but its one crane.
- **CasADi C**: the generated right-hand side, in the same C loops.
- **heyoka**: Taylor's method of an order that the tolerance sets, its recurrences compiled; each crane by hand in the
  form that is cheapest for it, chains by their tensions.
- **Pinocchio**: a C++ loop around `aba`. **MuJoCo**, **Drake**: their own steppers and integrators.
  **scipy**: `solve_ivp` over numpy. Each with its best method and setting.
"""
REPEAT = """## How to repeat it

```console
./crane bench                  scenes, this simulator and hand-written C
./crane bench --quick          four of them, under a minute once they are compiled
./crane bench --peers          every engine that is installed: ./crane install peers
./crane bench PART             lockstep, realtime, start, memory, recording, groups, reeving, batch, studies, bodies,
                               campaign, stiff
./crane bench page             writes page and figure anew from the data
```

Results go to `runs/bench` unless `--save FOLDER` names another folder. What was tried to make the simulator faster, and
what it gave, is in [profiling.md](profiling.md).
"""


def format_page(data: dict[str, Any], drawn: bool) -> str:
    """Return the page in Markdown; `drawn`: it has a figure."""
    sections = [HEAD]
    if "scenes" in data:
        picture = f"![work against precision]({FIGURES['scenes']})\n"
        sections += [HOW, _machine(data["scenes"]), *[picture] * drawn]
        sections += [tables.cheapest_table(data["scenes"]), tables.target_table(data["scenes"])]
        sections += [tables.tension_table(data["scenes"]), tables.other_table(data["scenes"])]
    for name, suite in SUITES.items():
        if name in data:
            picture = f"![work against precision]({FIGURES[name]})\n\n" if drawn and name in FIGURES else ""
            lines = "\n".join(suite.format(data[name]))
            sections.append(f"## {suite.title}\n\n{picture}```text\n{lines}\n```\n")
    return "\n".join([*sections, REPEAT])


def _machine(scenes: dict[str, Any]) -> str:
    named = ", ".join(f"{name} {version}" for name, version in scenes["engines"].items())
    lines = [f"Measured on {scenes['date']}: {describe_machine(scenes['machine'])}. Engines: {named}."]
    lines += [f"Not there: {name} ({why})." for name, why in scenes["missing"].items()]
    return "".join(lines) + "\n"
